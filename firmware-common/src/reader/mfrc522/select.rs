//! From a tag that has answered to its whole UID (ISO 14443-3, part 6.5).
//!
//! A UID comes in one to three levels of four bytes. What does not end it begins with the cascade tag.
//! The crate's own `select` is not used: it panics when a tag asks for a fourth level.

use mfrc522::comm::Interface;
use mfrc522::{Initialized, Mfrc522};

use super::{BoundedError, PollError, Uid};

/// "Send what is left of your UID" and "I mean you", by level.
const SELECT: [u8; 3] = [0x93, 0x95, 0x97];
/// Behind [`SELECT`]: no byte of the UID is known.
const ANYBODY: u8 = 0x20;
/// Behind [`SELECT`]: all of it is.
const WHOLE: u8 = 0x70;
/// Stands where a UID goes on in the next level.
const CASCADE_TAG: u8 = 0x88;
/// Of the answer to a selection: the UID goes on.
const GOES_ON: u8 = 0x04;
/// The first byte of a UID of four bytes that is made up anew each time.
const RANDOM: u8 = 0x08;

const CRC_A: crc::Crc<u16> = crc::Crc::<u16>::new(&crc::CRC_16_ISO_IEC_14443_3_A);

/// Selects the one tag in the field.
pub(super) fn uid<Bus: Interface<Error = BoundedError>>(
    chip: &mut Mfrc522<Bus, Initialized>,
) -> Result<Uid, PollError> {
    let mut uid = Uid::new();
    for level in SELECT {
        let part = anybody(chip, level)?;
        let goes_on = select(chip, level, part)?;
        let [first, rest @ ..] = part;
        let bytes: &[u8] = if goes_on { &rest } else { &part };
        // Three levels are 3, 3 and 4 bytes at most.
        let _ = uid.extend_from_slice(bytes);
        match (goes_on, first == CASCADE_TAG) {
            (true, true) => {}
            (false, false) if uid.len() == 4 && first == RANDOM => return Err(PollError::RandomUid),
            (false, false) => return Ok(uid),
            _ => return Err(PollError::Misread("its UID goes on and does not")),
        }
    }
    Err(PollError::Misread("its UID does not end"))
}

/// The four bytes of a level that the tag in the field has.
fn anybody<Bus: Interface<Error = BoundedError>>(
    chip: &mut Mfrc522<Bus, Initialized>,
    level: u8,
) -> Result<[u8; 4], PollError> {
    let answer = chip.transceive::<5>(&[level, ANYBODY], 0, 0)?;
    if (answer.valid_bytes, answer.valid_bits) != (5, 0) {
        return Err(PollError::Misread("a frame is cut off"));
    }
    let [a, b, c, d, check] = answer.buffer;
    if a ^ b ^ c ^ d != check {
        return Err(PollError::Misread("its UID's check byte is wrong"));
    }
    Ok([a, b, c, d])
}

/// Selects that tag in this level; answers whether its UID goes on in the next.
fn select<Bus: Interface<Error = BoundedError>>(
    chip: &mut Mfrc522<Bus, Initialized>,
    level: u8,
    [a, b, c, d]: [u8; 4],
) -> Result<bool, PollError> {
    let mut frame = [level, WHOLE, a, b, c, d, a ^ b ^ c ^ d, 0, 0];
    if let Some((command, checksum)) = frame.split_last_chunk_mut() {
        *checksum = CRC_A.checksum(command).to_le_bytes();
    }
    let answer = chip.transceive::<3>(&frame, 0, 0)?;
    if (answer.valid_bytes, answer.valid_bits) != (3, 0) {
        return Err(PollError::Misread("a frame is cut off"));
    }
    let [acknowledge, checksum @ ..] = answer.buffer;
    if CRC_A.checksum(&[acknowledge]).to_le_bytes() != checksum {
        return Err(PollError::Misread("its checksum is wrong"));
    }
    Ok(acknowledge & GOES_ON != 0)
}
