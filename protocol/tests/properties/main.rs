//! What holds for every message, every stream of bytes and every damage to them.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod bytes;
mod damage;
mod largest;
mod sessions;
mod sizes;
mod strategies;
mod stream;
mod units;
mod values;
mod versions;
