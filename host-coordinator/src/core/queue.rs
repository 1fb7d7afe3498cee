//! Robots that ask: who waits, who is given which pile, and what they are told.
//!
//! A request is never dropped. It waits, is tried again together with all others at every change, by the
//! policy that is configured ([`selection::policy`](crate::selection::policy)), and is closed by a complete charge or by its robot, which goes back to work.

use std::collections::BTreeSet;

use protocol::{
    Activity, Assignment, Availability, BootEpoch, ChargeRequest, DeviceId, Message, PileId, RobotId,
    SiteMillis, Unassigned, UnassignedReason, limits,
};

use super::{
    coordinator::Coordinator,
    decision::Decision,
    event::{Fact, Opener, Plight, RevokeReason},
    observed::{Route, Told},
    routes::{Part, parts},
    state::{Help, Phase, Place, Request},
    turn::Turn,
};
use crate::selection::{Asker, Choice, Offer, Situation, Stage};

impl Coordinator {
    /// A robot asks. Its frames come in order, so another number than before is a new request.
    pub(super) fn hear_request(
        &mut self,
        turn: &mut Turn,
        robot: RobotId,
        boot: BootEpoch,
        asked: ChargeRequest,
    ) {
        let ChargeRequest { request, position, energy, task, priority } = asked;
        let seen = self.observed.robots.entry(robot).or_default();
        seen.last = Some((position, energy));
        let open = self.state.requests.get(&robot);
        if open.is_some_and(|open| (open.boot, open.id) == (boot, request)) {
            // It has not heard the answer.
            if seen.told.is_some_and(|(_, at)| turn.now.since(at) >= limits::REPEAT_INTERVAL) {
                seen.told = None;
            }
            return;
        }
        seen.left_work = seen.working_since.is_none() && seen.report.is_some();
        seen.working_since = seen.working_since.map(|_| turn.now);
        seen.told = None;
        // A robot that started anew counts its requests anew too.
        seen.route = None;
        let opener = Opener::Robot;
        self.record(turn, Fact::Asked { robot, boot, request, position, energy, task, priority, opener });
        self.observed.queue_is_due = true;
    }

    /// Closes the requests of those of `robots` that went back to work.
    pub(super) fn withdraw_requests(&mut self, turn: &mut Turn, robots: &[RobotId]) {
        for &robot in robots {
            if !self.is_back_at_work(robot) {
                continue;
            }
            let Some(request) = self.state.requests.get(&robot) else { continue };
            match request.place {
                Place::Waiting => self.record(turn, Fact::Withdrawn { robot }),
                Place::Next(pile) => {
                    self.record(turn, Fact::NextReleased { pile, robot });
                    self.record(turn, Fact::Withdrawn { robot });
                }
                // The lease has to be taken back first.
                Place::Granted(_) => {}
            }
        }
    }

    /// Tries to find a pile for every robot in the queue, at every change and every second.
    pub(super) fn serve_queue(&mut self, turn: &mut Turn) {
        let observed = &mut self.observed;
        if !observed.queue_is_due && turn.now.since(observed.queue_served_at) < limits::REPEAT_INTERVAL {
            return;
        }
        observed.queue_is_due = false;
        observed.queue_served_at = turn.now;
        let waiting = self.state.requests.iter().filter(|(_, of)| of.place == Place::Waiting);
        let waiting: Vec<_> = waiting.map(|(robot, request)| (*robot, *request)).collect();
        // A robot that a pile holds to gets no other: the lease is adopted or taken back first.
        let reports = self.site.piles.iter().filter_map(|pile| self.observed.report(pile.id, turn.now));
        let holders: BTreeSet<_> =
            reports.filter_map(|report| report.holder).map(|lease| lease.robot).collect();
        let can_come = |(robot, request): &(RobotId, Request)| {
            let is_seen = self.observed.robots.get(robot).is_some_and(|seen| seen.last.is_some());
            is_seen
                && !self.observed.robot_is_silent(*robot, turn.now)
                && !self.state.stranded.contains(robot)
                && !self.state.helps.get(robot).is_some_and(Help::is_charging)
                && !holders.contains(robot)
                && !self.has_claimed(*robot, request)
        };
        let waiting: Vec<_> = waiting.into_iter().filter(can_come).collect();
        let situation = self.situation(turn, &waiting);
        let choices = self.chooser.choose(&situation);
        for (asker, mut choice) in situation.askers.iter().zip(choices) {
            self.keep_within_power(asker.robot, &mut choice, turn.now);
            self.follow(turn, &situation, asker, &choice);
        }
    }

