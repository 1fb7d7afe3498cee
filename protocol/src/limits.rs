//! The largest size of everything, and the protocol's intervals.

use crate::units::DurationMs;

/// Rows of the pile table in one frame.
pub const ROWS_PER_TABLE: usize = 8;
/// Pass counts in one report.
pub const PASSES_PER_REPORT: usize = 8;
/// Waypoints in one part of a route.
pub const WAYPOINTS_PER_PART: usize = 24;

/// Bytes of a frame's header.
pub const HEADER: usize = 12;
/// Bytes of a frame's CRC-32.
pub const CHECK: usize = 4;
/// Bytes of the largest message body.
pub const BODY: usize = 320;
/// Bytes of a frame before COBS.
pub const PACKET: usize = HEADER + BODY + CHECK;
/// Bytes of a frame on the wire: COBS adds one byte in 254 and one, the delimiters two.
pub const FRAME: usize = PACKET + PACKET / 254 + 1 + 2;

/// A device that has said nothing else reports its state this often.
pub const STATE_INTERVAL: DurationMs = DurationMs(1_000);
/// A device that was silent for this long is unknown.
pub const SILENCE: DurationMs = DurationMs(10_000);
/// A command or report without an answer is repeated this often.
pub const REPEAT_INTERVAL: DurationMs = DurationMs(1_000);
