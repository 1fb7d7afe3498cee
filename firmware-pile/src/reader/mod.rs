//! The RFID readers.
//!
//! A reader turns bytes into [`Seen`], which are inputs of the pile. Whatever else the bytes are,
//! they cost at most the reply they hit.

pub mod r200;

use crate::pile::{Input, TagRead};

/// What a reader says of its field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// Nothing is in it.
    Nothing,
    /// A tag is.
    Tag(TagRead),
}

impl From<Seen> for Input<'_> {
    fn from(seen: Seen) -> Self {
        match seen {
            Seen::Nothing => Self::ReaderIdle,
            Seen::Tag(read) => Self::Tag(read),
        }
    }
}
