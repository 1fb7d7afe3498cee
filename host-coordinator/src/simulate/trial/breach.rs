//! The promises of the system, and how each can be broken.

use std::fmt;

use protocol::{LeaseId, PileId, RobotId};

use crate::simulate::auditor::Violation;

/// A broken promise.
#[derive(Clone, Debug, PartialEq)]
pub enum Breach {
    /// One holder a pile.
    DoubleGrant(Violation),
    /// No lease beyond its life: a pile still held to one.
    HeldTooLong {
        /// Which pile.
        pile: PileId,
        /// The lease.
        lease: LeaseId,
    },
    /// No lease beyond its life: the coordinator still had one in its book.
    BookedTooLong {
        /// Which pile.
        pile: PileId,
        /// The lease.
        lease: LeaseId,
    },
    /// No robot forgotten: one that asks is not in the coordinator's book though it was heard.
    Forgotten {
        /// Who.
        robot: RobotId,
    },
    /// No robot forgotten: one that stranded was not helped for too long.
    Unhelped {
        /// Who.
        robot: RobotId,
    },
    /// What piles and robots have settled without a coordinator, the coordinator learns: a lease that a pile
    /// made for itself is still not in its book.
    Unreconciled {
        /// Which pile.
        pile: PileId,
        /// The lease.
        lease: LeaseId,
    },
    /// No energy without a lease.
    Unleased {
        /// Which pile.
        pile: PileId,
    },
    /// The facility gives no more power than it has: its piles may draw so much together.
    Overdrawn {
        /// What they may draw, in watts.
        drawn_w: f64,
    },
    /// The event log gives another state than the one that recorded it.
    OtherState,
    /// An event reads back from the log as another.
    OtherEvent {
        /// Its place in the log, from 0.
        index: usize,
    },
}

impl fmt::Display for Breach {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::DoubleGrant(violation) => violation.fmt(f),
            Self::HeldTooLong { pile, lease } => {
                write!(f, "pile {pile} held to lease {lease} beyond its life")
            }
            Self::BookedTooLong { pile, lease } => {
                write!(f, "the coordinator kept lease {lease} of pile {pile} beyond its life")
            }
            Self::Forgotten { robot } => {
                write!(
                    f,
                    "robot {robot} needs a charge or help, was heard, and is not in the coordinator's book"
                )
            }
            Self::Unhelped { robot } => write!(f, "robot {robot} stranded and was not helped"),
            Self::Unreconciled { pile, lease } => write!(
                f,
                "pile {pile} and the coordinator hear each other, and lease {lease}, which the pile made for itself, \
                 is not in the book"
            ),
            Self::Unleased { pile } => write!(f, "pile {pile} gave energy without a lease"),
            Self::Overdrawn { drawn_w } => {
                write!(f, "all piles together may draw {drawn_w:.0} W, more than the facility has")
            }
            Self::OtherState => f.write_str("the event log folds to another state"),
            Self::OtherEvent { index } => write!(f, "event {index} reads back from the log as another"),
        }
    }
}
