//! The store under every loss of power, its room and its wear.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod charge;
mod cuts;
mod flash;
mod room;
mod samples;
