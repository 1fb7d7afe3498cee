//! What LMPP remembers, taken to its end: the ways to every known place, planned once.
//!
//! | module | one idea |
//! |---|---|
//! | [`banks`] | the paper's memory banks M1 and M2: paths between piles and doors |
//! | [`fields`] | the exact way from every cell to every known target, a walk through memory |
//!
//! Fields are built ([`fields::Fields::build`]) many at a time by sweeps over the map, repaired one by one
//! where it changes, and kept as the bytes of a file.

pub mod banks;
mod build;
pub mod fields;
mod file;
mod frontier;
mod image;
mod metric;
mod repair;
mod sweep;
mod table;

pub use banks::{Banks, Direction, DoorSets, Leg, Target};
pub use fields::{Bytes, Fields, Repaired};
pub use file::FileError;
pub use image::Memory;
