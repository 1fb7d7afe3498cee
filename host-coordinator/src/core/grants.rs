//! Leases: granted, extended, taken back, ended.
//!
//! ```text
//!                  Ack                    pile ended it, or does not know it
//!  grant -> Offered ----------> Held -------------------------------------------> gone
//!              |  \ Nack          | robot abandoned, robot stranded                 ^
//!   no answer  |   `--> Refused --|---- grant can not arrive any more --------------|
//!              `----------------> Revoking ---- Ack, or ran out --------------------'
//! ```
//! There are never two holders: a pile's record has room for one lease, and a lease leaves it only
//! when the pile cannot believe in it any more, because the pile said so or because the site's
//! clock is past the lease's end by more than a pile's clock can be wrong.

use protocol::{
    Availability, CommandHead, CommandId, DeviceId, DurationMs, EnergyJ, Grant, LeaseId, LeaseRef, Message,
    NackReason, PileId, PileState, Revoke, RobotId, SiteMillis, limits,
};

use super::{
    coordinator::Coordinator,
    event::{Command, Contradiction, Fact, LeaseEnd, RevokeReason},
    state::{Lease, Phase, Place},
    turn::Turn,
};

/// A command is refused by a pile that gets it later than this after it was given.
pub const COMMAND_LIFE: DurationMs = limits::SILENCE;
/// How far a pile's clock may be behind the site's: it takes no time older than two seconds, and
/// the rest is drift.
pub const CLOCK_MARGIN: DurationMs = DurationMs(5_000);

impl Coordinator {
    /// A pile's report on itself, which is the truth about its lease.
    pub(super) fn hear_report(&mut self, turn: &mut Turn, pile: PileId, report: PileState) {
        let seen = self.observed.piles.entry(pile).or_default();
        let before = seen.report.replace(report).map(|before| before.row.availability);
        if before != Some(report.row.availability) {
            seen.since = turn.now;
            self.observed.queue_is_due = true;
        }
        for named in [report.holder, report.ended.map(|ended| ended.lease)].into_iter().flatten() {
            self.outdo(turn, named);
        }
        match self.state.lease(pile).copied() {
            Some(lease) => self.compare(turn, pile, &lease, &report),
            None => {
                if let Some(holder) = report.holder {
                    self.take_over(turn, pile, holder, report.row.availability);
                }
            }
        }
    }

    /// What a pile's report means for the lease that is recorded for it.
    fn compare(&mut self, turn: &mut Turn, pile: PileId, lease: &Lease, report: &PileState) {
        let id = lease.name.lease;
        if let Some(ended) = report.ended.filter(|ended| lease.is_called(ended.lease)) {
            self.end(turn, pile, lease, LeaseEnd::ByPile(ended.reason), ended.charged);
        } else if report.holder.is_some_and(|holder| lease.is_called(holder)) {
            match lease.phase {
                // Its answer was lost.
                Phase::Offered => self.record(turn, Fact::Accepted { pile, lease: id }),
                // A copy of the refused grant came late.
                Phase::Refused => self.revoke(turn, pile, lease.name, RevokeReason::Unanswered),
                Phase::Held { .. } | Phase::Revoking { .. } => {}
            }
        } else if matches!(lease.phase, Phase::Held { .. })
            && lease.command.is_none()
            && lease.name.epoch == self.state.epoch
        {
            self.end(turn, pile, lease, LeaseEnd::Lost, DurationMs(0));
        }
        // A lease of an earlier epoch may be held though the report does not know it: after a
        // restart it is not known whether the report was sent before the pile accepted the lease.
        // The pile's answer to the extension that is due tells.
    }

