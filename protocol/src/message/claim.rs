//! What a robot and a pile settle between them while no coordinator is heard.
//!
//! A claim goes under the site's key ([`Recipient::Piles`](crate::Recipient)), which has no sessions. What
//! keeps a recorded claim from being believed again is the row of the pile that it names: the pile takes
//! it only while that row is fresh.

use serde::{Deserialize, Serialize};

use crate::{
    ids::{BootEpoch, PileId, RequestId, RobotId, TagId},
    units::{DurationMs, EnergyJ},
};

/// A robot that hears piles but no coordinator asks a pile for itself; repeated until answered by an
/// [`Ack`](crate::Ack) or [`Nack`](crate::Nack) of [`Reference::Claim`](crate::Reference). A claim that was
/// granted is acknowledged again.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ClaimPile {
    /// The request for a charge that no coordinator has answered.
    pub request: RequestId,
    /// Which pile.
    pub pile: PileId,
    /// The pile's start, from its row of the gossiped table.
    pub boot: BootEpoch,
    /// The version of that row.
    pub version: u32,
    /// How the pile's reader recognises the robot.
    pub tag: TagId,
    /// What its battery will lack when it is there.
    pub energy: EnergyJ,
    /// It will be there within this.
    pub within: DurationMs,
}

/// A claim by its names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ClaimRef {
    /// Who claims.
    pub robot: RobotId,
    /// For which of its requests.
    pub request: RequestId,
}

/// Whether a pile may serve claims while no coordinator is heard. A coordinator says so with every
/// [`TimeSync`](crate::TimeSync) to a pile; a pile that was not told since its start may not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ClaimRule {
    /// Whether.
    pub allowed: bool,
}
