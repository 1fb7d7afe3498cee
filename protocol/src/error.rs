//! What can be wrong with bytes from a wire.

use crate::version;

/// Why the bytes between two delimiters are no frame.
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
    /// The header names no known kind of device.
    #[error("frame from an unknown kind of device ({kind})")]
    DeviceKind {
        /// The byte in the header.
        kind: u8,
    },
    /// The body is no message: unknown kind, value out of range, or bytes left over.
    #[error("frame intact, but its body is no message of this version")]
    Body,
}

/// A message does not fit a frame. [`crate::limits`] proves that none is too large, so this is
/// never seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("message does not fit a frame")]
pub struct EncodeError;
