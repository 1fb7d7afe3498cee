//! What goes into a step of the core, and what comes out.

use firmware_common::reader::{Seen, TagRead};
use heapless::Vec;
use protocol::{DeviceId, Frame, FrameError, Message, Recipient};

use crate::{
    safety::{Power, Sensors},
    store::Record,
};

/// The most messages a step sends: one of each kind.
pub const MESSAGES_PER_STEP: usize = 8;
/// The most records a step has to store; more come in the next.
pub const RECORDS_PER_STEP: usize = 4;

/// What can happen to a pile.
#[derive(Clone, Copy, Debug)]
pub enum Input<'a> {
    /// Time has passed; at least every 100 ms.
    Tick,
    /// The sensors were read; every 10 ms on a board, at least every 100 ms.
    Sensors(Sensors),
    /// The reader read a tag.
    Tag(TagRead),
    /// The reader answered that nothing is in its field.
    ReaderIdle,
    /// A frame arrived.
    Frame(&'a Frame),
    /// Something arrived on the link that is no frame, or none to be believed.
    Discarded(FrameError),
    /// What the step before asked to store is not stored, or not all of it; its messages did not go
    /// out. Given at once, before any other input.
    StoreFailed,
    /// The button was pressed, or let go.
    Button {
        /// Which of the two.
        held: bool,
    },
}

impl From<Seen> for Input<'_> {
    fn from(seen: Seen) -> Self {
        match seen {
            Seen::Nothing => Self::ReaderIdle,
            Seen::Tag(read) => Self::Tag(read),
        }
    }
}

/// Whom a message is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum To {
    /// The coordinator.
    Coordinator,
    /// A person's tool.
    Service,
    /// All other piles, and the robots that have the site's key.
    Peers,
    /// Who sent a [`Provision`](protocol::Provision), whoever that is.
    Provisioner,
}

impl From<To> for Recipient {
    fn from(to: To) -> Self {
        match to {
            To::Coordinator => Self::Device(DeviceId::Coordinator),
            To::Service => Self::Device(DeviceId::Service),
            To::Peers => Self::Piles,
            To::Provisioner => Self::Provisioner,
        }
    }
}

/// A message to send.
#[derive(Clone, Debug, PartialEq)]
pub struct Outgoing {
    /// To whom.
    pub to: To,
    /// What.
    pub message: Message,
}

/// The messages of a step.
pub type Messages = Vec<Outgoing, MESSAGES_PER_STEP>;

/// The records of a step.
pub type Records = Vec<Record, RECORDS_PER_STEP>;

/// What a step asks of the shell: the power first, then the store, then the messages. By default nothing,
/// with the power off.
#[derive(Clone, Debug, Default)]
pub struct Outputs {
    /// The command to contactor and power stage from now on.
    pub power: Power,
    /// What must be in non-volatile memory before the messages go out.
    pub store: Records,
    /// Whether the messages go out ahead of all that wait, whatever becomes of those: they may be
    /// the last.
    pub urgent: bool,
    /// What to send, in order.
    pub messages: Messages,
    /// Whether the board is to restart after that: it has become another pile.
    pub restart: bool,
}
