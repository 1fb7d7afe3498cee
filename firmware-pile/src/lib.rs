//! The charging pile: its behaviour as a pure no_std core, and the boards it runs on.
//!
//! A pile has one place with contacts, an RFID reader that tells which robot stands there, a
//! contactor that makes the contacts live, and a link to the coordinator and the other piles. The
//! core is [`ChargingPile::step`]: time and one input go in, the command to contactor and power
//! stage and messages come out. It reads no clock, waits for nothing and allocates nothing, so the same code runs on
//! the microcontroller, in its emulation, in the simulated site and in the tests.
//!
//! *A tag is read* walks through five rooms: [`firmware_common::reader`] finds the tag in the reader's bytes,
//! [`pile`] takes it as an input, [`lease`] says whom the pile is granted to, [`safety`] whether
//! the contacts may be live, and the command to contactor and power stage goes out.
//!
//! ```
//! use firmware_pile::{ChargingPile, Input, Parameters, Power, To};
//! use protocol::{Message, Millis, PileId};
//!
//! let mut pile = ChargingPile::new(Parameters::new(PileId(7), 150.0));
//! let outputs = pile.step(Millis(0), Input::Tick);
//! assert_eq!(outputs.power, Power::OFF);
//! // Its first word is for the coordinator.
//! let first = outputs.messages.first().map(|outgoing| (outgoing.to, &outgoing.message));
//! assert!(matches!(first, Some((To::Coordinator, Message::Hello(_)))));
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`pile`] | the core: which input concerns which room, and what is said to others; what a tool at a desk is answered |
//! | [`io`] | what goes into a step, and what comes out |
//! | [`parameters`] | what differs from pile to pile |
//! | [`lease`] | who may use the pile, and which commands are obeyed |
//! | [`claims`] | whether the pile may give itself to a robot: only while no coordinator is heard |
//! | [`charge`] | how long a charge takes and how much of it is left (LMPP eqs. 1, 2) |
//! | [`safety`] | whether the contacts may be live, and how they become so and stop being so |
//! | [`faults`] | what is wrong, since when, and what of it has to be told and cleared |
//! | [`scaling`] | what the board's voltages mean |
//! | [`plant`] | a model of what a pile's board is connected to, for tests and emulation |
//! | [`table`] | what all piles said of themselves (LMPP Figs. 1 to 3) |
//! | [`gossip`] | which part of that is told to the other piles when |
//! | [`voice`] | what a pile says of itself to the coordinator, and when |
//! | [`reports`] | reports that are repeated until acknowledged |
//! | [`device`] | a board is nobody yet, or a pile |
//! | [`provisioning`] | how a board becomes a pile, and a board that is none yet |
//! | [`unsaved`] | what of the state is to be stored |
//! | [`store`] | what outlives a loss of power, in two sectors of flash |
//! | [`trust`] | whom a board believes, by the keys of its identity |
//! | `tasks` | the task that runs the core, generic over a board's drivers; only built for ARM |
//! | `board` | the boards it runs on, only built for them |
//!
//! Reader, tags in its field, pass counts, link and supervisor are those of every board:
//! [`firmware_common`].
#![cfg_attr(not(test), no_std)]

#[cfg(all(target_arch = "arm", target_os = "none"))]
pub mod board;
pub mod charge;
pub mod claims;
pub mod device;
pub mod faults;
pub mod gossip;
pub mod io;
pub mod lease;
pub mod parameters;
pub mod pile;
pub mod plant;
pub mod provisioning;
pub mod reports;
pub mod safety;
pub mod scaling;
pub mod store;
pub mod table;
#[cfg(all(target_arch = "arm", target_os = "none"))]
pub mod tasks;
pub mod trust;
pub mod unsaved;
pub mod voice;

pub use io::{Input, Outgoing, Outputs, To};
pub use parameters::Parameters;
pub use pile::ChargingPile;
pub use safety::{Contactor, Power, Sensors};

pub use firmware_common::reader::TagRead;
