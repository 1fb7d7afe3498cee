//! What the event log records: every durable change, when it happened and why.
//!
//! The log is the audit trail, the replay and the crash recovery, so an [`Event`] carries what a
//! person needs to understand it. Names and fields are the log's format: add, never rename.

use protocol::{
    BootEpoch, CommandId, DurationMs, EndReason, EnergyJ, Epoch, FaultCode, LeaseId, LeaseRef, NackReason,
    PileId, Position, ReportId, RequestId, RobotId, SiteMillis, TaskId, TaskPriority,
};
use serde::{Deserialize, Serialize};

use super::decision::Decision;

/// One durable change.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// When.
    pub at: SiteMillis,
    /// What.
    pub fact: Fact,
}

/// What changed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fact {
    /// A coordinator began.
    Started {
        /// Which start it is, for its sessions: greater than in all before.
        boot: BootEpoch,
    },
    /// A coordinator took over, or learned of a higher epoch and went beyond it.
    EpochStarted {
        /// Its epoch.
        epoch: Epoch,
        /// No lease had this number or a higher one.
        next_lease: LeaseId,
    },
    /// A robot asked for a charge, or somebody for it.
    Asked {
        /// Who.
        robot: RobotId,
        /// The robot's start in which it asked; requests are numbered anew in every start.
        boot: BootEpoch,
        /// Its request.
        request: RequestId,
        /// Where it was.
        position: Position,
        /// What its battery held.
        energy: EnergyJ,
        /// What it will work on afterwards, if it knows.
        #[serde(default)]
        task: Option<TaskId>,
        /// How important that is.
        #[serde(default)]
        priority: TaskPriority,
        /// Who asked.
        #[serde(default)]
        opener: Opener,
    },
    /// A robot has done a task, which took this much (Access eq. 1).
    TaskDone {
        /// Who.
        robot: RobotId,
        /// What.
        task: TaskId,
        /// What the run took from its battery.
        energy: EnergyJ,
    },
    /// A robot went back to work without its charge.
    Withdrawn {
        /// Who.
        robot: RobotId,
    },
    /// A pile was chosen for a robot, or none, and why.
    Decided(Decision),
    /// A robot was told to go to a pile; repeats are not recorded.
    Assigned {
        /// Who.
        robot: RobotId,
        /// Where to.
        pile: PileId,
    },
    /// An occupied pile was promised to the robot that uses it next (LMPP's Q2).
    NextReserved {
        /// Which pile.
        pile: PileId,
        /// Who is next.
        robot: RobotId,
    },
    /// The promise could not be kept; the robot waits again.
    NextReleased {
        /// Which pile.
        pile: PileId,
        /// Who was next.
        robot: RobotId,
    },
    /// A pile was given to a robot: a new lease.
    Granted {
        /// Which pile.
        pile: PileId,
        /// The lease.
        lease: LeaseRef,
        /// What the robot's battery lacked.
        energy: EnergyJ,
        /// How the pile is told.
        command: Command,
        /// When it runs out unless extended.
        expiry: SiteMillis,
    },
    /// A lease was to last longer, or its grant was sent anew.
    Extended {
        /// Which pile.
        pile: PileId,
        /// The lease under the coordinator's epoch.
        lease: LeaseRef,
        /// How the pile is told.
        command: Command,
        /// When it runs out now.
        expiry: SiteMillis,
    },
    /// The pile holds to the lease until the expiry it was told last.
    Accepted {
        /// Which pile.
        pile: PileId,
        /// The lease.
        lease: LeaseId,
    },
    /// The pile could not obey yet; it will be asked again under the same lease.
    Deferred {
        /// Which pile.
        pile: PileId,
        /// The lease.
        lease: LeaseId,
        /// Its answer.
        reason: NackReason,
    },
    /// The pile refused a new lease; the robot waits again. The lease lingers until no copy of
    /// its grant can arrive any more.
    Refused {
        /// Which pile.
        pile: PileId,
        /// The lease.
        lease: LeaseId,
        /// Its answer.
        reason: NackReason,
    },
    /// The coordinator took a lease back.
    Revoked {
        /// Which pile.
        pile: PileId,
        /// The lease.
        lease: LeaseRef,
        /// How the pile is told.
        command: Command,
        /// Why.
        why: RevokeReason,
    },
    /// A pile holds to a lease that this coordinator did not know any more, or that the pile made for itself
    /// while it heard no coordinator; it goes on.
    Adopted {
        /// Which pile.
        pile: PileId,
        /// The lease.
        lease: LeaseRef,
    },
    /// A lease is over.
    Ended {
        /// Which pile.
        pile: PileId,
        /// The lease.
        lease: LeaseId,
        /// Whose it was.
        robot: RobotId,
        /// Why.
        why: LeaseEnd,
        /// For how long the robot was charged, as far as known.
        charged: DurationMs,
    },
    /// A pile told which robots passed it (LMPP eq. 4).
    Passed {
        /// Which pile.
        pile: PileId,
        /// Its report.
        report: ReportId,
        /// What to add to the counts.
        passes: Vec<Passes>,
    },
    /// A pile told of a charge that is over, and may forget it now.
    Charged {
        /// Which pile.
        pile: PileId,
        /// Its report.
        report: ReportId,
        /// The lease.
        lease: LeaseId,
        /// Who was charged.
        robot: RobotId,
        /// Why it is over.
        reason: EndReason,
        /// When it began.
        began: SiteMillis,
        /// When it was over; `None` if the pile lost its power in between, and so does not know what
        /// it gave.
        ended: Option<SiteMillis>,
        /// For how long the contacts were live.
        charged: DurationMs,
        /// What went over the contacts.
        energy: EnergyJ,
    },
    /// A pile found a fault, or found it gone.
    FaultReported {
        /// Which pile.
        pile: PileId,
        /// Its report.
        report: ReportId,
        /// Which fault.
        code: FaultCode,
        /// Whether it is there now.
        active: bool,
    },
    /// A pile and a robot say what cannot both be right, for long.
    Contradicted {
        /// Which pile.
        pile: PileId,
        /// Who, if that is known.
        robot: Option<RobotId>,
        /// What.
        what: Contradiction,
    },
    /// They do not any more.
    ContradictionOver {
        /// Which pile.
        pile: PileId,
    },
    /// A pile or robot was not heard for too long.
    FellSilent {
        /// Who.
        who: Device,
    },
    /// It is heard again.
    HeardAgain {
        /// Who.
        who: Device,
    },
    /// The coordinator started at an earlier time than its log had reached: its computer's clock went back.
    ClockSetBack {
        /// By how much, at least.
        by: DurationMs,
    },
    /// A robot cannot move any more: help has to come.
    Stranded {
        /// Who.
        robot: RobotId,
    },
    /// A stranded robot moves again.
    Recovered {
        /// Who.
        robot: RobotId,
    },
    /// A robot can't come to a pile by itself.
    HelpWanted {
        /// Who.
        robot: RobotId,
        /// Where it was.
        position: Position,
        /// Why not.
        plight: Plight,
    },
    /// A mobile charger was sent to it.
    ChargerSent {
        /// Who is to be charged.
        robot: RobotId,
        /// By whom.
        charger: RobotId,
        /// The charger knows the rescue by this number.
        command: CommandId,
        /// How much it is to give.
        energy: EnergyJ,
        /// It is taken for lost if it is not done by then.
        until: SiteMillis,
    },
    /// The mobile charger charges the robot.
    ChargerArrived {
        /// Who is charged.
        robot: RobotId,
    },
    /// The mobile charger does not come, or can't go on; the robot waits for another.
    ChargerFreed {
        /// Who was to be charged.
        robot: RobotId,
        /// Why.
        why: Freed,
    },
    /// Only people can help the robot.
    TowWanted {
        /// Who.
        robot: RobotId,
        /// Why.
        why: TowReason,
    },
    /// A robot needs no help any more.
    HelpEnded {
        /// Who.
        robot: RobotId,
        /// Why.
        why: HelpEnd,
    },
}