    /// Does what was chosen for a robot.
    fn follow(&mut self, turn: &mut Turn, situation: &Situation, asker: &Asker, choice: &Choice) {
        let robot = asker.robot;
        let Some(request) = self.state.requests.get(&robot).copied() else { return };
        if choice.chosen.is_some() || !request.decided {
            let id = self.state.next_decision;
            let policy = self.policy.choose;
            let decision = Decision::new(id, turn.now, request.id, policy, situation, asker, choice);
            self.record(turn, Fact::Decided(decision));
        }
        let Some(pile) = choice.chosen else {
            let in_reach = |offer: &Offer| offer.candidate.distance.is_some_and(|way| way <= asker.reach);
            let works = |offer: &Offer| offer.candidate.availability != Some(Availability::Fault);
            if asker.offers.iter().any(|offer| in_reach(offer) && works(offer)) {
                self.call_help_off(turn, robot);
            } else {
                self.want_help(turn, robot, Plight::OutOfReach);
            }
            let reachable = asker.offers.iter().any(in_reach);
            let reason = if reachable { UnassignedReason::AllTaken } else { UnassignedReason::OutOfReach };
            let seen = self.observed.robots.get(&robot).and_then(|seen| seen.report);
            let works = seen.is_some_and(|report| report.activity == Activity::Working);
            // Who is called and works hears of it when there is a pile for it.
            if !(request.id.is_call() && works) {
                self.tell_to_wait(turn, robot, &request, reason);
            }
            return;
        };
        self.call_help_off(turn, robot);
        if self.availability_for(robot, pile, turn.now) == Some(Availability::Free) {
            self.grant(turn, pile, robot);
            return;
        }
        if choice.stage == Stage::Preempting
            && let Some(lease) = self.state.lease(pile).map(|lease| lease.name)
        {
            self.revoke(turn, pile, lease, RevokeReason::Preempted);
        }
        self.record(turn, Fact::NextReserved { pile, robot });
    }

    /// Tells each of `robots` that asked where to go, until it goes there, or that it must wait.
    pub(super) fn instruct_robots(&mut self, turn: &mut Turn, robots: &[RobotId]) {
        for &robot in robots {
            let Some(request) = self.state.requests.get(&robot).copied() else { continue };
            // A robot that was not heard since our start cannot hear us either; before its first report
            // nobody knows where it is now.
            let Some(seen) = self.observed.robots.get(&robot).filter(|seen| seen.last.is_some()) else {
                continue;
            };
            // One that started anew counts its requests anew: it would take the answer, and the old way, for
            // those to its next request.
            if !request.id.is_call() && seen.contact.boot() != Some(request.boot) {
                continue;
            }
            let accepted = seen.report.is_some_and(|report| report.accepted == Some(request.id));
            let waits = seen.report.is_some_and(|report| report.activity == Activity::Waiting);
            let (goal, sure) = match request.place {
                Place::Waiting => (None, false),
                Place::Next(pile) => (Some(pile), true),
                // While the pile has not answered, nobody sets off for it, and nobody who is on
                // the way because it was promised turns back.
                Place::Granted(pile) => {
                    let lease = self.state.lease(pile).filter(|lease| lease.is_wanted());
                    let held = lease.is_some_and(|lease| matches!(lease.phase, Phase::Held { .. }));
                    (lease.map(|_| pile), held)
                }
            };
            match goal {
                Some(pile) if accepted && request.assigned == Some(pile) => {}
                Some(pile) if sure && !accepted => self.assign(turn, robot, &request, pile),
                // Its pile will say so.
                None if self.has_claimed(robot, &request) => {}
                // Its pile has not answered yet: it is to know that it was heard.
                Some(_) if !accepted && waits => {
                    self.tell_to_wait(turn, robot, &request, UnassignedReason::AllTaken);
                }
                // It follows an assignment that does not hold any more.
                _ if accepted => self.tell_to_wait(turn, robot, &request, UnassignedReason::AllTaken),
                _ => {}
            }
        }
    }

