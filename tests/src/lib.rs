//! What the tests that cross crates share: a board in QEMU with its log, and what is wired to it.

pub mod board_line;
pub mod chassis_bench;
pub mod emulator;
pub mod labwired;
pub mod pile_bench;
pub mod uhf_reader;
