//! The boards a chassis runs on: pins, clocks and drivers, nothing that decides.
//!
//! Each gives [`crate::tasks`] what it is generic over.

#[cfg(feature = "emulated")]
pub mod emulated;
#[cfg(feature = "stm32")]
pub mod stm32;