    /// Whether a robot is on its way though nobody was sent: it has claimed a pile while it heard no
    /// coordinator.
    fn has_claimed(&self, robot: RobotId, request: &Request) -> bool {
        let report = self.observed.robots.get(&robot).and_then(|seen| seen.report);
        request.assigned.is_none() && report.is_some_and(|report| report.accepted == Some(request.id))
    }

    fn tell_to_wait(&mut self, turn: &mut Turn, robot: RobotId, request: &Request, reason: UnassignedReason) {
        // Should it be sent to the same pile again, it will have moved by then.
        self.observed.robots.entry(robot).or_default().route = None;
        if self.is_to_be_told(robot, Told::Wait, turn.now) {
            turn.send(
                DeviceId::Robot(robot),
                Message::Unassigned(Unassigned { request: request.id, reason }),
            );
        }
    }

    fn assign(&mut self, turn: &mut Turn, robot: RobotId, request: &Request, pile: PileId) {
        if !self.is_to_be_told(robot, Told::Go(pile), turn.now) {
            return;
        }
        let Some(route) = self.route(turn, robot, request, pile) else {
            self.give_up(turn, robot, pile);
            return;
        };
        if request.assigned != Some(pile) {
            self.record(turn, Fact::Assigned { robot, pile });
        }
        for Part { total, first, waypoints } in parts(&route.waypoints) {
            let assignment = Assignment { request: request.id, pile, total, first, waypoints };
            turn.send(DeviceId::Robot(robot), Message::Assignment(assignment));
        }
    }

    /// Takes a pile back from a robot that no way leads there any more: it has moved since, or is lost.
    fn give_up(&mut self, turn: &mut Turn, robot: RobotId, pile: PileId) {
        if self.state.next(pile) == Some(robot) {
            self.record(turn, Fact::NextReleased { pile, robot });
        } else if let Some(lease) = self.state.lease(pile).map(|lease| lease.name)
            // Its robot has found a way to a pile that it claimed itself.
            && !lease.lease.is_local()
        {
            self.revoke(turn, pile, lease, RevokeReason::NoWay);
        }
        self.observed.queue_is_due = true;
    }

    fn is_to_be_told(&mut self, robot: RobotId, what: Told, now: SiteMillis) -> bool {
        let seen = self.observed.robots.entry(robot).or_default();
        let told =
            seen.told.is_some_and(|(told, at)| told == what && now.since(at) < limits::REPEAT_INTERVAL);
        if !told {
            seen.told = Some((what, now));
        }
        !told
    }

    /// The route of an assignment: planned once, so that its repeated parts fit together.
    fn route(&mut self, turn: &mut Turn, robot: RobotId, request: &Request, pile: PileId) -> Option<Route> {
        let seen = self.observed.robots.entry(robot).or_default();
        let known = seen.route.as_ref().filter(|route| (route.request, route.pile) == (request.id, pile));
        if let Some(route) = known {
            return Some(route.clone());
        }
        let (position, _) = seen.last?;
        let cells = self.site.cell_of(position).and_then(|from| self.routes.route(from, pile));
        let Some(cells) = cells else {
            turn.warn(format!("robot {robot} has no way to pile {pile} from where it is now"));
            return None;
        };
        let waypoints = cells.iter().map(|cell| self.site.position(*cell)).collect();
        let route = Route { request: request.id, pile, cells, waypoints };
        self.observed.robots.entry(robot).or_default().route = Some(route.clone());
        Some(route)
    }
}