/// Why a robot can't come to a pile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Plight {
    /// It cannot move any more.
    Stranded,
    /// No pile is in its reach (the empty set of LMPP eq. 9).
    OutOfReach,
}

/// Why a mobile charger is not waited for any longer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Freed {
    /// It says that it can't.
    GaveUp,
    /// It has not come back in time.
    Late,
    /// It has stranded itself.
    Stranded,
    /// It needs a charge itself.
    Asks,
}

/// Why a robot has to be towed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum TowReason {
    /// There is no mobile charger.
    #[error("there is no mobile charger")]
    NoCharger,
    /// No mobile charger can get to it, now or later.
    #[error("no mobile charger gets there")]
    OutOfChargersReach,
    /// No way leads from it to any pile.
    #[error("no way leads from there to a pile")]
    NoWay,
    /// Several mobile chargers have failed.
    #[error("mobile chargers were sent and have failed")]
    GaveUp,
    /// No mobile charger was free for too long.
    #[error("no mobile charger was free for too long")]
    Waited,
}

/// Why a robot needs no help any more.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HelpEnd {
    /// A mobile charger has given it enough to reach a pile.
    Charged {
        /// How much.
        energy: EnergyJ,
    },
    /// A person says that it was moved.
    Towed {
        /// Where to, if that was said.
        to: Option<Position>,
    },
    /// It moves again, or a pile has come into its reach.
    NotNeeded,
}

