//! What the tests that cross crates share: a board in QEMU, and the log it writes.

pub mod emulator;
