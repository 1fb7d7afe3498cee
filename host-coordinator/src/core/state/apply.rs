//! What each event of the log changes.

use protocol::{
    CommandId, EndReason, EnergyJ, Epoch, LeaseId, LeaseRef, PileId, RequestId, RobotId, SiteMillis,
};

use super::{
    Charge, Contradicted, Help, HelpStage, KEPT_CHARGES, KEPT_DECISIONS, Lease, Phase, Place, Request,
    Sortie, State,
};
use crate::core::{
    decision::Decision,
    event::{Command, Event, Fact, HelpEnd, LeaseEnd, RevokeReason},
};

impl State {
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
            | RevokeReason::NoWay
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
