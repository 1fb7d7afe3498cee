//! What the coordinator knows for sure: the fold of the event log.
//!
//! [`State`] changes only by [`State::apply`], so folding the same events always gives the same
//! state. A pile has room for one [`Lease`]: a second holder cannot even be written down.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use protocol::{
    BootEpoch, CommandId, DurationMs, EndReason, EnergyJ, Epoch, FaultCode, LeaseId, LeaseRef, PileId,
    Position, ReportId, RequestId, RobotId, SiteMillis, TaskId, TaskPriority,
};

use super::{
    decision::Decision,
    event::{
        Command, Contradiction, Device, Event, Fact, HelpEnd, LeaseEnd, Opener, Plight, RevokeReason,
        TowReason,
    },
    profile::TaskProfile,
};

/// Decisions that are kept for the dashboard; the log has all of them.
pub const KEPT_DECISIONS: usize = 50;

/// Charges that are kept for the dashboard; the log has all of them.
pub const KEPT_CHARGES: usize = 50;

/// All durable state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// The reign of this coordinator; 0 before the first.
    pub epoch: Epoch,
    /// The start it is in.
    pub boot: BootEpoch,
    /// The number of the next lease.
    pub next_lease: LeaseId,
    /// The number of the next command.
    pub next_command: CommandId,
    /// The number of the next decision.
    pub next_decision: u64,
    /// How many requests were opened for robots that had not asked.
    pub calls: u32,
    /// What was promised to whom, for every pile that was ever spoken of.
    pub piles: BTreeMap<PileId, PileRecord>,
    /// The open requests, at most one a robot.
    pub requests: BTreeMap<RobotId, Request>,
    /// How often a robot passed a pile in a period of the day (LMPP eq. 4).
    pub passes: BTreeMap<(RobotId, u16), BTreeMap<PileId, u64>>,
    /// What the tasks of each robot take (Access Table 1, eqs. 1, 2).
    pub profiles: BTreeMap<RobotId, BTreeMap<TaskId, TaskProfile>>,
    /// The newest decisions, newest first.
    pub decisions: VecDeque<Decision>,
    /// The newest charges, newest first.
    pub charges: VecDeque<Charge>,
    /// Who was not heard for too long.
    pub silent: BTreeSet<Device>,
    /// When the last event happened.
    pub last_at: SiteMillis,
    /// Robots that cannot move.
    pub stranded: BTreeSet<RobotId>,
    /// Robots that wait for help.
    pub helps: BTreeMap<RobotId, Help>,
    /// Sums for the operator.
    pub totals: Totals,
}

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

