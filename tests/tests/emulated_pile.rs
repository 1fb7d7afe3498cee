//! The pile's image in QEMU: the real binary, real frames on its link, real reader frames on the
//! UART of its RFID reader.
//!
//! Where QEMU or the image is missing these tests fail with the sentence that says how to get it.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[path = "emulated_pile/charge.rs"]
mod charge;
#[path = "emulated_pile/desk.rs"]
mod desk;
#[path = "emulated_pile/frames.rs"]
mod frames;
#[path = "emulated_pile/hazards.rs"]
mod hazards;
#[path = "emulated_pile/memory.rs"]
mod memory;
#[path = "emulated_pile/provisioning.rs"]
mod provisioning;
