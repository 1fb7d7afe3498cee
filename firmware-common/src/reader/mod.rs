//! The RFID readers.
//!
//! A reader turns bytes into [`Seen`], which are inputs of a board's core. Whatever else the bytes
//! are, they cost at most the reply they hit.
//!
//! | kind | field | a tag's name | signal strength |
//! |---|---|---|---|
//! | [`r200`] | metres, UHF | its 96-bit EPC | measured |
//! | [`mfrc522`] | centimetres, 13.56 MHz | its UID, see [`mfrc522::tag_of`] | [`mfrc522::RSSI_DBM`] |
//!
//! A board is fitted with one of the two. With both, a robot with a tag of each kind would look like
//! two robots, and no charge would begin.

pub mod mfrc522;
pub mod r200;

use core::fmt;

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

/// A reader of any kind.
pub trait TagReader {
    /// What can go wrong, for the log.
    type Error: fmt::Display;

    /// Asks once what is in the field and hands out what the reader says, and what goes wrong. A
    /// silent reader may keep it waiting: give it a timeout. Dropping it loses nothing that was
    /// received.
    fn poll(&mut self, found: impl FnMut(Result<Seen, Self::Error>)) -> impl Future<Output = ()>;
}
