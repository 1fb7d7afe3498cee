//! Mobile chargers: robots that are sent to robots which can't come to a pile.
//!
//! A mobile charger is a robot and says all that one does. [`Rescue`] sends it to another robot; while it
//! knows of one it says how far it is by [`RescueState`], and the coordinator answers one that it does not
//! want, any more or yet, by [`Nack`](super::Nack) with [`NackReason::Ended`](super::NackReason::Ended):
//! the charger lets go of it and comes back. So it does not matter who of the two has forgotten what.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use super::robot::Position;
use crate::{
    ids::{CommandId, RobotId},
    limits,
    units::EnergyJ,
};

/// Sends a mobile charger to a robot, to charge it and come back. In parts as an
/// [`Assignment`](super::Assignment); repeated until [`RescueState`] names it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Rescue {
    /// The same in every part and repeat. One that is smaller than another the charger has heard of in its
    /// start is late, and is ignored.
    pub rescue: CommandId,
    /// Whom to charge.
    pub robot: RobotId,
    /// How much to give it.
    pub energy: EnergyJ,
    /// How many waypoints the whole route has.
    pub total: u16,
    /// Which waypoint is the first of this part.
    pub first: u16,
    /// This part of the route, from the charger to the robot.
    pub waypoints: Vec<Position, { limits::WAYPOINTS_PER_PART }>,
}

/// How far a mobile charger is with a [`Rescue`]: at every change and at least every
/// [`limits::STATE_INTERVAL`], until it is told to let go of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RescueState {
    /// Which.
    pub rescue: CommandId,
    /// How far it is.
    pub phase: RescuePhase,
    /// What it has given the robot.
    pub given: EnergyJ,
}

/// How far a rescue is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RescuePhase {
    /// The charger drives to the robot.
    Driving,
    /// It charges the robot.
    Charging,
    /// It has given what it was to give.
    Done,
    /// It can't: it finds no way or no robot, or has too little energy itself.
    GaveUp,
}
