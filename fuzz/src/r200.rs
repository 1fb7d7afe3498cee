//! What a UHF reader sends, in any portions.

use std::convert::Infallible;

use embassy_futures::block_on;
use embedded_io_async::{ErrorType, Read, Write};
use firmware_common::reader::r200::{R200, Replies};
use firmware_common::reader::{Seen, TagRead, TagReader};

use crate::tried::Tried;

/// Recorded: nothing in the field.
const NOTHING: [u8; 8] = [0xBB, 0x01, 0xFF, 0x00, 0x01, 0x15, 0x16, 0x7E];
/// Longer than any reply, so that whatever had begun before has ended.
const SILENCES: usize = 30;

/// Polls a reader that sends `input`.
pub fn run(input: &[u8]) -> Tried {
    let mut tried = Tried::default();
    let Some((&portion, stream)) = input.split_first() else { return tried };
    let mut replies = Replies::new();
    let mut whole = Vec::new();
    replies.feed(stream, |reply| whole.push(reply));

    let mut polled = Vec::new();
    let mut left = stream;
    let mut reader = R200::new(Line { left: &mut left, portion: usize::from(portion).max(1) });
    // It sends no byte for ever: a poll takes at least one.
    for _ in 0..=stream.len() {
        block_on(reader.poll(|reply| polled.push(reply)));
    }
    assert_eq!(polled, whole, "portions make no difference");

    for reply in &whole {
        tried.add(reply.is_ok());
        if let Ok(Seen::Tag(seen)) = reply {
            assert!(stream.windows(24).any(|bytes| says(bytes, seen)), "{seen:?} was not sent");
        }
    }
    let mut after = Vec::new();
    replies.feed(&NOTHING.repeat(SILENCES), |reply| after.push(reply));
    assert!(after.contains(&Ok(Seen::Nothing)), "the reader is not understood any more");
    tried
}

/// Whether these bytes are the notice of that tag.
fn says(bytes: &[u8], seen: &TagRead) -> bool {
    matches!(bytes, [0xBB, 0x02, 0x22, 0x00, 0x11, rssi, _, _, epc @ .., _, _, check, 0x7E]
        if rssi.cast_signed() == seen.rssi_dbm && epc == seen.tag.0
            && bytes[1..22].iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte)) == *check)
}

/// A serial line with somebody at the other end who does not listen.
struct Line<'a, 'b> {
    left: &'a mut &'b [u8],
    portion: usize,
}

impl ErrorType for Line<'_, '_> {
    type Error = Infallible;
}

impl Read for Line<'_, '_> {
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        let length = self.portion.min(buffer.len()).min(self.left.len());
        let (now, later) = self.left.split_at(length);
        buffer[..length].copy_from_slice(now);
        *self.left = later;
        Ok(length)
    }
}

impl Write for Line<'_, '_> {
    async fn write(&mut self, buffer: &[u8]) -> Result<usize, Infallible> {
        Ok(buffer.len())
    }

    async fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}
