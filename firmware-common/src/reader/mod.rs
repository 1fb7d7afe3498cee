//! The RFID readers.
//!
//! A reader turns bytes into [`Seen`], which are inputs of a board's core. Whatever else the bytes
//! are, they cost at most the reply they hit.

pub mod r200;

use protocol::TagId;

/// What a reader says of its field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// Nothing is in it.
    Nothing,
    /// A tag is.
    Tag(TagRead),
}

/// A tag the reader has read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TagRead {
    /// Which.
    pub tag: TagId,
    /// How strong its signal was.
    pub rssi_dbm: i8,
}
