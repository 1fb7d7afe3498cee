//! What goes over a Chargehand wire.
//!
//! Piles, robots and the coordinator exchange [`Message`]s in [`Frame`]s. This crate says what
//! they look like and nothing else: it does no I/O, allocates nothing and knows no clock, so the
//! same code runs on the pile's microcontroller and in the coordinator.
//!
//! ```text
//!  0x00 | COBS( packet ) | 0x00
//!
//!  packet   0        1      2        4            8          12      n-20   n-4
//!           version  kind   number   boot epoch   sequence   body    MAC    CRC-32
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`ids`] | who and what a message speaks of |
//! | [`key`] | the secret two devices share |
//! | [`units`] | physical quantities and times, checked when they are decoded |
//! | [`message`] | the one table of all messages |
//! | [`frame`] | header, seal, CRC and COBS around a message |
//! | [`deframer`] | finds packets in a stream of bytes, whatever else is in it |
//! | [`packet`] | a frame that is intact and not yet believed |
//! | [`auth`] | who sent it, and that it is new: keys, seals, sessions |
//! | [`version`] | which protocol versions two devices can speak |
//! | [`max_size`] | how large a message can get, computed from its parts |
//! | [`limits`] | the sizes of everything else, and the intervals |
//! | [`error`] | what can be wrong with bytes from a wire |
//!
//! ```
//! use protocol::{
//!     BootEpoch, Deframer, DeviceId, Epoch, Hello, Key, Message, PileId, Recipient, Session, Sessions, Trust,
//! };
//!
//! // What both have, from provisioning.
//! let key = Key::new([7; 32]);
//! let pile = DeviceId::Pile(PileId(7));
//! let peers = [Session::new(DeviceId::Coordinator, key)];
//! let mut sender = Sessions::new(pile, BootEpoch(3), Trust::Keys { site: None, peers });
//! let peers = [Session::new(pile, key)];
//! let mut receiver = Sessions::new(DeviceId::Coordinator, BootEpoch(5), Trust::Keys { site: None, peers });
//!
//! let message = Message::Hello(Hello { min: 1, current: 1, software: [0, 1, 2], epoch: Epoch(300) });
//! let bytes = sender.seal(Recipient::Device(DeviceId::Coordinator), &message)?;
//!
//! let mut deframer = Deframer::new();
//! let mut received = Vec::new();
//! deframer.feed(&bytes, |found| received.push(found.and_then(|packet| receiver.open(packet))));
//! assert!(matches!(&received[..], [Ok(frame)] if frame.header.sender == pile && frame.message == message));
//! # Ok::<(), protocol::SealError>(())
//! ```
//!
//! # Sizing
//! All sizes are computed at compile time; a test keeps these tables true. The largest body of every
//! message, ordinal included, and what that makes of a frame:
//!
//! | message | bytes |
//! |---|---|
//! | `Hello` | 11 |
//! | `PileState` | 89 |
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
//! | `ChargeRequest` | 23 |
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
//! | `PendingPasses` | 170 |
//! | `PileParameters` | 28 |
//! | `ClearFault` | 7 |
//! | `Provision` | 105 |
//! | `Rescue` | 212 |
//! | `RescueState` | 11 |
//! | `ClaimPile` | 40 |
//! | `ClaimRule` | 2 |
//!
//! | part | bytes |
//! |---|---|
//! | header | 12 |
//! | largest body | 242 |
//! | MAC | 16 |
//! | check | 4 |
//! | largest packet | 274 |
//! | largest frame | 278 |
//!
//! A [`Deframer`] holds one frame and nothing else; encoding takes a packet and a frame of stack.
//!
//! # Compatibility
//! The rules are in [`version`]; `tests/versioning/` keeps the bytes of every message. For writing a
//! client, also in another language, see the book's page on the wire protocol.
#![no_std]

pub mod auth;
pub mod deframer;
pub mod error;
pub mod frame;
pub mod ids;
pub mod key;
pub mod limits;
pub mod max_size;
pub mod message;
pub mod packet;
pub mod units;
pub mod version;

pub use auth::{Recipient, Session, Sessions, Trust};
pub use deframer::Deframer;
pub use error::{EncodeError, FrameError, SealError};
pub use frame::{Frame, FrameBytes, Header};
pub use ids::*;
pub use key::Key;
pub use max_size::MaxSize;
pub use message::*;
pub use packet::Packet;
pub use units::*;

/// The book's page is kept true: its examples are compiled and run with the crate's.
#[cfg(doctest)]
#[doc = include_str!("../../docs/protocol.md")]
struct WireProtocolPage;
