//! UHF readers of the R200, YRM100 and QM100 family on a serial line.
//!
//! ```text
//!  BB | type | command | length (2, big-endian) | parameters | checksum | 7E
//! ```
//! Type 00 is a command, 01 a response, 02 a notice; the checksum is the low byte of the sum from
//! type to the last parameter. A tag comes as a notice to the poll command with signal strength
//! (signed dBm), PC, EPC and the tag's own CRC; an empty field as response FF with parameter 15.
//!
//! BB and 7E also occur inside frames, so a frame's borders are found by reading it: what turns
//! out not to be a frame loses its first byte only, and the search for the next BB goes on in what
//! is already here. A good reply behind noise is therefore never lost, only late.

use embedded_io_async::{Error, ErrorKind, Read, Write};
use heapless::Vec;
use protocol::TagId;

use super::{Seen, TagRead, TagReader};

/// Asks for one inventory of the field.
pub const SINGLE_POLL: [u8; 7] = [START, 0x00, POLL, 0x00, 0x00, 0x22, END];

const START: u8 = 0xBB;
const END: u8 = 0x7E;
const RESPONSE: u8 = 0x01;
const NOTICE: u8 = 0x02;
const POLL: u8 = 0x22;
const ERROR: u8 = 0xFF;
const NO_TAG: u8 = 0x15;

/// Type, command and length stand between the start byte and the parameters.
const HEADER: usize = 5;
/// Checksum and end byte stand behind them.
const TRAILER: usize = 2;
/// Longer parameters than these are no reply to a poll.
const MAX_PARAMETERS: usize = 64;
const MAX_FRAME: usize = HEADER + MAX_PARAMETERS + TRAILER;
/// Of the protocol control word: how many 16-bit words of EPC follow; 96 bits are six.
const EPC_WORDS: u8 = 6;
/// Signal strength, PC, a 96-bit EPC and its CRC.
const NOTICE_LENGTH: usize = 1 + 2 + 12 + 2;

const TAG_CRC: crc::Crc<u16> = crc::Crc::<u16>::new(&crc::CRC_16_GENIBUS);

/// A reply other than a sighting, or bytes that are no reply.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReplyError {
    /// The byte cannot start a reply; this is told once for each run of such bytes.
    #[error("noise before a reply of the RFID reader")]
    Noise,
    /// The type is neither response nor notice, or the length is none of a poll's.
    #[error("no header of an RFID reader's reply")]
    Header,
    /// The checksum or the end byte is wrong.
    #[error("a reply of the RFID reader arrived damaged")]
    Damaged,
    /// The tag's own CRC is wrong: the reader misread it.
    #[error("the RFID reader misread a tag")]
    Misread,
    /// The tag has no 96-bit EPC, or its notice is not laid out as one.
    #[error("the RFID reader reports something that is no tag with a 96-bit EPC")]
    NotEpc96,
    /// The reader refuses or fails.
    #[error("the RFID reader reports error {code:#04X}")]
    Reader {
        /// The manufacturer's code.
        code: u8,
    },
    /// The reply to a command that was not sent.
    #[error("the RFID reader answers command {command:#04X}, which was not sent")]
    Unasked {
        /// The command.
        command: u8,
    },
    /// The serial line fails; what it still holds is read at the next poll.
    #[error("the RFID reader's line fails: {0:?}")]
    Line(ErrorKind),
}

/// Finds replies in a stream of bytes. Memory is one frame; a byte costs at most the work of
/// searching one frame.
#[derive(Clone, Debug, Default)]
pub struct Replies {
    /// Empty, or beginning with a start byte of a frame that is not complete.
    bytes: Vec<u8, MAX_FRAME>,
    in_noise: bool,
}

impl Replies {
    /// Nothing was received.
    #[must_use]
    pub const fn new() -> Self {
        Self { bytes: Vec::new(), in_noise: false }
    }

