//! The one table of all messages.
//!
//! | message | from | to | answered by |
//! |---|---|---|---|
//! | [`Hello`] | anyone | anyone | `Hello`, if the other side starts it |
//! | [`PileState`] | pile | coordinator | nothing: it is repeated |
//! | [`PileTable`] | pile, coordinator | piles, robots | nothing: gossip |
//! | [`Grant`], [`Revoke`] | coordinator | pile | [`Ack`] or [`Nack`] |
//! | [`PassReport`], [`ChargeReport`], [`Fault`] | pile | coordinator | `Ack` |
//! | [`PassReport`] | chassis | robot | `Ack` |
//! | [`TimeRequest`] | pile, robot | coordinator | [`TimeSync`] |
//! | [`TimeRequest`] | chassis | robot | `TimeSync`, once the robot knows the time |
//! | [`RobotState`] | robot | coordinator | nothing: it is repeated |
//! | [`ChargeRequest`] | robot | coordinator | [`Assignment`] or [`Unassigned`] |
//! | [`Drive`], [`Stop`], [`Release`] | robot | chassis | `Ack` or `Nack` |
//! | [`Task`] | robot | chassis | `Ack` and, if a task ended, [`TaskEnergy`]; or `Nack` |
//! | [`TaskEnergy`] | robot | coordinator | nothing: what is lost is learned from the next |
//! | [`Rescue`] | coordinator | mobile charger | [`RescueState`] |
//! | [`RescueState`] | mobile charger | coordinator | `Nack`, if it is to let go |
//! | [`Odometry`], [`ChassisState`] | chassis | robot | nothing: they are repeated |
//! | [`Query`] | service tool | pile | what its [`Topic`] says |
//! | [`ClearFault`] | service tool, coordinator | pile | `Ack` or `Nack` |
//! | [`Provision`] | service tool | board | `Ack` or `Nack` |
//! | [`ClaimPile`] | robot | pile | `Ack` or `Nack` |
//! | [`ClaimRule`] | coordinator | pile | nothing: it is repeated |
//!
//! The order of variants and fields is the wire format: see [`version`] for what a
//! new version may change.

use serde::{Deserialize, Serialize};

use crate::{
    ids::{CommandId, Epoch, ReportId},
    units::{Millis, SiteMillis},
    version,
};

mod chassis;
mod claim;
mod lease;
mod pile;
mod rescue;
mod robot;
mod service;

pub use chassis::*;
pub use claim::*;
pub use lease::*;
pub use pile::*;
pub use rescue::*;
pub use robot::*;
pub use service::*;

/// Everything that can be said.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Message {
    /// See [`Hello`].
    Hello(Hello),
    /// See [`PileState`].
    PileState(PileState),
    /// See [`PileTable`].
    PileTable(PileTable),
    /// See [`Grant`].
    Grant(Grant),
    /// See [`Revoke`].
    Revoke(Revoke),
    /// See [`PassReport`].
    PassReport(PassReport),
    /// See [`TimeRequest`].
    TimeRequest(TimeRequest),
    /// See [`TimeSync`].
    TimeSync(TimeSync),
    /// See [`Ack`].
    Ack(Ack),
    /// See [`Nack`].
    Nack(Nack),
    /// See [`Fault`].
    Fault(Fault),
    /// See [`RobotState`].
    RobotState(RobotState),
    /// See [`ChargeRequest`].
    ChargeRequest(ChargeRequest),
    /// See [`Assignment`].
    Assignment(Assignment),
    /// See [`Unassigned`].
    Unassigned(Unassigned),
    /// See [`Drive`].
    Drive(Drive),
    /// See [`Stop`].
    Stop(Stop),
    /// See [`Release`].
    Release(Release),
    /// See [`Task`].
    Task(Task),
    /// See [`TaskEnergy`].
    TaskEnergy(TaskEnergy),
    /// See [`Odometry`].
    Odometry(Odometry),
    /// See [`ChassisState`].
    ChassisState(ChassisState),
    /// See [`PileReadings`].
    PileReadings(PileReadings),
    /// See [`ChargeReport`].
    ChargeReport(ChargeReport),
    /// See [`Query`].
    Query(Query),
    /// See [`PileFaults`].
    PileFaults(PileFaults),
    /// See [`PendingPasses`].
    PendingPasses(PendingPasses),
    /// See [`PileParameters`].
    PileParameters(PileParameters),
    /// See [`ClearFault`].
    ClearFault(ClearFault),
    /// See [`Provision`].
    Provision(Provision),
    /// See [`Rescue`].
    Rescue(Rescue),
    /// See [`RescueState`].
    RescueState(RescueState),
    /// See [`ClaimPile`].
    ClaimPile(ClaimPile),
    /// See [`ClaimRule`].
    ClaimRule(ClaimRule),
}

impl Message {
    /// Whether it may go under the site's key, which has no sessions: gossip, and claims with their answers.
    #[must_use]
    pub const fn is_of_site(&self) -> bool {
        matches!(
            self,
            Self::PileTable(_)
                | Self::ClaimPile(_)
                | Self::Ack(Ack { of: Reference::Claim(_) })
                | Self::Nack(Nack { of: Reference::Claim(_), .. })
        )
    }
}

/// The first message of a device after its start, and its answer. Its layout is frozen, so that
/// two devices can say which versions they speak before they know which both speak.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Hello {
    /// The oldest protocol version the sender speaks.
    pub min: u8,
    /// The newest.
    pub current: u8,
    /// The sender's software: major, minor, patch.
    pub software: [u8; 3],
    /// Coordinator: its own epoch. Pile: the highest it has seen. Robot and chassis: 0.
    pub epoch: Epoch,
}

impl Hello {
    /// What this software says of itself. `epoch` as in [`Self::epoch`].
    #[must_use]
    pub const fn new(epoch: Epoch) -> Self {
        Self { min: version::MIN, current: version::CURRENT, software: version::SOFTWARE, epoch }
    }
}

/// Asks for the site's time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TimeRequest {
    /// The asker's clock.
    pub asked_at: Millis,
}

/// The site's time. The asker knows from `asked_at` how old the answer can be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TimeSync {
    /// Copied from the request.
    pub asked_at: Millis,
    /// The site's time when the answer was sent.
    pub site_now: SiteMillis,
}

/// What an [`Ack`] or [`Nack`] answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reference {
    /// A [`Grant`], [`Revoke`], [`Drive`], [`Stop`], [`Release`], [`Task`], [`ClearFault`] or
    /// [`Provision`], or a [`Rescue`].
    Command(CommandId),
    /// A [`PassReport`], [`ChargeReport`] or [`Fault`].
    Report(ReportId),
    /// A [`ClaimPile`].
    Claim(ClaimRef),
}

/// Done, now or before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ack {
    /// What was done.
    pub of: Reference,
}

/// Not done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Nack {
    /// What was not done.
    pub of: Reference,
    /// Why.
    pub reason: NackReason,
}
