//! What [`State`](super::State) is made of.

use std::collections::BTreeSet;

use protocol::{
    BootEpoch, CommandId, DurationMs, EndReason, EnergyJ, FaultCode, LeaseId, LeaseRef, PileId, Position,
    ReportId, RequestId, RobotId, SiteMillis, TaskId, TaskPriority,
};

use crate::core::event::{Command, Contradiction, Opener, Plight, RevokeReason, TowReason};

/// What is durable about one pile.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PileRecord {
    /// The lease that is or may be alive there. While there is one, there is no other.
    pub lease: Option<Lease>,
    /// Who is promised the pile when it is free again.
    pub next: Option<RobotId>,
    /// Whether its last lease ran out while it was silent: it may charge on under it, until it is heard.
    pub may_charge_on: bool,
    /// The faults it has, as far as it reported them in the start of `fault_report`.
    pub faults: BTreeSet<FaultCode>,
    /// The last fault report.
    pub fault_report: Option<ReportId>,
    /// The last pass report.
    pub pass_report: Option<ReportId>,
    /// The last charge report.
    pub charge_report: Option<ReportId>,
    /// What it and a robot say that cannot both be right.
    pub contradiction: Option<Contradicted>,
}

/// A contradiction that lasts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contradicted {
    /// What.
    pub what: Contradiction,
    /// With whom, if that is known.
    pub robot: Option<RobotId>,
    /// Since when it is recorded.
    pub since: SiteMillis,
}

impl Contradicted {
    /// What, and with whom.
    #[must_use]
    pub const fn seen(&self) -> (Contradiction, Option<RobotId>) {
        (self.what, self.robot)
    }
}

/// A charge that is over, as its pile told of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Charge {
    /// Counts the charges.
    pub id: u64,
    /// Which pile.
    pub pile: PileId,
    /// Who was charged.
    pub robot: RobotId,
    /// Under which lease.
    pub lease: LeaseId,
    /// Why it is over.
    pub reason: EndReason,
    /// When it began.
    pub began: SiteMillis,
    /// When it was over; `None` if the pile lost its power in between.
    pub ended: Option<SiteMillis>,
    /// For how long the contacts were live.
    pub charged: DurationMs,
    /// What went over the contacts.
    pub energy: EnergyJ,
}

/// A pile's promise to one robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lease {
    /// Its names; the epoch is that of the last command about it.
    pub name: LeaseRef,
    /// What the robot's battery lacked when it was granted.
    pub energy: EnergyJ,
    /// When it was granted.
    pub granted_at: SiteMillis,
    /// The latest instant until which the pile may believe in it.
    pub expiry: SiteMillis,
    /// How far it has come.
    pub phase: Phase,
    /// The command about it that waits for an answer.
    pub command: Option<Command>,
}

/// How far a lease has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// The pile has not answered.
    Offered,
    /// The pile holds to it, at least until this instant.
    Held {
        /// The latest expiry that the pile acknowledged.
        until: SiteMillis,
    },
    /// The pile refused it. Copies of the grant may still be on their way until `expiry`.
    Refused,
    /// It was taken back, which the pile has not acknowledged.
    Revoking {
        /// Why.
        why: RevokeReason,
    },
}

impl Lease {
    /// Whether the lease is meant to last.
    #[must_use]
    pub const fn is_wanted(&self) -> bool {
        matches!(self.phase, Phase::Offered | Phase::Held { .. })
    }

    /// Whether a pile means this lease by `named`, whose epoch may be an earlier one. The robot counts,
    /// because a coordinator on a copy of the log gives the same numbers.
    #[must_use]
    pub fn is_called(&self, named: LeaseRef) -> bool {
        (named.lease, named.robot) == (self.name.lease, self.name.robot)
    }
}

/// A robot's request for a charge, from its first message until the charge is complete.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    /// The robot's start in which it asked.
    pub boot: BootEpoch,
    /// The newest number under which it asked.
    pub id: RequestId,
    /// When it asked first.
    pub asked_at: SiteMillis,
    /// Whether a pile has accepted a lease for it.
    pub served: bool,
    /// Whether a decision for it is in the log.
    pub decided: bool,
    /// The pile that the robot was told to go to last.
    pub assigned: Option<PileId>,
    /// Where it was when it asked.
    pub position: Position,
    /// What its battery held.
    pub energy: EnergyJ,
    /// What it will work on afterwards, if it knows.
    pub task: Option<TaskId>,
    /// How important that is (Access T_tp).
    pub priority: TaskPriority,
    /// Who opened it.
    pub opener: Opener,
    /// Where it stands in the queue.
    pub place: Place,
}

/// Where a request stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// In the queue.
    Waiting,
    /// Next at an occupied pile.
    Next(PileId),
    /// A lease on this pile is wanted for it.
    Granted(PileId),
}

/// The help that a robot waits for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Help {
    /// Since when.
    pub since: SiteMillis,
    /// Where it was then.
    pub position: Position,
    /// Why it needs help.
    pub plight: Plight,
    /// How many mobile chargers have failed.
    pub failures: u8,
    /// How far its help is.
    pub stage: HelpStage,
}

/// How far help is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HelpStage {
    /// It waits for a mobile charger.
    Queued,
    /// One is sent.
    Sent(Sortie),
    /// People have to tow it.
    Tow(TowReason),
}

/// A mobile charger that is sent to a robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sortie {
    /// Which charger.
    pub charger: RobotId,
    /// By which number it knows of it.
    pub command: CommandId,
    /// How much it is to give.
    pub energy: EnergyJ,
    /// It is taken for lost if it is not done by then.
    pub until: SiteMillis,
    /// Whether it charges the robot.
    pub charging: bool,
}

impl Help {
    /// The mobile charger that is sent.
    #[must_use]
    pub const fn sortie(&self) -> Option<&Sortie> {
        match &self.stage {
            HelpStage::Sent(sortie) => Some(sortie),
            HelpStage::Queued | HelpStage::Tow(_) => None,
        }
    }

    /// Whether a mobile charger charges the robot now.
    #[must_use]
    pub fn is_charging(&self) -> bool {
        self.sortie().is_some_and(|sortie| sortie.charging)
    }
}

/// Sums since the log began.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Totals {
    /// Requests.
    pub requests: u64,
    /// Charges that were given in full.
    pub charges_completed: u64,
    /// Charges that were cut short for a critical robot.
    pub preempted: u64,
    /// What all charges gave, as the piles measured it, in joules.
    pub energy_j: f64,
    /// Requests that a pile accepted.
    pub served: u64,
    /// The sum of the times from first asking to the pile's acceptance, in milliseconds.
    pub waited_ms: u64,
    /// The longest of those.
    pub worst_wait: DurationMs,
}

impl Totals {
    /// The mean time from first asking to a pile's acceptance, in seconds; 0 if no pile has accepted any.
    #[must_use]
    pub fn mean_wait_s(&self) -> f64 {
        if self.served == 0 { 0.0 } else { self.waited_ms as f64 / 1000.0 / self.served as f64 }
    }

    /// The longest of those.
    #[must_use]
    pub fn worst_wait_s(&self) -> f64 {
        f64::from(self.worst_wait.0) / 1000.0
    }
}
