//! What goes over a Chargehand wire.
//!
//! Piles, robots and the coordinator exchange [`Message`]s in [`Frame`]s. This crate says what
//! they look like and nothing else: it does no I/O, allocates nothing and knows no clock, so the
//! same code runs on the pile's microcontroller and in the coordinator.
//!
//! ```text
//!  0x00 | COBS( packet ) | 0x00
//!
//!  packet   0        1      2        4            8          12      n-4
//!           version  kind   number   boot epoch   sequence   body    CRC-32
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`ids`] | who and what a message speaks of |
//! | [`key`] | the secret two devices share |
//! | [`units`] | physical quantities and times, checked when they are decoded |
//! | [`message`] | the one table of all messages |
//! | [`frame`] | header, CRC and COBS around a message |
//! | [`deframer`] | finds frames in a stream of bytes, whatever else is in it |
//! | [`version`] | which protocol versions two devices can speak |
//! | [`max_size`] | how large a message can get, computed from its parts |
//! | [`limits`] | the sizes of everything else, and the intervals |
//! | [`error`] | what can be wrong with bytes from a wire |
//!
//! ```
//! use protocol::{Deframer, DeviceId, Frame, Header, Message, Millis, PileId, TimeRequest};
//!
//! let header = Header::new(DeviceId::Pile(PileId(7)), protocol::BootEpoch(3), protocol::Sequence(1));
//! let message = Message::TimeRequest(TimeRequest { asked_at: Millis(1_000) });
//! let bytes = Frame { header, message: message.clone() }.encode()?;
//!
//! let mut deframer = Deframer::new();
//! let mut received = Vec::new();
//! deframer.feed(&bytes, |frame| received.push(frame));
//! assert_eq!(received, [Ok(Frame { header, message })]);
//! # Ok::<(), protocol::EncodeError>(())
//! ```
//!
//! # Sizing
//! All sizes are computed at compile time; a test keeps these tables true. The largest body of every
//! message, ordinal included, and what that makes of a frame:
//!
//! | message | bytes |
//! |---|---|
//! | `Hello` | 11 |
//! | `PileState` | 71 |
//! | `PileTable` | 242 |
//! | `Grant` | 47 |
//! | `Revoke` | 25 |
//! | `PassReport` | 172 |
//! | `TimeRequest` | 7 |
//! | `TimeSync` | 13 |
//! | `Ack` | 12 |
//! | `Nack` | 26 |
//! | `Fault` | 13 |
//! | `RobotState` | 20 |
//! | `ChargeRequest` | 18 |
//! | `Assignment` | 208 |
//! | `Unassigned` | 7 |
//! | `Drive` | 23 |
//! | `Stop` | 7 |
//! | `Release` | 6 |
//! | `Task` | 10 |
//! | `TaskEnergy` | 17 |
//! | `Odometry` | 91 |
//! | `ChassisState` | 53 |
//! | `PileReadings` | 24 |
//! | `ChargeReport` | 59 |
//! | `Query` | 2 |
//! | `PileFaults` | 44 |
//! | `PendingPasses` | 162 |
//! | `PileParameters` | 28 |
//! | `ClearFault` | 7 |
//! | `Provision` | 105 |
//!
//! | part | bytes |
//! |---|---|
//! | header | 12 |
//! | largest body | 242 |
//! | check | 4 |
//! | largest packet | 258 |
//! | largest frame | 262 |
//!
//! A [`Deframer`] holds one frame and nothing else; encoding takes a packet and a frame of stack.
//!
//! # Compatibility
//! The rules are in [`version`]; `tests/versioning/` keeps the bytes of every message. For writing a
//! client, also in another language, see the book's page on the wire protocol.
#![no_std]

pub mod deframer;
pub mod error;
pub mod frame;
pub mod ids;
pub mod key;
pub mod limits;
pub mod max_size;
pub mod message;
pub mod units;
pub mod version;

pub use deframer::Deframer;
pub use error::{EncodeError, FrameError};
pub use frame::{Frame, FrameBytes, FrameWriter, Header};
pub use ids::*;
pub use key::Key;
pub use max_size::MaxSize;
pub use message::*;
pub use units::*;

/// The book's page is kept true: its examples are compiled and run with the crate's.
#[cfg(doctest)]
#[doc = include_str!("../../docs/protocol.md")]
struct WireProtocolPage;