    /// A pile holds to a lease that is not recorded: the log was lost, or the lease ran out here
    /// while the pile was silent and charged on, or the pile made it for itself while it heard nobody. A
    /// charge goes on, and so does the reservation of a robot that has claimed the pile; any other is taken back.
    fn take_over(&mut self, turn: &mut Turn, pile: PileId, lease: LeaseRef, availability: Availability) {
        let robot = lease.robot;
        let charges = availability == Availability::Charging;
        let claimed = lease.lease.is_local();
        let place = self.state.requests.get(&robot).map_or(Place::Waiting, |request| request.place);
        let goes_on = self.robots.contains_key(&robot)
            && match place {
                Place::Waiting => charges || claimed,
                Place::Next(other) | Place::Granted(other) if other == pile => charges || claimed,
                // The promise was made while the robot was not heard.
                Place::Next(_) => claimed,
                Place::Granted(_) => claimed && charges,
            };
        if !goes_on {
            self.revoke(turn, pile, lease, RevokeReason::Unknown);
            return;
        }
        match place {
            Place::Next(other) if other != pile => {
                self.record(turn, Fact::NextReleased { pile: other, robot })
            }
            Place::Granted(other) if other != pile => {
                if let Some(of) = self.state.lease(other).map(|lease| lease.name) {
                    self.revoke(turn, other, of, RevokeReason::Elsewhere);
                }
            }
            _ => {}
        }
        self.record(turn, Fact::Adopted { pile, lease });
        // Whoever was promised the pile is better off elsewhere, or comes next again.
        if claimed && let Some(robot) = self.state.next(pile) {
            self.record(turn, Fact::NextReleased { pile, robot });
        }
        self.observed.queue_is_due = true;
    }

    /// A pile has obeyed a command.
    pub(super) fn hear_ack(&mut self, turn: &mut Turn, pile: PileId, command: CommandId) {
        let Some(lease) = self.awaiting(pile, command) else { return };
        match lease.phase {
            Phase::Offered | Phase::Held { .. } => {
                self.record(turn, Fact::Accepted { pile, lease: lease.name.lease });
            }
            Phase::Revoking { .. } => self.end(turn, pile, &lease, LeaseEnd::Revoked, DurationMs(0)),
            Phase::Refused => {}
        }
    }

    /// A pile has not obeyed a command.
    pub(super) fn hear_nack(
        &mut self,
        turn: &mut Turn,
        pile: PileId,
        command: CommandId,
        reason: NackReason,
    ) {
        let Some(lease) = self.awaiting(pile, command) else { return };
        let id = lease.name.lease;
        match (reason, lease.phase) {
            (NackReason::StaleEpoch { highest }, _) => self.start_epoch(turn, highest, LeaseId(0)),
            (NackReason::ClockUnknown | NackReason::TooLate, _) => {
                self.record(turn, Fact::Deferred { pile, lease: id, reason });
            }
            (NackReason::Ended, _) => {
                self.end(turn, pile, &lease, LeaseEnd::Lost, DurationMs(0));
            }
            // The others say that the pile, as it is now, cannot be used.
            (_, Phase::Offered) => {
                self.record(turn, Fact::Refused { pile, lease: id, reason });
                self.observed.queue_is_due = true;
            }
            (_, Phase::Held { .. }) => self.end(turn, pile, &lease, LeaseEnd::Lost, DurationMs(0)),
            (_, Phase::Refused | Phase::Revoking { .. }) => {
                self.record(turn, Fact::Deferred { pile, lease: id, reason });
            }
        }
    }

    fn awaiting(&self, pile: PileId, command: CommandId) -> Option<Lease> {
        let awaits = |lease: &&Lease| lease.command.is_some_and(|pending| pending.id == command);
        self.state.lease(pile).filter(awaits).copied()
    }

    /// Gives a free pile to a robot.
    pub(super) fn grant(&mut self, turn: &mut Turn, pile: PileId, robot: RobotId) {
        let lease = LeaseRef { epoch: self.state.epoch, lease: self.state.next_lease, robot };
        let energy = self.lacking(robot);
        let (command, expiry) = (self.command(turn.now), turn.now.after(self.policy.lease));
        self.record(turn, Fact::Granted { pile, lease, energy, command, expiry });
        self.send_command(turn, pile);
    }

    /// What a robot's battery lacks (LMPP eq. 2, g_full - g_real).
    fn lacking(&self, robot: RobotId) -> EnergyJ {
        let full = self.robots.get(&robot).map_or(EnergyJ::MIN, |robot| robot.full);
        let seen = self.observed.robots.get(&robot).and_then(|seen| seen.last);
        let asked = self.state.requests.get(&robot).map(|request| request.energy);
        let energy = seen.map(|(_, energy)| energy).or(asked).unwrap_or_default();
        EnergyJ::clamped(full.get() - energy.get())
    }

    fn command(&self, now: SiteMillis) -> Command {
        let life = COMMAND_LIFE.min(self.policy.lease);
        Command { id: self.state.next_command, valid_until: now.after(life) }
    }

