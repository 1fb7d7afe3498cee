//! The boards a pile runs on: pins, clocks and drivers, nothing that decides.
//!
//! Each board gives the tasks of [`crate::tasks`] what they are generic over: a link to the
//! coordinator, the UART of an RFID reader, a charger, a clock. There is one today, which QEMU
//! emulates; the board that is flashed comes beside it.

#[cfg(feature = "emulated")]
pub mod emulated;
