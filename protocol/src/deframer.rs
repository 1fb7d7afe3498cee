//! Finds frames in a stream of bytes, whatever else is in it.
//!
//! After any error everything up to the next delimiter is discarded, so that noise costs the frame
//! it hits and never the next one: even where a frame's last delimiter is lost, the next frame's
//! first one ends it. Memory is one frame; work is constant for each byte, and linear in the frame
//! at a delimiter.

use heapless::Vec;

use crate::{
    error::FrameError,
    frame::{DELIMITER, Frame},
    limits,
};

/// Collects bytes until a delimiter, then reads them as a frame.
#[derive(Clone, Debug, Default)]
pub struct Deframer {
    between: Vec<u8, { limits::ENCODED }>,
    oversize: bool,
}

impl Deframer {
    /// A deframer that has seen nothing.
    #[must_use]
    pub const fn new() -> Self {
        Self { between: Vec::new(), oversize: false }
    }

    /// Takes one byte; answers when it completes a frame, or what is none.
    ///
    /// # Errors
    /// [`FrameError`] says why the bytes before this delimiter are no frame.
    pub fn push(&mut self, byte: u8) -> Option<Result<Frame, FrameError>> {
        if byte != DELIMITER {
            self.oversize |= self.between.push(byte).is_err();
            return None;
        }
        let result = if self.oversize {
            Some(Err(FrameError::Oversize))
        } else if self.between.is_empty() {
            None
        } else {
            Some(Frame::decode(&mut self.between))
        };
        self.between.clear();
        self.oversize = false;
        result
    }

    /// Takes bytes in any portions and hands every frame, and every error, to `found`.
    pub fn feed(&mut self, bytes: &[u8], mut found: impl FnMut(Result<Frame, FrameError>)) {
        bytes.iter().filter_map(|&byte| self.push(byte)).for_each(&mut found);
    }
}
