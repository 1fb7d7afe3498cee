//! Header, CRC and COBS around a message.
//!
//! ```text
//!  0x00 | COBS( packet ) | 0x00
//!
//!  packet   0        1      2        4            8          12      n-4
//!           version  kind   number   boot epoch   sequence   body    CRC-32
//! ```
//! All numbers are little-endian. The CRC-32 (ISO-HDLC, as in Ethernet) covers header and body.
//! The header is frozen: every version starts with it.
//!
//! One message has several encodings, as COBS and postcard's varints can be written longer than
//! needed. That is harmless: the CRC covers the bytes that were sent, and nothing compares messages
//! by their bytes. [`Frame::encode`] writes the shortest.

use heapless::Vec;

use crate::{
    error::{EncodeError, FrameError},
    ids::{BootEpoch, DeviceId, PileId, RobotId, Sequence},
    limits,
    message::Message,
    version,
};

const CRC: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);

/// Separates frames; COBS keeps it out of them.
pub const DELIMITER: u8 = 0x00;

/// A frame as it goes over the wire, both delimiters included.
pub type FrameBytes = Vec<u8, { limits::FRAME }>;

/// Who sent a frame, and which of its frames it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Header {
    /// The protocol version of the body.
    pub version: u8,
    /// Who sent it.
    pub sender: DeviceId,
    /// The sender's start.
    pub boot: BootEpoch,
    /// The sender's frames since then.
    pub sequence: Sequence,
}

impl Header {
    /// A header of the current version.
    #[must_use]
    pub const fn new(sender: DeviceId, boot: BootEpoch, sequence: Sequence) -> Self {
        Self { version: version::CURRENT, sender, boot, sequence }
    }

    fn to_bytes(self) -> [u8; limits::HEADER] {
        let (kind, number) = match self.sender {
            DeviceId::Coordinator => (0, 0),
            DeviceId::Pile(PileId(number)) => (1, number),
            DeviceId::Robot(RobotId(number)) => (2, number),
            DeviceId::Chassis(RobotId(number)) => (3, number),
            DeviceId::Service => (4, 0),
            DeviceId::Factory => (5, 0),
        };
        let [n0, n1] = u16::to_le_bytes(number);
        let [b0, b1, b2, b3] = self.boot.0.to_le_bytes();
        let [s0, s1, s2, s3] = self.sequence.0.to_le_bytes();
        [self.version, kind, n0, n1, b0, b1, b2, b3, s0, s1, s2, s3]
    }

    fn from_bytes(bytes: [u8; limits::HEADER]) -> Result<Self, FrameError> {
        let [version, kind, n0, n1, b0, b1, b2, b3, s0, s1, s2, s3] = bytes;
        let number = u16::from_le_bytes([n0, n1]);
        let sender = match kind {
            0 => DeviceId::Coordinator,
            1 => DeviceId::Pile(PileId(number)),
            2 => DeviceId::Robot(RobotId(number)),
            3 => DeviceId::Chassis(RobotId(number)),
            4 => DeviceId::Service,
            5 => DeviceId::Factory,
            kind => return Err(FrameError::DeviceKind { kind }),
        };
        Ok(Self {
            version,
            sender,
            boot: BootEpoch(u32::from_le_bytes([b0, b1, b2, b3])),
            sequence: Sequence(u32::from_le_bytes([s0, s1, s2, s3])),
        })
    }
}

/// A message and who sent it.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Frame {
    /// Who sent it.
    pub header: Header,
    /// What it says.
    pub message: Message,
}

impl Frame {
    /// The frame's bytes, both delimiters included.
    ///
    /// # Errors
    /// [`EncodeError`] if the message is larger than [`limits::BODY`], which no message is.
    pub fn encode(&self) -> Result<FrameBytes, EncodeError> {
        let mut packet = [0; limits::PACKET];
        let (header, rest) = packet.split_at_mut(limits::HEADER);
        header.copy_from_slice(&self.header.to_bytes());
        let body = postcard::to_slice(&self.message, rest).map_err(|_| EncodeError)?.len();
        let end = limits::HEADER + body;
        let check = CRC.checksum(packet.get(..end).ok_or(EncodeError)?);
        packet.get_mut(end..end + limits::CHECK).ok_or(EncodeError)?.copy_from_slice(&check.to_le_bytes());
        let packet = packet.get(..end + limits::CHECK).ok_or(EncodeError)?;

        let mut bytes = FrameBytes::new();
        bytes.resize_default(limits::FRAME).map_err(|_| EncodeError)?;
        let length = cobs::try_encode_including_sentinels(packet, &mut bytes).map_err(|_| EncodeError)?;
        bytes.truncate(length);
        Ok(bytes)
    }

    /// Reads what stood between two delimiters, undoing COBS in place. Of a version that is not
    /// spoken here it reads a `Hello`, whatever that version has added behind, and nothing else.
    ///
    /// # Errors
    /// [`FrameError`] says what is wrong with it.
    pub fn decode(between: &mut [u8]) -> Result<Self, FrameError> {
        let length = cobs::decode_in_place(between).map_err(|_| FrameError::Garbled)?;
        let packet = between.get(..length).ok_or(FrameError::Garbled)?;
        let (content, check) = packet.split_last_chunk::<{ limits::CHECK }>().ok_or(FrameError::Garbled)?;
        let (header, body) = content.split_first_chunk::<{ limits::HEADER }>().ok_or(FrameError::Garbled)?;
        if CRC.checksum(content) != u32::from_le_bytes(*check) {
            return Err(FrameError::Crc);
        }
        let &[version, ..] = header;
        let spoken = version::OURS.contains(version);
        // Nothing else can be said of a version that nobody here knows.
        let unreadable = |error| if spoken { error } else { FrameError::Version { version } };
        let header = Header::from_bytes(*header).map_err(unreadable)?;
        match postcard::take_from_bytes(body) {
            Ok((message, [])) if spoken => Ok(Self { header, message }),
            // Frozen: a later version may add to it, but only behind.
            Ok((message @ Message::Hello(_), _)) if !spoken => Ok(Self { header, message }),
            _ => Err(unreadable(FrameError::Body)),
        }
    }
}

/// Puts a device's messages into frames and counts them.
#[derive(Clone, Debug)]
pub struct FrameWriter {
    next: Header,
}

impl FrameWriter {
    /// A writer for `sender` in its start `boot`.
    #[must_use]
    pub const fn new(sender: DeviceId, boot: BootEpoch) -> Self {
        Self { next: Header::new(sender, boot, Sequence(0)) }
    }

    /// The bytes of the next frame.
    ///
    /// # Errors
    /// As [`Frame::encode`].
    pub fn write(&mut self, message: Message) -> Result<FrameBytes, EncodeError> {
        let bytes = Frame { header: self.next, message }.encode()?;
        self.next.sequence.0 = self.next.sequence.0.wrapping_add(1);
        Ok(bytes)
    }
}
