//! The chassis as the robot's computer and its motors see it: commands and what sensors say go in,
//! duties and messages come out. [`bench`] closes the loop over a model of the robot.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod bench;
mod commands;
mod faults;
mod passing;
mod properties;
mod square;
mod steps;
mod stops;
mod talking;
