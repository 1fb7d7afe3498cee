//! The one table of all messages.
//!
//! | message | from | to | answered by |
//! |---|---|---|---|
//! | [`Hello`] | anyone | anyone | `Hello`, if the other side starts it |
//! | [`PileState`] | pile | coordinator | nothing: it is repeated |
//! | [`PileTable`] | pile, coordinator | piles, robots | nothing: gossip |
//! | [`Grant`], [`Revoke`] | coordinator | pile | [`Ack`] or [`Nack`] |
//! | [`PassReport`], [`Fault`] | pile | coordinator | `Ack` |
//! | [`TimeRequest`] | pile, robot | coordinator | [`TimeSync`] |
//! | [`RobotState`] | robot | coordinator | nothing: it is repeated |
//! | [`ChargeRequest`] | robot | coordinator | [`Assignment`] or [`Unassigned`] |
//!
//! The order of variants and fields is the wire format: see [`version`](crate::version) for what a
//! new version may change.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::{
    ids::{BootEpoch, CommandId, Epoch, LeaseId, PileId, ReportId, RequestId, RobotId, TagId},
    limits,
    units::{CoordinateM, DurationMs, EnergyJ, Fraction, Millis, SiteMillis},
};

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
}

/// All piles' states as the sender knows them (LMPP's Q), a part a frame. The receiver takes
/// every row that is newer than its own, so that rows may come in any order and any number of
/// times (LMPP Figs. 2 and 3 with a stamp for each row).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PileTable {
    /// Some of the table's rows.
    pub rows: Vec<PileRow, { limits::ROWS_PER_TABLE }>,
}

/// Robots that passed a pile (LMPP eq. 4), repeated until acknowledged, one report at a time
/// and in order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PassReport {
    /// Grows by one with every new report since the pile's start.
    pub report: ReportId,
    /// What to add to the counts.
    pub passes: Vec<PassCount, { limits::PASSES_PER_REPORT }>,
}

/// Sends a robot to a pile. A route that does not fit one frame comes in several, which carry
/// the same request; repeated until the robot's [`RobotState::accepted`] names the request.
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
    /// Coordinator: its own epoch. Pile: the highest it has seen. Robot: 0.
    pub epoch: Epoch,
}

/// What a pile does with its one place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Availability {
    /// Nobody is here and nobody is expected.
    Free,
    /// A lease is held; its robot is not here yet.
    Reserved,
    /// A robot is being charged.
    Charging,
    /// The charge is over and the robot still stands here.
    Done,
    /// The pile must not be used.
    Fault,
}

/// What one pile said of itself: a row of the table Q.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PileRow {
    /// Which pile.
    pub pile: PileId,
    /// The pile's start in which it said so; with `version` the age of the row.
    pub boot: BootEpoch,
    /// Grows with every change since that start.
    pub version: u32,
    /// When it said so, if it knew the site's time.
    pub stamp: Option<SiteMillis>,
    /// What the pile does with its place.
    pub availability: Availability,
    /// The share of the planned charge still ahead (LMPP eq. 1): 1 when a charge begins,
    /// 0 when it is done and when there is none.
    pub remaining: Fraction,
    /// The planned time of the charge (LMPP eq. 2); 0 when there is none.
    pub planned: DurationMs,
}

/// A pile's report on itself, at every change and at least every
/// [`limits::STATE_INTERVAL`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PileState {
    /// What others may know too.
    pub row: PileRow,
    /// How long the current charge has run (eq. 1).
    pub elapsed: DurationMs,
    /// The lease the pile holds to.
    pub holder: Option<LeaseRef>,
    /// Whether the contacts are live.
    pub energised: bool,
    /// The lease that ended last since the pile's start, and why.
    pub ended: Option<EndedLease>,
}

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

/// Ends a lease. The pile opens its contacts first, then answers. Revoking a lease that has
/// ended is acknowledged.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Revoke {
    /// Against repeats.
    pub head: CommandHead,
    /// The lease.
    pub lease: LeaseRef,
}

/// Passes of one robot in one period of the day.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PassCount {
    /// The robot's tag.
    pub tag: TagId,
    /// The period T_j of the day, from 0 (eq. 8).
    pub period: u16,
    /// How often it passed since the last report.
    pub passes: u32,
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
    /// A [`Grant`] or [`Revoke`].
    Command(CommandId),
    /// A [`PassReport`] or [`Fault`].
    Report(ReportId),
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
}

/// A fault that appeared or went, repeated until acknowledged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Fault {
    /// Grows by one with every new report since the pile's start.
    pub report: ReportId,
    /// Which.
    pub code: FaultCode,
    /// Whether it is there now.
    pub active: bool,
}

/// What can be wrong with a pile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FaultCode {
    /// The RFID reader does not answer: no robot can be recognised.
    ReaderSilent,
    /// The contactor stays closed though it was told to open.
    ContactorWelded,
    /// The contactor stays open though it was told to close.
    ContactorStuckOpen,
}

/// A point of the site's map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Position {
    /// Metres along x.
    pub x: CoordinateM,
    /// Metres along y.
    pub y: CoordinateM,
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

/// A robot asks for a pile; repeated until answered.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ChargeRequest {
    /// The same in every repeat.
    pub request: RequestId,
    /// Where it is.
    pub position: Position,
    /// What its battery holds (g_real).
    pub energy: EnergyJ,
}

/// No pile for this request now; the robot keeps its place in the queue and may ask again.
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
    /// The coordinator's fleet has no such robot.
    UnknownRobot,
}