/// What a pile and a robot say that cannot both be right.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Contradiction {
    /// A robot stands at a pile without a lease, by the pile's reader or by its own word.
    Unleased,
    /// A robot says that it is charged, and the pile that holds to its lease measures no current.
    NoCurrent,
    /// A pile gives current to the robot of its lease, which says that it is not docked.
    NotDocked,
}

/// Who can fall silent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Device {
    /// A pile.
    Pile(PileId),
    /// A robot.
    Robot(RobotId),
}

/// Who opened a request.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Opener {
    /// The robot itself, at its alert.
    #[default]
    Robot,
    /// The coordinator, which called the robot while it still gets to a pile.
    Coordinator,
    /// A person, or a program of theirs, over the API.
    Person,
}

/// How a pile is told of a grant or a revocation: repeated until answered or out of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Command {
    /// The same in every repeat, never given twice.
    pub id: CommandId,
    /// The pile refuses it later.
    pub valid_until: SiteMillis,
}

/// Passes of one robot in one period of the day.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Passes {
    /// Who passed.
    pub robot: RobotId,
    /// The period of the day (eq. 8).
    pub period: u16,
    /// How often.
    pub passes: u32,
}

/// Why the coordinator takes a lease back.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RevokeReason {
    /// The robot went back to work before its charge began.
    Abandoned,
    /// The robot cannot come any more.
    Stranded,
    /// No way leads the robot there from where it is now.
    NoWay,
    /// Who ordered the charge does not need it any more.
    Withdrawn,
    /// Its robot has enough to work on, and a critical one needs the pile.
    Preempted,
    /// Its robot is charged at another pile, which made a lease for itself.
    Elsewhere,
    /// Another robot stands there, without a lease.
    Occupied,
    /// Its robot says that it is charged, and the pile measures no current.
    NoCurrent,
    /// The pile did not answer in time.
    Unanswered,
    /// The pile reserves its place under a lease that this coordinator does not know.
    Unknown,
}

/// Why a lease is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LeaseEnd {
    /// The pile ended it.
    ByPile(EndReason),
    /// The pile does not know it any more.
    Lost,
    /// It ran out while the pile was silent, or before the pile answered.
    RanOut,
    /// The pile acknowledged its revocation.
    Revoked,
}
