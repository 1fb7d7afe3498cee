//! What must bear whatever a wire, a reader or a flash holds. `cargo xtask fuzz` builds and runs it.
//!
//! One module a target: `run` takes any input, panics if a promise is broken, and says how much it
//! tried and how much of that was accepted. `fuzz_targets/` hands it to libFuzzer.
//!
//! | target | the input is | what is promised |
//! |---|---|---|
//! | [`deframer`] | a stream of bytes | the same packets as by splitting at delimiters |
//! | [`decoder`] | header and body of an intact frame, and damage to it | messages come back as they were; what was changed or repeated is not believed |
//! | [`r200`] | what a UHF reader sends | only tags that were sent; what follows is read |
//! | [`mfrc522`] | what an MFRC522 answers on its bus | a bounded poll, no tag that was not sent |
//! | [`maps`] | a file that is said to be a map, or queries on one | a grid, or an error; what is written is read again; queries lie on their map |
//! | [`mod@store`] | what a flash holds, and what is done with it | it loads; what was kept is there; a cut costs the record under way |
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a panic is a finding")]

pub mod decoder;
pub mod deframer;
pub mod maps;
pub mod mfrc522;
pub mod r200;
pub mod store;
pub mod tried;

/// The store's own tests have the flash, and things to keep in it.
#[path = "../../firmware-pile/tests/store/flash.rs"]
#[allow(dead_code, missing_docs)]
mod flash;
#[path = "../../firmware-pile/tests/store/samples.rs"]
#[allow(dead_code, missing_docs)]
mod samples;
