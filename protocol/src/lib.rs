//! What goes over a Chargehand wire.
//!
//! Piles, robots and the coordinator exchange [`Message`]s in [`Frame`]s. This crate says what
//! they look like and nothing else: it does no I/O, allocates nothing and knows no clock, so the
//! same code runs on the pile's microcontroller and in the coordinator.
//!
//! ```text
//!  0x00 | COBS( header 12 bytes | postcard body | CRC-32 ) | 0x00
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`ids`] | who and what a message speaks of |
//! | [`units`] | physical quantities and times, checked when they are decoded |
//! | [`message`] | the one table of all messages |
//! | [`frame`] | header, CRC and COBS around a message |
//! | [`deframer`] | finds frames in a stream of bytes, whatever else is in it |
//! | [`version`] | which protocol versions two devices can speak |
//! | [`limits`] | the largest size of everything, computed at compile time |
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
#![cfg_attr(not(test), no_std)]

pub mod deframer;
pub mod error;
pub mod frame;
pub mod ids;
pub mod limits;
pub mod message;
pub mod units;
pub mod version;

pub use deframer::Deframer;
pub use error::{EncodeError, FrameError};
pub use frame::{Frame, FrameBytes, FrameWriter, Header};
pub use ids::*;
pub use message::*;
pub use units::*;
