//! Header, seal, CRC and COBS around a message.
//!
//! ```text
//!  0x00 | COBS( packet ) | 0x00
//!
//!  packet   0        1      2        4            8          12      n-20   n-4
//!           version  kind   number   boot epoch   sequence   body    MAC    CRC-32
//! ```
//! All numbers are little-endian. The two upper bits of the kind say how the frame is
//! [sealed](crate::auth); without a seal there is no MAC. The CRC-32 (ISO-HDLC, as in Ethernet)
//! covers all before it: noise and a wrong key are told apart. Header and seal are frozen: every
//! version starts and ends like this.
//!
//! One message has several encodings, as COBS and postcard's varints can be written longer than
//! needed. That is harmless: CRC and MAC cover the bytes that were sent, and nothing compares
//! messages by their bytes. What is written here is the shortest.

use heapless::Vec;

use crate::{
    auth::seal::{Seal, Sealing},
    error::EncodeError,
    ids::{BootEpoch, DeviceId, PileId, RobotId, Sequence},
    limits,
    message::Message,
    version,
};

pub(crate) const CRC: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);

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
    /// The sender's frames to the same receiver since then.
    pub sequence: Sequence,
}

/// A header with a kind of device that nobody here knows.
pub(crate) struct HeaderError {
    pub version: u8,
    pub kind: u8,
}

impl Header {
    /// A header of the current version.
    #[must_use]
    pub const fn new(sender: DeviceId, boot: BootEpoch, sequence: Sequence) -> Self {
        Self { version: version::CURRENT, sender, boot, sequence }
    }

    fn to_bytes(self, seal: Seal) -> [u8; limits::HEADER] {
        let [kind, n0, n1] = device_bytes(self.sender);
        let [b0, b1, b2, b3] = self.boot.0.to_le_bytes();
        let [s0, s1, s2, s3] = self.sequence.0.to_le_bytes();
        [self.version, kind | seal.bits(), n0, n1, b0, b1, b2, b3, s0, s1, s2, s3]
    }

    pub(crate) fn from_bytes(bytes: [u8; limits::HEADER]) -> Result<(Self, Seal), HeaderError> {
        let [version, kind, n0, n1, b0, b1, b2, b3, s0, s1, s2, s3] = bytes;
        let number = u16::from_le_bytes([n0, n1]);
        let unknown = HeaderError { version, kind };
        let Some((seal, kind)) = Seal::split(kind) else { return Err(unknown) };
        let sender = match kind {
            0 => DeviceId::Coordinator,
            1 => DeviceId::Pile(PileId(number)),
            2 => DeviceId::Robot(RobotId(number)),
            3 => DeviceId::Chassis(RobotId(number)),
            4 => DeviceId::Service,
            5 => DeviceId::Factory,
            _ => return Err(unknown),
        };
        let boot = BootEpoch(u32::from_le_bytes([b0, b1, b2, b3]));
        let sequence = Sequence(u32::from_le_bytes([s0, s1, s2, s3]));
        Ok((Self { version, sender, boot, sequence }, seal))
    }
}

/// A device's kind and number as a header has them.
pub(crate) const fn device_bytes(device: DeviceId) -> [u8; 3] {
    let (kind, number) = match device {
        DeviceId::Coordinator => (0, 0),
        DeviceId::Pile(PileId(number)) => (1, number),
        DeviceId::Robot(RobotId(number)) => (2, number),
        DeviceId::Chassis(RobotId(number)) => (3, number),
        DeviceId::Service => (4, 0),
        DeviceId::Factory => (5, 0),
    };
    let [n0, n1] = u16::to_le_bytes(number);
    [kind, n0, n1]
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
    /// The frame's bytes without a seal, both delimiters included.
    /// [`Sessions::seal`](crate::auth::Sessions::seal) is for devices that have keys.
    ///
    /// # Errors
    /// [`EncodeError`] if the message is larger than [`limits::BODY`], which no message is.
    pub fn encode(&self) -> Result<FrameBytes, EncodeError> {
        encode(self.header, &self.message, None)
    }
}

/// The bytes of a frame, both delimiters included.
pub(crate) fn encode(
    header: Header,
    message: &Message,
    sealing: Option<Sealing<'_>>,
) -> Result<FrameBytes, EncodeError> {
    let mut packet = [0; limits::PACKET];
    let seal = sealing.as_ref().map_or(Seal::None, |sealing| sealing.seal);
    let (head, rest) = packet.split_at_mut(limits::HEADER);
    head.copy_from_slice(&header.to_bytes(seal));
    let body = postcard::to_slice(message, rest).map_err(|_| EncodeError)?.len();
    let mut end = limits::HEADER + body;
    if let Some(sealing) = sealing {
        let mac = sealing.mac(packet.get(..end).ok_or(EncodeError)?);
        end = append(&mut packet, end, &mac)?;
    }
    let check = CRC.checksum(packet.get(..end).ok_or(EncodeError)?);
    end = append(&mut packet, end, &check.to_le_bytes())?;
    let packet = packet.get(..end).ok_or(EncodeError)?;

    let mut bytes = FrameBytes::new();
    bytes.resize_default(limits::FRAME).map_err(|_| EncodeError)?;
    let length = cobs::try_encode_including_sentinels(packet, &mut bytes).map_err(|_| EncodeError)?;
    bytes.truncate(length);
    Ok(bytes)
}

/// Puts bytes at `at`; where they end.
fn append(packet: &mut [u8], at: usize, bytes: &[u8]) -> Result<usize, EncodeError> {
    let end = at + bytes.len();
    packet.get_mut(at..end).ok_or(EncodeError)?.copy_from_slice(bytes);
    Ok(end)
}
