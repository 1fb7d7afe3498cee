//! Why a pile was not asked in full.

use protocol::{DeviceId, FaultCode, FrameError, NackReason, PileId, version};

use super::words;
use crate::{core::view::fault_name, provision::BAUD};

/// Why a session has failed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum DeskError {
    /// No byte.
    #[error("nothing was heard of a pile for 5 s; is it on, and is this its line?")]
    Silent,
    /// Bytes, but no frame.
    #[error(
        "what arrives cannot be read ({error}); is this a pile's line, at {} baud if it is serial?",
        BAUD
    )]
    Unreadable {
        /// What was wrong last.
        error: FrameError,
    },
    /// A board that is no pile yet.
    #[error("this is a board without identity: make it a pile with `chargehand provision`")]
    Factory,
    /// Another device.
    #[error("this is the line of {sender}, not of a pile; connect to the pile's own")]
    WrongDevice {
        /// Whose.
        sender: DeviceId,
    },
    /// It speaks another protocol.
    #[error("{0}")]
    Version(#[from] version::NoCommonVersion),
    /// It has no keys, and we have.
    #[error("pile {pile} runs an insecure image and seals nothing: speak with it with --insecure")]
    Insecure {
        /// Which.
        pile: PileId,
    },
    /// It has keys, and we have none.
    #[error("pile {pile} believes only who has its key: name its site with --site DIR")]
    Sealed {
        /// Which.
        pile: PileId,
    },
    /// We have no key of it.
    #[error("pile {pile} is not among the keys of this site: is it another site's pile?")]
    NoKey {
        /// Which.
        pile: PileId,
    },
    /// We have another key of it.
    #[error(
        "pile {pile} and the keys of this site do not fit together: what it says is not sealed with the key \
         there; is it another site's pile, was it provisioned anew, or did this computer's clock go back?"
    )]
    NotAuthentic {
        /// Which.
        pile: PileId,
    },
    /// It speaks, and does not answer.
    #[error(
        "pile {pile} is heard but has not answered for 5 s; is the line from this computer to the pile \
         broken, or another program on it too?"
    )]
    Unanswered {
        /// Which.
        pile: PileId,
    },
    /// It refused to clear a fault.
    #[error("pile {pile} refuses to clear {}: {}", fault_name(*.code), words::refusal(*.code, *.reason))]
    Refused {
        /// Which.
        pile: PileId,
        /// The fault.
        code: FaultCode,
        /// Its reason.
        reason: NackReason,
    },
}

impl DeskError {
    /// Of a board that is no pile.
    pub(super) const fn of_stranger(sender: DeviceId) -> Self {
        match sender {
            DeviceId::Factory => Self::Factory,
            sender => Self::WrongDevice { sender },
        }
    }

    /// Why a pile that is heard cannot be spoken with, if it is for its keys or ours.
    pub(super) const fn of_keys(pile: PileId, error: FrameError) -> Option<Self> {
        match error {
            FrameError::Unsealed { .. } => Some(Self::Insecure { pile }),
            FrameError::Sealed { .. } => Some(Self::Sealed { pile }),
            FrameError::Stranger { .. } => Some(Self::NoKey { pile }),
            _ => None,
        }
    }
}
