//! Kills `chargehand run` 200 times: what the tests do a few times.
//!
//! `cargo xtask crash-loop`.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[path = "../tests/sockets/crash.rs"]
mod crash;
#[path = "../tests/sockets/udp_world.rs"]
#[allow(dead_code)]
mod udp_world;

fn main() {
    crash::kill_again_and_again(200);
}
