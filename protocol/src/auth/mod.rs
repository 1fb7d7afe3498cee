//! Who sent a frame, and that it is new: keys, seals, sessions.
//!
//! Every device has a key of its own, which the coordinator has too. A frame carries a MAC made with
//! it ([`seal`]). What keeps a recorded frame from being believed again is a **session**, the pair of
//! both sides' boot epochs:
//!
//! - A frame is bound to the receiver's current start, which the sender knows from the receiver's
//!   frames. Only a `Hello` is bound to none, so that two devices can find each other; until the other
//!   side was heard, nothing else is sent to it.
//! - A receiver takes a frame if its (boot epoch, sequence) is greater than that of the last it took
//!   from that sender in its own start.
//!
//! So a frame of an earlier start of its receiver fails its MAC, and one of an earlier start of its
//! sender, or a repeat, is not greater. Nothing has to be stored but a device's own count of its starts,
//! which must grow with every one. Who restarts is refused until it has heard the other's `Hello`:
//! who gets a frame that does not authenticate ([`FrameError::Unauthentic`](crate::FrameError))
//! answers it with a `Hello`, at most once in [`REPEAT_INTERVAL`](crate::limits::REPEAT_INTERVAL).
//!
//! Gossip is for all piles at once and has a key that they share with each other and with robots; its rows
//! say themselves how old they are, so that it needs no session. A robot's claim to a pile goes under that
//! key too and names a fresh row. Nothing else is believed under it.

pub mod seal;
mod sessions;

pub use sessions::{Recipient, Session, Sessions, Trust};
