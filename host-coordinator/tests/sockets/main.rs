//! The coordinator over real sockets, in this process and as a program of its own.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod api;
mod crash;
mod loopback;
mod udp_world;
