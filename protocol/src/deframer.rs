//! Finds packets in a stream of bytes, whatever else is in it.
//!
//! After any error everything up to the next delimiter is discarded, so that noise costs the frame
//! it hits and never the next one: even where a frame's last delimiter is lost, the next frame's
//! first one ends it. Memory is one frame; work is constant for each byte, and linear in the frame
//! at a delimiter. It knows no keys: who sent a packet is for
//! [`Sessions::open`](crate::auth::Sessions::open) to find out.

use heapless::Vec;

use crate::{error::FrameError, frame::DELIMITER, limits, packet::Packet};

/// Collects bytes until a delimiter, then reads them as a packet.
#[derive(Clone, Debug, Default)]
pub struct Deframer {
    between: Vec<u8, { limits::ENCODED }>,
    oversize: bool,
    /// A delimiter was the last byte: what is collected has been read.
    ended: bool,
}

impl Deframer {
    /// A deframer that has seen nothing.
    #[must_use]
    pub const fn new() -> Self {
        Self { between: Vec::new(), oversize: false, ended: false }
    }

    /// Takes one byte; answers when it completes a packet, or what is none.
    ///
    /// # Errors
    /// [`FrameError`] says why the bytes before this delimiter are no packet.
    pub fn push(&mut self, byte: u8) -> Option<Result<Packet<'_>, FrameError>> {
        if core::mem::replace(&mut self.ended, byte == DELIMITER) {
            self.between.clear();
            self.oversize = false;
        }
        if byte != DELIMITER {
            self.oversize |= self.between.push(byte).is_err();
            None
        } else if self.oversize {
            Some(Err(FrameError::Oversize))
        } else if self.between.is_empty() {
            None
        } else {
            Some(Packet::decode(&mut self.between))
        }
    }

    /// Takes bytes in any portions and hands every packet, and every error, to `found`.
    pub fn feed(&mut self, bytes: &[u8], mut found: impl FnMut(Result<Packet<'_>, FrameError>)) {
        for &byte in bytes {
            if let Some(result) = self.push(byte) {
                found(result);
            }
        }
    }
}