    /// Takes bytes in any portions and hands every reply, and every error, to `found`.
    pub fn feed(&mut self, bytes: &[u8], mut found: impl FnMut(Result<Seen, ReplyError>)) {
        for &byte in bytes {
            // It fits: what is kept is shorter than the longest frame.
            let _ = self.bytes.push(byte);
            self.search(&mut found);
        }
    }

    /// Takes everything out of `bytes` that is decided.
    fn search(&mut self, found: &mut impl FnMut(Result<Seen, ReplyError>)) {
        loop {
            let (used, result) = match frame(&self.bytes) {
                Frame::Incomplete => return,
                Frame::Noise => (1, (!self.in_noise).then_some(Err(ReplyError::Noise))),
                Frame::Bad(error) => (1, Some(Err(error))),
                Frame::Good { length, result } => (length, Some(result)),
            };
            // What one byte was taken off is noise, and what follows it until a good frame.
            self.in_noise = used == 1;
            self.bytes.drain(..used);
            if let Some(result) = result {
                found(result);
            }
        }
    }
}

/// What the first bytes of a stream are.
enum Frame {
    Incomplete,
    Noise,
    Bad(ReplyError),
    Good { length: usize, result: Result<Seen, ReplyError> },
}

fn frame(bytes: &[u8]) -> Frame {
    match bytes {
        [] | [START] => return Frame::Incomplete,
        [START, RESPONSE | NOTICE, ..] => {}
        [START, ..] => return Frame::Bad(ReplyError::Header),
        _ => return Frame::Noise,
    }
    let &[_, kind, command, high, low, ref rest @ ..] = bytes else { return Frame::Incomplete };
    let length = usize::from(u16::from_be_bytes([high, low]));
    if length > MAX_PARAMETERS {
        return Frame::Bad(ReplyError::Header);
    }
    let Some((parameters, [check, end, ..])) = rest.split_at_checked(length) else {
        return Frame::Incomplete;
    };
    let summed = [&[kind, command, high, low], parameters];
    let sum = summed.iter().copied().flatten().fold(0u8, |sum, byte| sum.wrapping_add(*byte));
    if (sum, END) != (*check, *end) {
        return Frame::Bad(ReplyError::Damaged);
    }
    Frame::Good { length: HEADER + length + TRAILER, result: reply(kind, command, parameters) }
}

fn reply(kind: u8, command: u8, parameters: &[u8]) -> Result<Seen, ReplyError> {
    match (kind, command, parameters) {
        (NOTICE, POLL, notice) => tag(notice).map(Seen::Tag),
        (RESPONSE, ERROR, [NO_TAG]) => Ok(Seen::Nothing),
        (RESPONSE, ERROR, &[code, ..]) => Err(ReplyError::Reader { code }),
        (_, command, _) => Err(ReplyError::Unasked { command }),
    }
}

fn tag(notice: &[u8]) -> Result<TagRead, ReplyError> {
    let [rssi, covered @ .., high, low] = notice.as_array::<NOTICE_LENGTH>().ok_or(ReplyError::NotEpc96)?;
    let [control, _, epc @ ..] = covered;
    if control >> 3 != EPC_WORDS {
        return Err(ReplyError::NotEpc96);
    }
    if TAG_CRC.checksum(covered) != u16::from_be_bytes([*high, *low]) {
        return Err(ReplyError::Misread);
    }
    Ok(TagRead { tag: TagId(*epc), rssi_dbm: rssi.cast_signed() })
}

/// A reader behind a serial port.
#[derive(Debug)]
pub struct R200<Port> {
    port: Port,
    replies: Replies,
}

impl<Port: Read + Write> R200<Port> {
    /// A reader that was not asked yet.
    pub const fn new(port: Port) -> Self {
        Self { port, replies: Replies::new() }
    }

