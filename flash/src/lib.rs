//! Checks the image of a board against the map of its chip, and flashes it with probe-rs.
//!
//! | module | one idea |
//! |---|---|
//! | [`mod@chip`] | the STM32F407VG's memories and flash sectors, as probe-rs knows them |
//! | [`image`] | an ELF file: what is loaded where, and the store's place |
//! | [`mod@check`] | whether the image can start, stays in its memories, and leaves the store alone |
//! | [`probe`] | onto the board |

pub mod check;
pub mod chip;
pub mod image;
pub mod probe;

pub use check::{Problem, check};
pub use chip::Chip;
pub use image::{Image, ImageError};
