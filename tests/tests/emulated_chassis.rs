//! The chassis' image in QEMU: the real binary, real frames on its link, real frames of its RFID
//! reader, and the model of motors and vehicle behind its drivers, all on the ARM core.
//!
//! Where QEMU or the image is missing these tests fail with the sentence that says how to get it.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[path = "emulated_chassis/square.rs"]
mod square;
#[path = "emulated_chassis/steps.rs"]
mod steps;
#[path = "emulated_chassis/stops.rs"]
mod stops;
