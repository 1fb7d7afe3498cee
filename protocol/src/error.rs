//! What can be wrong with bytes from a wire.

use crate::{ids::DeviceId, version};

/// Why the bytes between two delimiters are no frame, or none to be believed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FrameError {
    /// More bytes than any frame has; the rest up to the next delimiter is discarded.
    #[error("frame longer than {} bytes: noise, or a lost delimiter", crate::limits::FRAME)]
    Oversize,
    /// Not COBS, or shorter than header and check.
    #[error("frame garbled or cut short")]
    Garbled,
    /// The check does not match.
    #[error("frame damaged: its CRC-32 does not match")]
    Crc,
    /// The sender speaks a version we do not.
    #[error(
        "frame of protocol version {version}, but this side speaks {}..={}: update the older side",
        version::MIN,
        version::CURRENT
    )]
    Version {
        /// The frame's.
        version: u8,
    },
    /// The header names no known kind of device, or no known seal.
    #[error("frame from an unknown kind of device, or with an unknown seal ({kind:#04x})")]
    DeviceKind {
        /// The byte in the header.
        kind: u8,
    },
    /// The body is no message: unknown kind, value out of range, or bytes left over.
    #[error("frame intact, but its body is no message of this version")]
    Body,
    /// It has no seal, and this side believes only sealed frames.
    #[error(
        "frame of {sender} without a seal: give {sender} its key (`chargehand provision` for a pile, \
         `chargehand keys` for a robot)"
    )]
    Unsealed {
        /// Who it says it is from.
        sender: DeviceId,
    },
    /// It has a seal, and this side runs without keys.
    #[error("frame of {sender} is sealed, but this side runs `insecure`: give it the keys")]
    Sealed {
        /// Who it says it is from.
        sender: DeviceId,
    },
    /// This side has no key for its sender.
    #[error("frame of {sender}, for which this side has no key")]
    Stranger {
        /// Who it says it is from.
        sender: DeviceId,
    },
    /// Its MAC does not hold.
    #[error(
        "frame of {sender} does not authenticate: another key, or meant for an earlier start of this side"
    )]
    Unauthentic {
        /// Who it says it is from.
        sender: DeviceId,
    },
    /// It is not newer than the last frame of its sender in the same start: repeated, or late.
    #[error("frame of {sender} is not newer than its last: repeated on the way, or recorded and sent again")]
    Replayed {
        /// Who it is from.
        sender: DeviceId,
    },
    /// It is of an earlier start of its sender than the last.
    #[error(
        "frame of {sender} of an earlier start than its last: recorded, or {sender}'s count of starts went \
         back; restart this side if it did"
    )]
    EarlierStart {
        /// Who it is from.
        sender: DeviceId,
    },
    /// It is sealed with the site's key and is no gossip.
    #[error("frame of {sender} has the site's seal, but is not gossip")]
    NotGossip {
        /// Who it says it is from.
        sender: DeviceId,
    },
}

/// A message does not fit a frame. [`crate::limits`] proves that none is too large, so this is
/// never seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[error("message does not fit a frame")]
pub struct EncodeError;

/// A message cannot be sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SealError {
    /// The recipient's start is not known: nothing but `Hello` can be said to it until it was heard.
    #[error("{peer} was not heard since this side's start: only Hello can be said to it")]
    Unheard {
        /// The recipient.
        peer: DeviceId,
    },
    /// This side has no key for the recipient.
    #[error("there is no key for {peer}")]
    Stranger {
        /// The recipient.
        peer: DeviceId,
    },
    /// This side does not have the site's key.
    #[error("there is no site key to seal gossip with")]
    NoSiteKey,
    /// All numbers of this start are used up.
    #[error("2^32 frames were sent in this start: restart")]
    Exhausted,
    /// See there.
    #[error(transparent)]
    Encode(#[from] EncodeError),
}