    /// Asks once and waits for the first good reply; replies that came with it are handed out too.
    /// Without a reply it returns only if the port is at its end.
    async fn ask(&mut self, found: &mut impl FnMut(Result<Seen, ReplyError>)) -> Result<(), Port::Error> {
        self.port.write_all(&SINGLE_POLL).await?;
        self.port.flush().await?;
        let mut answered = false;
        while !answered {
            let mut chunk = [0; MAX_FRAME];
            let length = self.port.read(&mut chunk).await?;
            if length == 0 {
                return Ok(());
            }
            self.replies.feed(chunk.get(..length).unwrap_or_default(), |reply| {
                answered |= reply.is_ok();
                found(reply);
            });
        }
        Ok(())
    }
}

impl<Port: Read + Write> TagReader for R200<Port> {
    type Error = ReplyError;

    async fn poll(&mut self, mut found: impl FnMut(Result<Seen, ReplyError>)) {
        if let Err(error) = self.ask(&mut found).await {
            found(Err(ReplyError::Line(error.kind())));
        }
    }
}

#[cfg(test)]
mod tests {
    use core::convert::Infallible;
    use core::future::Future;
    use core::pin::pin;
    use core::task::{Context, Poll, Waker};

    use embedded_io_async::ErrorType;
    use proptest::prelude::*;

    use super::*;

    /// Recorded: a tag at -55 dBm.
    const TAG: [u8; 24] = [
        0xBB, 0x02, 0x22, 0x00, 0x11, 0xC9, 0x34, 0x00, 0x30, 0x75, 0x1F, 0xEB, 0x70, 0x5C, 0x59, 0x04, 0xE3,
        0xD5, 0x0D, 0x70, 0x3A, 0x76, 0xEF, 0x7E,
    ];
    /// Recorded: nothing in the field.
    const NOTHING: [u8; 8] = [0xBB, 0x01, 0xFF, 0x00, 0x01, 0x15, 0x16, 0x7E];
    const SEEN: Seen = Seen::Tag(TagRead {
        tag: TagId([0x30, 0x75, 0x1F, 0xEB, 0x70, 0x5C, 0x59, 0x04, 0xE3, 0xD5, 0x0D, 0x70]),
        rssi_dbm: -55,
    });

    fn replies(bytes: &[u8]) -> Vec<Result<Seen, ReplyError>, 64> {
        let mut found = Vec::new();
        Replies::new().feed(bytes, |reply| found.push(reply).unwrap());
        found
    }

    fn good(bytes: &[u8]) -> Vec<Seen, 64> {
        replies(bytes).into_iter().flatten().collect()
    }

    /// The checksum of a frame whose parameters were changed.
    fn resummed(mut bytes: [u8; 24]) -> [u8; 24] {
        bytes[22] = bytes[1..22].iter().fold(0, |sum, byte| sum.wrapping_add(*byte));
        bytes
    }

    #[test]
    fn recorded_replies_are_read() {
        assert_eq!(replies(&TAG), [Ok(SEEN)]);
        assert_eq!(replies(&NOTHING), [Ok(Seen::Nothing)]);
    }

    #[test]
    fn notices_and_responses_may_mix() {
        assert_eq!(good(&[&TAG[..], &NOTHING, &TAG, &TAG].concat()), [SEEN, Seen::Nothing, SEEN, SEEN]);
    }

    #[test]
    fn a_wrong_checksum_or_end_costs_only_its_reply() {
        for position in [22, 23] {
            let mut damaged = TAG;
            damaged[position] ^= 0x01;
            let found = replies(&[&damaged[..], &TAG].concat());
            assert_eq!(found.first(), Some(&Err(ReplyError::Damaged)));
            assert_eq!(found.last(), Some(&Ok(SEEN)));
        }
    }

    #[test]
    fn a_reply_behind_a_truncated_one_is_found() {
        for length in 1..TAG.len() {
            // The truncated frame swallows the first replies until it is complete, then gives them back.
            let found = good(&[&TAG[..length], &NOTHING, &TAG, &NOTHING].concat());
            assert_eq!(found, [Seen::Nothing, SEEN, Seen::Nothing], "cut after {length} bytes");
        }
    }

