//! The charging pile: its behaviour as a pure no_std core, and the boards it runs on.
#![cfg_attr(not(test), no_std)]

#[cfg(all(target_arch = "arm", target_os = "none"))]
pub mod board;
