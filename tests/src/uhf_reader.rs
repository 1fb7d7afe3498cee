//! An RFID reader of the R200 family, played for the pile: it answers every poll with the robot
//! that stands in its field, or with nothing. Written from the frames' description and not from the
//! pile's driver.

use std::io::{self, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use protocol::TagId;

const SINGLE_POLL: [u8; 7] = [0xBB, 0x00, 0x22, 0x00, 0x00, 0x22, 0x7E];
const NOTHING: [u8; 8] = [0xBB, 0x01, 0xFF, 0x00, 0x01, 0x15, 0x16, 0x7E];

/// A tag's own checksum.
const TAG_CRC: crc::Crc<u16> = crc::Crc::<u16>::new(&crc::CRC_16_GENIBUS);

/// What is in the field: a tag, and the strength of its signal in dBm.
#[derive(Clone, Copy, Default)]
enum Field {
    #[default]
    Empty,
    Tag(TagId, i8),
    /// The reader does not answer.
    Silent,
}

/// A reader that listens on TCP for its pile.
pub struct UhfReader {
    address: SocketAddr,
    field: Arc<Mutex<Field>>,
}

impl UhfReader {
    /// A reader with nothing in its field, on a port of its own.
    ///
    /// # Errors
    /// If there is no port to listen on.
    pub fn start() -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
        let reader = Self { address: listener.local_addr()?, field: Arc::default() };
        let field = Arc::clone(&reader.field);
        thread::spawn(move || {
            for pile in listener.incoming() {
                // The pile is gone, or comes back.
                let _ = pile.and_then(|pile| answer(pile, &field));
            }
        });
        Ok(reader)
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Puts a robot in front of the reader, close enough to charge.
    pub fn dock(&self, tag: TagId) {
        self.put(Field::Tag(tag, -45));
    }

    /// Takes away whatever is there.
    pub fn clear(&self) {
        self.put(Field::Empty);
    }

    /// Answers no more.
    pub fn fall_silent(&self) {
        self.put(Field::Silent);
    }

    fn put(&self, field: Field) {
        *self.field.lock().unwrap_or_else(PoisonError::into_inner) = field;
    }
}

fn answer(mut pile: TcpStream, field: &Mutex<Field>) -> io::Result<()> {
    let mut command = Vec::new();
    let mut byte = [0];
    while pile.read(&mut byte)? == 1 {
        command.extend(byte);
        if command.ends_with(&SINGLE_POLL) {
            command.clear();
            let seen = *field.lock().unwrap_or_else(PoisonError::into_inner);
            match seen {
                Field::Tag(tag, rssi_dbm) => pile.write_all(&notice(tag, rssi_dbm))?,
                Field::Empty => pile.write_all(&NOTHING)?,
                Field::Silent => {}
            }
        }
    }
    Ok(())
}

/// The notice of a 96-bit tag.
fn notice(tag: TagId, rssi_dbm: i8) -> Vec<u8> {
    // PC 3400: six words of EPC, with user memory.
    let air = [&[0x34, 0x00], &tag.0[..]].concat();
    let mut frame = vec![0x02, 0x22, 0x00, 17, rssi_dbm.cast_unsigned()];
    frame.extend(&air);
    frame.extend(TAG_CRC.checksum(&air).to_be_bytes());
    let sum = frame.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte));
    frame.extend([sum, 0x7E]);
    frame.insert(0, 0xBB);
    frame
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_notice_is_that_of_the_manufacturers_example() {
        let tag = "30751FEB705C5904E3D50D70".parse().unwrap();
        let example = [
            0xBB, 0x02, 0x22, 0x00, 0x11, 0xC9, 0x34, 0x00, 0x30, 0x75, 0x1F, 0xEB, 0x70, 0x5C, 0x59, 0x04,
            0xE3, 0xD5, 0x0D, 0x70, 0x3A, 0x76, 0xEF, 0x7E,
        ];
        assert_eq!(notice(tag, 0xC9_u8.cast_signed()), example);
    }
}
