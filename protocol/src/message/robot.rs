//! What a robot says of itself, what it asks for, and where it is sent.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::{
    ids::{PileId, RequestId, TaskId},
    limits,
    units::{CoordinateM, EnergyJ, TaskPriority},
};

/// A point of the site's map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Position {
    /// Metres along x.
    pub x: CoordinateM,
    /// Metres along y.
    pub y: CoordinateM,
}

/// A robot's report on itself, at every change and at least every
/// [`limits::STATE_INTERVAL`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RobotState {
    /// Where it is.
    pub position: Position,
    /// What its battery holds (g_real).
    pub energy: EnergyJ,
    /// What it does.
    pub activity: Activity,
    /// The assignment it follows, with its whole route.
    pub accepted: Option<RequestId>,
}

/// What a robot does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Activity {
    /// Its task.
    Working,
    /// Waits for a pile.
    Waiting,
    /// Drives to its pile.
    Approaching,
    /// Stands at its pile.
    Docked,
    /// Cannot move any more.
    Stranded,
    /// Stands at its pile, and current flows into its battery.
    Charging,
}

/// A robot asks for a pile; repeated until answered (Access eq. 6's Psi).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ChargeRequest {
    /// The same in every repeat.
    pub request: RequestId,
    /// Where it is.
    pub position: Position,
    /// What its battery holds (g_real; P_rbp).
    pub energy: EnergyJ,
    /// What it will work on after its charge, if it knows.
    pub task: Option<TaskId>,
    /// How important that is (T_tp).
    pub priority: TaskPriority,
}

/// Sends a robot to a pile. A route that does not fit one frame comes in several, which carry
/// the same request; repeated until the robot's [`RobotState::accepted`] names the request.
///
/// Where the request [is a call](RequestId::is_call) the robot has not asked: it leaves its work and follows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Assignment {
    /// The request that is answered.
    pub request: RequestId,
    /// Where to charge.
    pub pile: PileId,
    /// How many waypoints the whole route has.
    pub total: u16,
    /// Which waypoint is the first of this part.
    pub first: u16,
    /// This part of the route, from the robot to the pile.
    pub waypoints: Vec<Position, { limits::WAYPOINTS_PER_PART }>,
}

/// No pile for this request now; the robot keeps its place in the queue and may ask again, unless the request
/// is withdrawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Unassigned {
    /// The request that is answered.
    pub request: RequestId,
    /// Why.
    pub reason: UnassignedReason,
}

/// Why a robot gets no pile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum UnassignedReason {
    /// All piles in reach are taken: wait.
    AllTaken,
    /// No pile is in reach (the empty set of LMPP eq. 9): help has to come.
    OutOfReach,
    /// Who opened the request took it back: the robot goes on with its work.
    Withdrawn,
}