    #[test]
    fn a_misread_tag_is_none() {
        let mut misread = TAG;
        misread[10] ^= 0x10;
        assert_eq!(replies(&resummed(misread)), [Err(ReplyError::Misread)]);
    }

    #[test]
    fn a_tag_with_another_epc_length_is_none() {
        let mut short = TAG;
        short[6] = 0x2C;
        assert_eq!(replies(&resummed(short)), [Err(ReplyError::NotEpc96)]);
    }

    #[test]
    fn the_readers_own_errors_are_no_sightings() {
        let overheated = [0xBB, 0x01, 0xFF, 0x00, 0x01, 0x20, 0x21, 0x7E];
        assert_eq!(replies(&overheated), [Err(ReplyError::Reader { code: 0x20 })]);
        let stopped = [0xBB, 0x01, 0x28, 0x00, 0x01, 0x00, 0x2A, 0x7E];
        assert_eq!(replies(&stopped), [Err(ReplyError::Unasked { command: 0x28 })]);
    }

    #[test]
    fn a_stream_may_be_cut_anywhere() {
        let stream = [&TAG[..], &NOTHING, &TAG].concat();
        for cut in 0..stream.len() {
            let (first, second) = stream.split_at(cut);
            let mut reader = Replies::new();
            let mut found = std::vec::Vec::new();
            reader.feed(first, |reply| found.push(reply));
            reader.feed(second, |reply| found.push(reply));
            assert_eq!(found, [Ok(SEEN), Ok(Seen::Nothing), Ok(SEEN)], "cut after {cut} bytes");
        }
    }

    #[test]
    fn a_flipped_bit_never_makes_another_tag() {
        for bit in 0..TAG.len() * 8 {
            let mut flipped = TAG;
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(good(&flipped), [], "bit {bit}");
        }
    }

    proptest! {
        #[test]
        fn noise_never_hides_the_replies_behind_it(noise in prop::collection::vec(any::<u8>(), 0..200)) {
            // A header in the noise may wait for as much as a whole frame.
            let behind = TAG.repeat(1 + MAX_FRAME / TAG.len());
            let mut found = std::vec::Vec::new();
            Replies::new().feed(&[&noise[..], &behind].concat(), |reply| found.push(reply));
            prop_assert!(found.contains(&Ok(SEEN)));
        }
    }

    /// A reader that answers every poll with the next of its replies, a few bytes at a time.
    struct Script {
        polls: usize,
        replies: std::vec::Vec<u8>,
    }

    impl ErrorType for Script {
        type Error = Infallible;
    }

    impl Write for Script {
        async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
            assert_eq!(bytes, SINGLE_POLL);
            self.polls += 1;
            Ok(bytes.len())
        }

        async fn flush(&mut self) -> Result<(), Infallible> {
            Ok(())
        }
    }

    impl Read for Script {
        async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
            let length = self.replies.len().min(buffer.len()).min(5);
            for (to, from) in buffer.iter_mut().zip(self.replies.drain(..length)) {
                *to = from;
            }
            Ok(length)
        }
    }

    #[test]
    fn a_poll_waits_for_a_reply_and_skips_noise() {
        let replies = [&[0x00, 0xFF][..], &TAG, &NOTHING].concat();
        let mut reader = R200::new(Script { polls: 0, replies });
        let mut seen = std::vec::Vec::new();
        for _ in 0..2 {
            let polled =
                pin!(reader.poll(|reply| seen.extend(reply))).poll(&mut Context::from_waker(Waker::noop()));
            assert_eq!(polled, Poll::Ready(()));
        }
        assert_eq!(seen, [SEEN, Seen::Nothing]);
        assert_eq!(reader.port.polls, 2);
    }
}
