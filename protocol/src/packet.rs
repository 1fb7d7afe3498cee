//! A frame without its delimiters and COBS, found intact and not yet believed.
//!
//! That its CRC-32 matches says that nothing was damaged on the way, and nothing of who sent it: only
//! [`Sessions::open`](crate::auth::Sessions::open) makes a [`Frame`](crate::Frame) of it.

use crate::{
    auth::seal::{Mac, Seal},
    error::FrameError,
    frame::{CRC, Header, HeaderError},
    limits,
    message::Message,
    version,
};

/// An intact frame of which nobody knows yet who sent it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Packet<'a> {
    header: Header,
    seal: Seal,
    /// Header and body as they were sent.
    content: &'a [u8],
    /// Empty without a seal.
    mac: &'a [u8],
}

impl<'a> Packet<'a> {
    /// Reads what stood between two delimiters, undoing COBS in place.
    ///
    /// # Errors
    /// [`FrameError`] says what is wrong with it.
    pub fn decode(between: &'a mut [u8]) -> Result<Self, FrameError> {
        let length = cobs::decode_in_place(between).map_err(|_| FrameError::Garbled)?;
        let packet = between.get(..length).ok_or(FrameError::Garbled)?;
        let (checked, check) = packet.split_last_chunk::<{ limits::CHECK }>().ok_or(FrameError::Garbled)?;
        let header = checked.first_chunk::<{ limits::HEADER }>().ok_or(FrameError::Garbled)?;
        if CRC.checksum(checked) != u32::from_le_bytes(*check) {
            return Err(FrameError::Crc);
        }
        let (header, seal) = Header::from_bytes(*header).map_err(|HeaderError { version, kind }| {
            // Nothing else can be said of a version that nobody here knows.
            if version::OURS.contains(version) {
                FrameError::DeviceKind { kind }
            } else {
                FrameError::Version { version }
            }
        })?;
        let mac_at = checked.len().checked_sub(seal.mac_size()).filter(|&at| at >= limits::HEADER);
        let (content, mac) =
            checked.split_at_checked(mac_at.ok_or(FrameError::Garbled)?).ok_or(FrameError::Garbled)?;
        Ok(Self { header, seal, content, mac })
    }

    /// Who it says that it is from.
    #[must_use]
    pub const fn header(&self) -> Header {
        self.header
    }

    pub(crate) const fn seal(&self) -> Seal {
        self.seal
    }

    pub(crate) const fn content(&self) -> &'a [u8] {
        self.content
    }

    pub(crate) fn mac(&self) -> Option<&'a Mac> {
        self.mac.try_into().ok()
    }

    /// Whether its body begins as a `Hello` does.
    pub(crate) fn is_hello(&self) -> bool {
        self.content.get(limits::HEADER) == Some(&0)
    }

    /// What it says. Of a version that is not spoken here a `Hello` is read, whatever that version
    /// has added behind, and nothing else.
    pub(crate) fn message(&self) -> Result<Message, FrameError> {
        let version = self.header.version;
        let spoken = version::OURS.contains(version);
        let body = self.content.get(limits::HEADER..).unwrap_or_default();
        match postcard::take_from_bytes(body) {
            Ok((message, [])) if spoken => Ok(message),
            // Frozen: a later version may add to it, but only behind.
            Ok((message @ Message::Hello(_), _)) if !spoken => Ok(message),
            _ if spoken => Err(FrameError::Body),
            _ => Err(FrameError::Version { version }),
        }
    }
}