impl State {
    /// The state after these events.
    #[must_use]
    pub fn fold<'a>(events: impl IntoIterator<Item = &'a Event>) -> Self {
        let mut state = Self::default();
        events.into_iter().for_each(|event| state.apply(event));
        state
    }

    /// The lease that is or may be alive on a pile.
    #[must_use]
    pub fn lease(&self, pile: PileId) -> Option<&Lease> {
        self.piles.get(&pile)?.lease.as_ref()
    }

    /// The number of the next request that is opened for a robot that has not asked.
    #[must_use]
    pub const fn next_call(&self) -> RequestId {
        RequestId(RequestId::FIRST_CALL.0.saturating_add(self.calls))
    }

    /// Who is promised the pile next.
    #[must_use]
    pub fn next(&self, pile: PileId) -> Option<RobotId> {
        self.piles.get(&pile)?.next
    }

    /// The share of `robot`'s passes in a period that were at `pile` (LMPP p, eq. 5).
    #[must_use]
    pub fn pass_frequency(&self, robot: RobotId, period: u16, pile: PileId) -> f64 {
        let Some(counts) = self.passes.get(&(robot, period)) else { return 0.0 };
        let passes = counts.get(&pile).copied().unwrap_or(0);
        crate::selection::activity::frequency(passes, counts.values().sum())
    }

    /// Near which piles `robot` is wanted in a period, and how often (LMPP's K).
    pub fn wanted_at(&self, robot: RobotId, period: u16) -> impl Iterator<Item = (PileId, f64)> {
        let counts = self.passes.get(&(robot, period));
        counts.into_iter().flatten().map(|(pile, passes)| (*pile, *passes as f64))
    }

    /// Takes one event in. An event that names what is not there changes nothing.
    pub fn apply(&mut self, event: &Event) {
        let at = event.at;
        self.last_at = at;
        match &event.fact {
            Fact::Started { boot } => self.boot = self.boot.max(*boot),
            Fact::EpochStarted { epoch, next_lease } => self.start_epoch(*epoch, *next_lease),
            Fact::Asked { robot, boot, request, position, energy, task, priority, opener } => {
                let asked = Request {
                    boot: *boot,
                    id: *request,
                    asked_at: at,
                    served: false,
                    decided: false,
                    assigned: None,
                    position: *position,
                    energy: *energy,
                    task: *task,
                    priority: *priority,
                    opener: *opener,
                    place: Place::Waiting,
                };
                if request.is_call() {
                    let number = request.0 - RequestId::FIRST_CALL.0;
                    self.calls = self.calls.max(number.saturating_add(1));
                }
                self.ask(*robot, asked);
            }
            Fact::TaskDone { robot, task, energy } => {
                self.profiles.entry(*robot).or_default().entry(*task).or_default().learn(*energy);
            }
            Fact::Withdrawn { robot } => self.close(*robot),
            Fact::Assigned { robot, pile } => {
                if let Some(request) = self.requests.get_mut(robot) {
                    request.assigned = Some(*pile);
                }
            }
            Fact::Decided(decision) => self.decide(decision),
            Fact::NextReserved { pile, robot } => {
                self.piles.entry(*pile).or_default().next = Some(*robot);
                self.put(*robot, Place::Next(*pile));
            }
            Fact::NextReleased { pile, robot } => {
                self.piles.entry(*pile).or_default().next = None;
                self.put_back(*robot, Place::Next(*pile));
            }
            Fact::Granted { pile, lease, energy, command, expiry } => {
                self.next_lease = self.next_lease.max(lease.lease.next());
                self.spend(*command);
                let record = self.piles.entry(*pile).or_default();
                record.next = record.next.filter(|next| *next != lease.robot);
                record.may_charge_on = false;
                record.lease = Some(Lease {
                    name: *lease,
                    energy: *energy,
                    granted_at: at,
                    expiry: *expiry,
                    phase: Phase::Offered,
                    command: Some(*command),
                });
                self.put(lease.robot, Place::Granted(*pile));
            }
            Fact::Extended { pile, lease, command, expiry } => {
                self.spend(*command);
                if let Some(held) = self.lease_mut(*pile, lease.lease) {
                    held.name = *lease;
                    held.expiry = held.expiry.max(*expiry);
                    held.command = Some(*command);
                }
            }
            Fact::Accepted { pile, lease } => self.accept(at, *pile, *lease),
            Fact::Deferred { pile, lease, .. } => {
                if let Some(lease) = self.lease_mut(*pile, *lease) {
                    lease.command = None;
                }
            }
            Fact::Refused { pile, lease, .. } => {
                let Some(lease) = self.lease_mut(*pile, *lease) else { return };
                lease.expiry = lease.command.take().map_or(at, |command| command.valid_until);
                lease.phase = Phase::Refused;
                let robot = lease.name.robot;
                self.put_back(robot, Place::Granted(*pile));
            }
            Fact::Revoked { pile, lease, command, why } => self.revoke(at, *pile, *lease, *command, *why),
            Fact::Adopted { pile, lease } => {
                let record = self.piles.entry(*pile).or_default();
                record.may_charge_on = false;
                record.next = record.next.filter(|next| *next != lease.robot);
                record.lease = Some(Lease {
                    name: *lease,
                    energy: EnergyJ::MIN,
                    granted_at: at,
                    expiry: at,
                    phase: Phase::Held { until: at },
                    command: None,
                });
                self.put(lease.robot, Place::Granted(*pile));
                // It goes there by itself.
                if lease.lease.is_local()
                    && let Some(request) = self.requests.get_mut(&lease.robot)
                {
                    request.assigned = Some(*pile);
                }
            }
            Fact::Ended { pile, lease, robot, why, .. } => self.end(*pile, *lease, *robot, *why),
            Fact::Passed { pile, report, passes } => {
                self.piles.entry(*pile).or_default().pass_report = Some(*report);
                for one in passes {
                    let counts = self.passes.entry((one.robot, one.period)).or_default();
                    let count = counts.entry(*pile).or_default();
                    *count = count.saturating_add(one.passes.into());
                }
            }
            Fact::Charged { pile, report, lease, robot, reason, began, ended, charged, energy } => {
                self.piles.entry(*pile).or_default().charge_report = Some(*report);
                let (pile, robot, lease, reason) = (*pile, *robot, *lease, *reason);
                let (began, ended, charged, energy) = (*began, *ended, *charged, *energy);
                let id = self.charges.front().map_or(0, |newest| newest.id.saturating_add(1));
                let charge = Charge { id, pile, robot, lease, reason, began, ended, charged, energy };
                self.charges.push_front(charge);
                self.charges.truncate(KEPT_CHARGES);
                self.totals.energy_j += f64::from(charge.energy.get());
            }
            Fact::FaultReported { pile, report, code, active } => {
                let record = self.piles.entry(*pile).or_default();
                if record.fault_report.is_some_and(|last| last.boot != report.boot) {
                    record.faults.clear();
                }
                record.fault_report = Some(*report);
                if *active {
                    record.faults.insert(*code);
                } else {
                    record.faults.remove(code);
                }
            }
            Fact::Contradicted { pile, robot, what } => {
                let contradiction = Contradicted { what: *what, robot: *robot, since: at };
                self.piles.entry(*pile).or_default().contradiction = Some(contradiction);
            }
            Fact::ContradictionOver { pile } => {
                self.piles.entry(*pile).or_default().contradiction = None;
            }
            Fact::FellSilent { who } => _ = self.silent.insert(*who),
            Fact::HeardAgain { who } => _ = self.silent.remove(who),
            Fact::ClockSetBack { .. } => {}
            Fact::Stranded { robot } => {
                self.stranded.insert(*robot);
            }
            Fact::Recovered { robot } => {
                self.stranded.remove(robot);
            }
            Fact::HelpWanted { robot, position, plight } => {
                let (stage, failures) = (HelpStage::Queued, 0);
                let help = Help { since: at, position: *position, plight: *plight, failures, stage };
                self.helps.insert(*robot, help);
            }
            Fact::ChargerSent { robot, charger, command, energy, until } => {
                self.next_command = self.next_command.max(CommandId(command.0.saturating_add(1)));
                let (charger, command, energy, until) = (*charger, *command, *energy, *until);
                let sortie = Sortie { charger, command, energy, until, charging: false };
                self.help(*robot, |help| help.stage = HelpStage::Sent(sortie));
            }
            Fact::ChargerArrived { robot } => self.help(*robot, |help| {
                if let HelpStage::Sent(sortie) = &mut help.stage {
                    sortie.charging = true;
                }
            }),
            Fact::ChargerFreed { robot, .. } => self.help(*robot, |help| {
                help.stage = HelpStage::Queued;
                help.failures = help.failures.saturating_add(1);
            }),
            Fact::TowWanted { robot, why } => self.help(*robot, |help| help.stage = HelpStage::Tow(*why)),
            Fact::HelpEnded { robot, why } => {
                self.helps.remove(robot);
                if matches!(why, HelpEnd::Towed { .. }) {
                    self.stranded.remove(robot);
                }
            }
        }
    }

    /// Commands of the epoch before get no answer any more that counts: leases that are meant to
    /// last are granted again, the others revoked again.
    fn start_epoch(&mut self, epoch: Epoch, next_lease: LeaseId) {
        self.epoch = self.epoch.max(epoch);
        self.next_lease = self.next_lease.max(next_lease);
        for lease in self.piles.values_mut().filter_map(|record| record.lease.as_mut()) {
            lease.command = None;
        }
    }

    fn ask(&mut self, robot: RobotId, new: Request) {
        self.totals.requests = self.totals.requests.saturating_add(1);
        // A robot that asks anew keeps its place, and its time unless it was already served.
        let kept = self.requests.get(&robot).map(|old| Request {
            asked_at: if old.served { new.asked_at } else { old.asked_at },
            place: old.place,
            ..new
        });
        let place = self.found_with(robot).map_or(new.place, Place::Granted);
        self.requests.insert(robot, kept.unwrap_or(Request { place, ..new }));
    }

    /// The pile on which a lease is wanted for a robot: one that has not asked here may have been found on it.
    fn found_with(&self, robot: RobotId) -> Option<PileId> {
        let is_for = |lease: &Lease| lease.name.robot == robot && lease.is_wanted();
        self.piles.iter().find(|(_, record)| record.lease.as_ref().is_some_and(is_for)).map(|(pile, _)| *pile)
    }

    fn decide(&mut self, decision: &Decision) {
        self.next_decision = self.next_decision.max(decision.id.saturating_add(1));
        if let Some(request) = self.requests.get_mut(&decision.robot) {
            request.decided = true;
        }
        self.decisions.push_front(decision.clone());
        self.decisions.truncate(KEPT_DECISIONS);
    }

    fn accept(&mut self, at: SiteMillis, pile: PileId, lease: LeaseId) {
        let Some(lease) = self.lease_mut(pile, lease) else { return };
        lease.phase = Phase::Held { until: lease.expiry };
        lease.command = None;
        let robot = lease.name.robot;
        let Some(request) = self.requests.get_mut(&robot).filter(|request| !request.served) else { return };
        request.served = true;
        let waited = at.since(request.asked_at);
        self.totals.served = self.totals.served.saturating_add(1);
        self.totals.waited_ms = self.totals.waited_ms.saturating_add(waited.0.into());
        self.totals.worst_wait = self.totals.worst_wait.max(waited);
    }

    fn revoke(&mut self, at: SiteMillis, pile: PileId, name: LeaseRef, command: Command, why: RevokeReason) {
        self.spend(command);
        let record = self.piles.entry(pile).or_default();
        let unknown = Lease {
            name,
            energy: EnergyJ::MIN,
            granted_at: at,
            expiry: command.valid_until,
            phase: Phase::Revoking { why },
            command: None,
        };
        let lease = record.lease.get_or_insert(unknown);
        let again = matches!(lease.phase, Phase::Revoking { .. });
        *lease = Lease { name, phase: Phase::Revoking { why }, command: Some(command), ..*lease };
        match why {
            RevokeReason::Abandoned | RevokeReason::Withdrawn => self.close_at(name.robot, pile),
            RevokeReason::Preempted => {
                self.totals.preempted = self.totals.preempted.saturating_add((!again).into());
                self.close_at(name.robot, pile);
            }
            RevokeReason::Stranded
            | RevokeReason::Elsewhere
            | RevokeReason::Occupied
            | RevokeReason::NoCurrent
            | RevokeReason::Unanswered
            | RevokeReason::Unknown => {
                self.put_back(name.robot, Place::Granted(pile));
            }
        }
    }

    fn end(&mut self, pile: PileId, lease: LeaseId, robot: RobotId, why: LeaseEnd) {
        let Some(ended) = self.lease_mut(pile, lease).copied() else { return };
        let record = self.piles.entry(pile).or_default();
        record.lease = None;
        record.may_charge_on = why == LeaseEnd::RanOut && ended.phase != Phase::Refused;
        if why == LeaseEnd::ByPile(EndReason::Completed) {
            self.totals.charges_completed = self.totals.charges_completed.saturating_add(1);
            self.close_at(robot, pile);
        } else {
            self.put_back(robot, Place::Granted(pile));
        }
    }

    fn lease_mut(&mut self, pile: PileId, lease: LeaseId) -> Option<&mut Lease> {
        self.piles.get_mut(&pile)?.lease.as_mut().filter(|held| held.name.lease == lease)
    }

    fn help(&mut self, robot: RobotId, change: impl FnOnce(&mut Help)) {
        if let Some(help) = self.helps.get_mut(&robot) {
            change(help);
        }
    }

    fn spend(&mut self, command: Command) {
        self.next_command = self.next_command.max(CommandId(command.id.0.saturating_add(1)));
    }

    fn put(&mut self, robot: RobotId, place: Place) {
        if let Some(request) = self.requests.get_mut(&robot) {
            request.place = place;
        }
    }

    /// A request that has lost its pile waits again, in its old place in the queue.
    fn put_back(&mut self, robot: RobotId, from: Place) {
        if let Some(request) = self.requests.get_mut(&robot).filter(|request| request.place == from) {
            request.place = Place::Waiting;
        }
    }

    fn close_at(&mut self, robot: RobotId, pile: PileId) {
        if self.requests.get(&robot).is_some_and(|request| request.place == Place::Granted(pile)) {
            self.close(robot);
        }
    }

    fn close(&mut self, robot: RobotId) {
        self.requests.remove(&robot);
    }
}
