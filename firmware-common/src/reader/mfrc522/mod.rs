//! The MFRC522, a reader of 13.56 MHz tags (ISO 14443-A) on an SPI bus. The crate `mfrc522` speaks
//! to the chip; here is what a pile needs of it.
//!
//! Every poll sets the chip up anew, so that one that lost its supply comes back by itself, and ends
//! with the field off: a tag then starts afresh in the next one. Of several tags in the field none is
//! told: it is a few centimetres deep, and nobody could say which of them is at the contacts.
//!
//! The bus is blocking. A poll costs at most [`MAX_TRANSACTIONS`] of it, also when the chip hangs or
//! is not there: its driver waits for it without a limit of its own. [`BUS_HZ`] makes that 45 ms.

mod select;
#[cfg(test)]
mod tests;

use embedded_hal::spi::{self, ErrorKind, ErrorType, Operation, SpiDevice};
use embedded_hal_async::delay::DelayNs;
use mfrc522::comm::blocking::spi::SpiInterface;
use protocol::TagId;

use super::{Seen, TagRead, TagReader};

/// The bus' clock, in hertz, the most that a poll's limit is made for: 84 MHz by 64. A reader at the
/// end of a cable likes it slow.
pub const BUS_HZ: u32 = 1_312_500;
/// Transactions of a poll, about 15 microseconds each. An empty field takes some 1,700: the chip
/// waits 25 ms for an answer.
pub const MAX_TRANSACTIONS: u32 = 3_000;
/// The signal strength of a tag, which this reader does not measure: it was read, so it is within
/// centimetres, inside any band in front of a UHF reader.
pub const RSSI_DBM: i8 = 0;

/// The first byte of a [`TagId`] made of a UID. No EPC begins with it: GS1 keeps it for headers
/// longer than a byte.
const MARK: u8 = 0xFF;
/// How long a tag is in the field before it must answer (ISO 14443-3).
const POWER_UP_MS: u32 = 5;
/// The chip's register of the antenna driver, written, and what it holds after a reset: off.
const FIELD_OFF: [u8; 2] = [0x14 << 1, 0x80];
/// What the bus says when nobody is on it.
const NOBODY: [u8; 2] = [0x00, 0xFF];

/// Why a poll found no tag although something is in the field, or why it ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PollError {
    /// The chip does not finish what it was told.
    #[error("the MFRC522 hangs")]
    Hangs,
    /// The microcontroller's bus fails.
    #[error("the MFRC522's bus fails: {0:?}")]
    Bus(ErrorKind),
    /// Two tags answer at a time.
    #[error("several tags are in front of the MFRC522")]
    Several,
    /// What a tag says arrived with a wrong checksum, length or parity, or not at all.
    #[error("the MFRC522 misread a tag: {0}")]
    Misread(&'static str),
    /// The tag makes up a new UID each time it is read, as telephones do.
    #[error("the tag in front of the MFRC522 has a random UID, which names nobody")]
    RandomUid,
}

/// The [`TagId`] of a tag with a UID of 4, 7 or 10 bytes: FF, the number of bytes, the UID, zeros.
/// Different UIDs are different tags, also if one begins with the other.
#[must_use]
pub fn tag_of(uid: &Uid) -> TagId {
    let mut tag = [0; 12];
    let [mark, length, bytes @ ..] = &mut tag;
    *mark = MARK;
    *length = uid.len() as u8;
    for (to, from) in bytes.iter_mut().zip(uid) {
        *to = *from;
    }
    TagId(tag)
}

/// What a tag calls itself: 4, 7 or 10 bytes.
pub type Uid = heapless::Vec<u8, 10>;

/// A reader on a bus of its own.
#[derive(Debug)]
pub struct Mfrc522<Spi, Delay> {
    spi: Spi,
    delay: Delay,
}

impl<Spi: SpiDevice, Delay: DelayNs> Mfrc522<Spi, Delay> {
    /// A reader that was not asked yet, on a bus of at most [`BUS_HZ`].
    pub const fn new(spi: Spi, delay: Delay) -> Self {
        Self { spi, delay }
    }

    /// What is in the field; `None` if no chip is on the bus.
    async fn ask(&mut self) -> Result<Option<Seen>, PollError> {
        let bus = Bounded { spi: &mut self.spi, left: MAX_TRANSACTIONS };
        let mut chip = mfrc522::Mfrc522::new(SpiInterface::new(bus)).init().map_err(PollError::from)?;
        if NOBODY.contains(&chip.version()?) {
            return Ok(None);
        }
        self.delay.delay_ms(POWER_UP_MS).await;
        match chip.wupa() {
            Ok(_) => {}
            Err(mfrc522::Error::Timeout) => return Ok(Some(Seen::Nothing)),
            Err(error) => return Err(error.into()),
        }
        let uid = select::uid(&mut chip)?;
        Ok(Some(Seen::Tag(TagRead { tag: tag_of(&uid), rssi_dbm: RSSI_DBM })))
    }
}

impl<Spi: SpiDevice, Delay: DelayNs> TagReader for Mfrc522<Spi, Delay> {
    type Error = PollError;

    /// No chip on the bus is silence, as with a reader on a serial line: the board has the other kind.
    async fn poll(&mut self, mut found: impl FnMut(Result<Seen, PollError>)) {
        let asked = self.ask().await;
        let off = self.spi.write(&FIELD_OFF).map_err(|error| PollError::Bus(spi::Error::kind(&error)));
        match asked.and_then(|seen| off.map(|()| seen)) {
            Ok(Some(seen)) => found(Ok(seen)),
            Ok(None) => {}
            Err(error) => found(Err(error)),
        }
    }
}

/// A device that fails after some transactions.
struct Bounded<'a, Spi> {
    spi: &'a mut Spi,
    left: u32,
}

/// Why a transaction did not happen.
#[derive(Clone, Copy, Debug)]
enum BoundedError {
    /// There were too many before it.
    TooMany,
    /// The bus fails.
    Bus(ErrorKind),
}

impl spi::Error for BoundedError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::TooMany => ErrorKind::Other,
            Self::Bus(kind) => *kind,
        }
    }
}

impl<Spi> ErrorType for Bounded<'_, Spi> {
    type Error = BoundedError;
}

impl<Spi: SpiDevice> SpiDevice for Bounded<'_, Spi> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), BoundedError> {
        self.left = self.left.checked_sub(1).ok_or(BoundedError::TooMany)?;
        self.spi.transaction(operations).map_err(|error| BoundedError::Bus(spi::Error::kind(&error)))
    }
}

impl From<mfrc522::Error<BoundedError>> for PollError {
    fn from(error: mfrc522::Error<BoundedError>) -> Self {
        use mfrc522::Error;
        match error {
            Error::Comm(BoundedError::TooMany) => Self::Hangs,
            Error::Comm(BoundedError::Bus(kind)) => Self::Bus(kind),
            Error::Collision => Self::Several,
            Error::Crc => Self::Misread("its checksum is wrong"),
            Error::Parity => Self::Misread("a parity bit is wrong"),
            Error::Protocol => Self::Misread("it is no frame of ISO 14443"),
            Error::IncompleteFrame => Self::Misread("a frame is cut off"),
            Error::NoRoom | Error::BufferOverflow => Self::Misread("a frame is too long"),
            Error::Timeout => Self::Misread("it fell silent"),
            Error::Bcc | Error::Nak | Error::Overheating | Error::Proprietary | Error::Wr => {
                Self::Misread("the chip reports an error")
            }
        }
    }
}
