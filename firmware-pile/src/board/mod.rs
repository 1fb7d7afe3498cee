//! The boards a pile runs on: pins, clocks and drivers, nothing that decides.
//!
//! Each board gives the tasks of [`crate::tasks`] what they are generic over: a link to the
//! coordinator, an RFID reader, a charger, a memory, a clock.

#[cfg(feature = "emulated")]
pub mod emulated;
#[cfg(feature = "stm32")]
pub mod stm32;
