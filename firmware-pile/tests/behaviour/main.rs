//! The pile as the world sees it: inputs and the passing of time go in, commands and messages
//! come out.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod bench;
mod charging;
mod claims;
mod clearing;
mod expiry;
mod faults;
mod leases;
mod passing;
mod properties;
mod service;
mod talking;
mod witness;