    /// Does what is due for the leases and promises of `piles`.
    pub(super) fn tend_leases(&mut self, turn: &mut Turn, piles: &[PileId]) {
        for &pile in piles {
            if let Some(lease) = self.state.lease(pile).copied() {
                self.tend(turn, pile, &lease);
            }
            if self.state.lease(pile).is_none() {
                self.keep_promise(turn, pile);
            }
        }
    }

    fn tend(&mut self, turn: &mut Turn, pile: PileId, lease: &Lease) {
        let now = turn.now;
        let held = matches!(lease.phase, Phase::Held { .. });
        if is_past(lease, now) && (!held || self.observed.pile_is_silent(pile, now)) {
            self.end(turn, pile, lease, LeaseEnd::RanOut, DurationMs(0));
            return;
        }
        let in_time = lease.command.is_some_and(|command| now <= command.valid_until);
        let asked_since = lease.granted_at.max(self.observed.started);
        let unanswered = lease.phase == Phase::Offered && now.since(asked_since) > COMMAND_LIFE;
        if unanswered && !in_time {
            self.revoke(turn, pile, lease.name, RevokeReason::Unanswered);
        } else if let Some(why) = self.reason_to_revoke(pile, lease, now) {
            self.revoke(turn, pile, lease.name, why);
        } else if in_time {
            self.repeat_command(turn, pile);
        } else if let Phase::Revoking { why } = lease.phase {
            self.renew(turn, pile, |coordinator, turn| coordinator.revoke(turn, pile, lease.name, why));
        } else if self.is_to_be_extended(pile, lease, now) {
            self.renew(turn, pile, |coordinator, turn| coordinator.extend(turn, pile, lease));
        }
    }

    fn reason_to_revoke(&self, pile: PileId, lease: &Lease, now: SiteMillis) -> Option<RevokeReason> {
        let robot = lease.name.robot;
        let contradicted = self.contradicted(pile);
        if !lease.is_wanted() {
            None
        } else if contradicted == Some((Contradiction::NoCurrent, Some(robot))) {
            Some(RevokeReason::NoCurrent)
        } else if self.is_charging(pile, lease) {
            None
        } else if matches!(contradicted, Some((Contradiction::Unleased, other)) if other != Some(robot)) {
            Some(RevokeReason::Occupied)
        } else if self.state.stranded.contains(&robot) {
            Some(RevokeReason::Stranded)
        } else if self.is_back_at_work(robot) || self.ignores_its_assignment(robot, now) {
            Some(RevokeReason::Abandoned)
        } else {
            None
        }
    }

    /// Whether the pile charges the lease's robot now.
    pub(super) fn is_charging(&self, pile: PileId, lease: &Lease) -> bool {
        let report = self.observed.piles.get(&pile).and_then(|seen| seen.report);
        report.is_some_and(|report| {
            report.row.availability == Availability::Charging
                && report.holder.is_some_and(|holder| lease.is_called(holder))
        })
    }

    /// A lease is extended when half of it has passed, or when it is of an earlier epoch; not to a
    /// robot that is lost, and not by shouting at a pile that does not answer.
    fn is_to_be_extended(&self, pile: PileId, lease: &Lease, now: SiteMillis) -> bool {
        let due = match lease.phase {
            Phase::Offered => true,
            Phase::Held { until } => {
                lease.name.epoch < self.state.epoch || until.since(now).0 < self.policy.lease.0 / 2
            }
            Phase::Refused | Phase::Revoking { .. } => false,
        };
        let lost = self.observed.robot_is_lost(lease.name.robot, now) && !self.is_charging(pile, lease);
        due && !lost && self.robots.contains_key(&lease.name.robot)
    }

    fn extend(&mut self, turn: &mut Turn, pile: PileId, lease: &Lease) {
        let name = LeaseRef { epoch: self.state.epoch, ..lease.name };
        let (command, expiry) = (self.command(turn.now), turn.now.after(self.policy.lease));
        self.record(turn, Fact::Extended { pile, lease: name, command, expiry });
        self.send_command(turn, pile);
    }

