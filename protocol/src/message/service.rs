//! What a person's tool asks of a pile, and how a board becomes a pile.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use super::pile::FaultCode;
use crate::{
    ids::{BootEpoch, CommandId, PileId, TagId},
    key::Key,
    limits,
    units::{CurrentA, DurationMs, PowerW, TemperatureC, VoltageV},
};

/// Asks a pile something.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Query {
    /// What.
    pub topic: Topic,
}

/// What a pile can be asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Topic {
    /// Answered by [`PileState`](super::PileState) and [`PileReadings`](super::PileReadings).
    State,
    /// Answered by [`PileFaults`].
    Faults,
    /// Answered by [`PendingPasses`].
    Passes,
    /// Answered by [`PileTable`](super::PileTable) in parts; the last one is not full.
    Table,
    /// Answered by [`PileParameters`].
    Parameters,
}

/// All that is wrong with a pile, or was and has not been cleared. Unasked it is the last word to the
/// coordinator of a pile that loses its mains.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PileFaults {
    /// Each fault once.
    pub faults: Vec<FaultState, { FaultCode::ALL.len() }>,
}

/// One fault of a pile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FaultState {
    /// Which.
    pub code: FaultCode,
    /// Whether its cause is there now.
    pub active: bool,
    /// Whether it stays until [`ClearFault`], whatever its cause does.
    pub latched: bool,
}

/// Clears a latched fault. Refused while its cause is there; a fault that is not latched counts as
/// cleared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ClearFault {
    /// The same in every repeat.
    pub command: CommandId,
    /// Which.
    pub code: FaultCode,
}

/// Passes that were counted and have not been acknowledged by the coordinator.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PendingPasses {
    /// The first of them.
    pub passes: Vec<PendingPass, { limits::PASSES_PER_REPORT }>,
}

/// Passes of one robot in one period of the day that wait to be reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PendingPass {
    /// The robot's tag.
    pub tag: TagId,
    /// The period T_j of the day, from 0 (LMPP eq. 8); none while the pile does not know the time.
    pub period: Option<u16>,
    /// How often it passed.
    pub passes: u32,
}

/// What differs from pile to pile: how it charges and what it bears.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PileParameters {
    /// What the pile gives a robot (g_pertime of LMPP eq. 2).
    pub power: PowerW,
    /// The adjustment of the planned time (eta of eq. 2).
    pub eta: DurationMs,
    /// More than this at the contacts is a fault.
    pub voltage_max: VoltageV,
    /// The most the power stage is told to give; well above it is a fault.
    pub current_max: CurrentA,
    /// From this temperature of the contacts on, the current is reduced.
    pub derate_from: TemperatureC,
    /// At this temperature it is zero, and a fault.
    pub stop_at: TemperatureC,
    /// A tag this strong stands at the contacts, in dBm.
    pub dock_enter_dbm: i8,
    /// A tag weaker than this has left them, in dBm; below `dock_enter_dbm`.
    pub dock_leave_dbm: i8,
}

/// Makes a board a pile: its identity, its keys and its parameters. It is taken by a board that has
/// none, and by one that has while its button is held. The keys go over the wire as they are: this
/// belongs on a cable, at a desk.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Provision {
    /// The same in every repeat.
    pub command: CommandId,
    /// Which pile it is from now on.
    pub pile: PileId,
    /// The key that it shares with the coordinator.
    pub device_key: Key,
    /// The key that all piles of the site share, for gossip.
    pub site_key: Key,
    /// Its next start has at least this number, so that a board that replaces another is newer.
    pub boot_floor: BootEpoch,
    /// How it charges.
    pub parameters: PileParameters,
}
