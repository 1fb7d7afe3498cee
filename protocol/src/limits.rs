//! The largest size of everything, and the protocol's intervals.
//!
//! Nothing here is a guess: how many rows fit a message is chosen, and every size follows from it
//! by [`MaxSize`]. A test compares the sizes with those printed in the [crate's docs](crate).

use crate::{auth::seal, max_size::MaxSize, message::Message, units::DurationMs};

/// Rows of the pile table in one frame.
pub const ROWS_PER_TABLE: usize = 8;
/// Pass counts in one report.
pub const PASSES_PER_REPORT: usize = 8;
/// Waypoints in one part of a route.
pub const WAYPOINTS_PER_PART: usize = 24;
/// Faults a chassis can have at a time: three at each wheel, a slip, a silent gyroscope and a
/// silent battery meter.
pub const CHASSIS_FAULTS: usize = 15;

/// Bytes of a frame's header.
pub const HEADER: usize = 12;
/// Bytes of a frame's CRC-32.
pub const CHECK: usize = 4;
/// Bytes of the largest message body.
pub const BODY: usize = Message::MAX_SIZE;
/// Bytes of a sealed frame's MAC.
pub const MAC: usize = seal::MAC;
/// Bytes of a sealed frame before COBS.
pub const PACKET: usize = HEADER + BODY + MAC + CHECK;
/// Bytes between two delimiters: COBS adds one, and one for each 254 bytes.
pub const ENCODED: usize = PACKET + PACKET / 254 + 1;
/// Bytes of a frame on the wire, both delimiters included.
pub const FRAME: usize = ENCODED + 2;

/// A device that has said nothing else reports its state this often.
pub const STATE_INTERVAL: DurationMs = DurationMs(1_000);
/// A device that was silent for this long is unknown.
pub const SILENCE: DurationMs = DurationMs(10_000);
/// A pile or robot that has heard no coordinator for this long takes it for lost.
pub const COORDINATOR_LOST: DurationMs = DurationMs(30_000);
/// The longest time for which a robot can claim a pile before it is there.
pub const LONGEST_CLAIM: DurationMs = DurationMs(600_000);
/// A chassis reports its motion this often, once a control tick.
pub const ODOMETRY_INTERVAL: DurationMs = DurationMs(10);
/// How long a drive command is obeyed if its sender has no reason to choose another time.
pub const DRIVE_TTL: DurationMs = DurationMs(200);
/// A command or report without an answer is repeated this often.
pub const REPEAT_INTERVAL: DurationMs = DurationMs(1_000);

// Every IPv4 host takes datagrams of 576 bytes; IP takes up to 60 of them and UDP 8.
const _: () = assert!(FRAME <= 576 - 60 - 8, "a frame must fit one UDP datagram on every network");
// 115200 baud carry 11520 bytes a second; a device must get its largest frame through in a tenth.
const _: () = assert!(FRAME <= 11_520 / 10, "a frame must not block a serial line for over 100 ms");
