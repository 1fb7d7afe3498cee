//! Who may use a pile: commands, why they are refused, and how leases end.

use serde::{Deserialize, Serialize};

use super::chassis::ChassisRefusal;
use crate::{
    ids::{CommandId, Epoch, LeaseId, RobotId, TagId},
    units::{DurationMs, EnergyJ, SiteMillis},
};

/// A lease by its names. The same lease keeps its number when a new coordinator, with a higher
/// epoch, extends it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LeaseRef {
    /// The epoch of the coordinator that granted or last extended it.
    pub epoch: Epoch,
    /// The lease.
    pub lease: LeaseId,
    /// Who may use the pile.
    pub robot: RobotId,
}

/// What every command carries, against repeats and late arrivals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CommandHead {
    /// The same in every repeat.
    pub id: CommandId,
    /// A command that comes later is refused.
    pub valid_until: SiteMillis,
}

/// Gives a pile to a robot, or extends the lease the robot already has (same
/// [`LeaseRef::lease`]).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Grant {
    /// Against repeats.
    pub head: CommandHead,
    /// The lease.
    pub lease: LeaseRef,
    /// How the pile's reader recognises the robot.
    pub tag: TagId,
    /// When the lease runs out unless extended.
    pub expiry: SiteMillis,
    /// What the robot's battery lacks, g_full - g_real (eq. 2). Fixed by the first grant.
    pub energy: EnergyJ,
}

/// Ends a lease. The pile answers when it has ended; the current is gone within 0.1 s, and the
/// contacts are dead within 0.3 s. Revoking a lease that has ended is acknowledged.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Revoke {
    /// Against repeats.
    pub head: CommandHead,
    /// The lease.
    pub lease: LeaseRef,
}

/// Why a command was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum NackReason {
    /// The pile knows a coordinator with a higher epoch.
    StaleEpoch {
        /// The highest epoch it has seen.
        highest: Epoch,
    },
    /// The command came after its time to live, or the lease had run out on arrival.
    TooLate,
    /// The pile does not know the site's time yet, and so no expiry either.
    ClockUnknown,
    /// Another lease is held.
    Held {
        /// By whom.
        by: LeaseRef,
    },
    /// A robot without a lease stands here.
    Occupied,
    /// The pile has a fault.
    Faulted,
    /// The lease has already ended here; a new charge needs a new lease.
    Ended,
    /// A chassis does not do that.
    Chassis {
        /// Why.
        refusal: ChassisRefusal,
    },
    /// The cause of the fault is still there.
    NotCleared,
    /// The board has an identity, and its button is not held.
    Provisioned,
    /// No claim is taken: the pile hears a coordinator, may serve no claims, or has no room to keep the
    /// account of another charge.
    NotClaimable,
}

/// A lease that is over.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct EndedLease {
    /// Which.
    pub lease: LeaseRef,
    /// Why.
    pub reason: EndReason,
    /// For how long the contacts were live under it.
    pub charged: DurationMs,
}

/// Why a lease is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum EndReason {
    /// The planned charge was given.
    Completed,
    /// It ran out before it was extended.
    Expired,
    /// The coordinator took it back.
    Revoked,
    /// The robot drove off before the end.
    RobotLeft,
    /// The pile found a fault.
    Fault,
}