    pub(super) fn revoke(&mut self, turn: &mut Turn, pile: PileId, lease: LeaseRef, why: RevokeReason) {
        let lease = LeaseRef { epoch: self.state.epoch, ..lease };
        let command = self.command(turn.now);
        self.record(turn, Fact::Revoked { pile, lease, command, why });
        self.send_command(turn, pile);
        self.observed.queue_is_due = true;
        // It may have been held beyond its time, while its pile was heard.
        if let Some(lease) = self.state.lease(pile).copied().filter(|lease| is_past(lease, turn.now)) {
            self.end(turn, pile, &lease, LeaseEnd::RanOut, DurationMs(0));
        }
    }

    fn end(&mut self, turn: &mut Turn, pile: PileId, lease: &Lease, why: LeaseEnd, charged: DurationMs) {
        let LeaseRef { lease: id, robot, .. } = lease.name;
        if why == LeaseEnd::RanOut {
            // What the pile said before it fell silent tells nothing of what it does now.
            self.observed.piles.entry(pile).or_default().report = None;
        }
        self.record(turn, Fact::Ended { pile, lease: id, robot, why, charged });
        self.observed.queue_is_due = true;
    }

    /// Gives a command anew, but no more often than it would be repeated, and only to a pile that
    /// is there to hear it.
    fn renew(&mut self, turn: &mut Turn, pile: PileId, command: impl FnOnce(&mut Self, &mut Turn)) {
        if self.may_command(pile, turn.now) && self.observed.report(pile, turn.now).is_some() {
            command(self, turn);
        }
    }

    fn repeat_command(&mut self, turn: &mut Turn, pile: PileId) {
        if self.may_command(pile, turn.now) {
            self.send_command(turn, pile);
        }
    }

    fn may_command(&self, pile: PileId, now: SiteMillis) -> bool {
        let last = self.observed.piles.get(&pile).and_then(|seen| seen.commanded_at);
        last.is_none_or(|last| now.since(last) >= limits::REPEAT_INTERVAL)
    }

    /// Sends the command that waits for an answer.
    fn send_command(&mut self, turn: &mut Turn, pile: PileId) {
        let Some(lease) = self.state.lease(pile) else { return };
        let Some(command) = lease.command else { return };
        let head = CommandHead { id: command.id, valid_until: command.valid_until };
        let message = match (lease.phase, self.robots.get(&lease.name.robot)) {
            (Phase::Revoking { .. }, _) => Message::Revoke(Revoke { head, lease: lease.name }),
            (_, Some(robot)) => Message::Grant(Grant {
                head,
                lease: lease.name,
                tag: robot.tag,
                expiry: lease.expiry,
                energy: lease.energy,
            }),
            // The robot has left the fleet: its lease runs out.
            (_, None) => return,
        };
        turn.send(DeviceId::Pile(pile), message);
        self.observed.piles.entry(pile).or_default().commanded_at = Some(turn.now);
    }

    /// Gives a pile to the robot it is promised to, when it is free.
    fn keep_promise(&mut self, turn: &mut Turn, pile: PileId) {
        let Some(robot) = self.state.next(pile) else { return };
        let availability = self.observed.report(pile, turn.now).map(|report| report.row.availability);
        let lost = self.state.stranded.contains(&robot) || self.observed.robot_is_lost(robot, turn.now);
        match availability {
            Some(Availability::Free) if !lost => self.grant(turn, pile, robot),
            Some(Availability::Done) if !lost && self.stands_at(robot, pile, turn.now) => {
                self.grant(turn, pile, robot);
            }
            Some(Availability::Charging | Availability::Reserved) if !lost => {}
            // It may be this robot that stands there, and has not said so yet.
            Some(Availability::Done)
                if !lost
                    && (!self.is_blocked(pile, turn.now)
                        || self.observed.robot_is_silent(robot, turn.now)) => {}
            // Its robot may stand there already, with too little left for any other pile.
            None if !lost && !self.observed.pile_is_lost(pile, turn.now) => {}
            _ => {
                self.record(turn, Fact::NextReleased { pile, robot });
                self.observed.queue_is_due = true;
            }
        }
    }

    /// Whether a charged robot does not leave a pile.
    fn is_blocked(&self, pile: PileId, now: SiteMillis) -> bool {
        self.observed.piles.get(&pile).is_some_and(|seen| now.since(seen.since) > super::ROBOT_PATIENCE)
    }
}

/// Whether no pile that knows the time believes in a lease any more, unless it charges under it.
fn is_past(lease: &Lease, now: SiteMillis) -> bool {
    now > lease.expiry.after(CLOCK_MARGIN)
}
