//! The pile's core: which input concerns which room, and what is said to others.
//!
//! A step has four parts: time passes, the input is taken in, the lease is settled and the power
//! commanded, and messages that are due go out. A step's work and memory are bounded.

use firmware_common::{
    clock::SiteClock,
    passes::{PassCounter, period_of},
    presence::Presence,
    reader::TagRead,
};
use protocol::{
    Ack, Availability, ClearFault, CommandId, CurrentA, DeviceId, DurationMs, EndReason, EnergyJ, FaultCode,
    FrameError, Message, Millis, Nack, NackReason, PileRow, PileState, Provision, Reference, SiteMillis,
    TagId,
};

use crate::{
    charge::{self, Charge},
    claims::Claims,
    faults::{FaultSet, Faults},
    gossip::Gossip,
    io::{Input, Messages, Outgoing, Outputs, Records, To},
    lease::{Answer, Circumstances, Lease, Leases, Place},
    parameters::Parameters,
    provisioning::Provisioning,
    reports::Reports,
    safety::{Power, Safety, conditions},
    store::{Counters, Journal},
    table::PileTable,
    unsaved::{Lasting, Unsaved},
    voice::Voice,
};

mod claiming;
mod service;

use service::Telling;

/// The fault of a store that fails.
const STORE: FaultSet = FaultSet::of(&[FaultCode::StoreFailed]);

/// Tags that can stand at the contacts at a time.
const MAX_DOCKED: usize = 4;

/// A charging pile.
#[derive(Clone, Debug)]
pub struct ChargingPile {
    parameters: Parameters,
    now: Millis,
    clock: SiteClock,
    leases: Leases,
    presence: Presence<MAX_DOCKED>,
    /// Whose charge began last, until it has gone.
    served: Option<TagId>,
    faults: Faults,
    safety: Safety,
    passes: PassCounter,
    reports: Reports,
    table: PileTable,
    gossip: Gossip,
    voice: Voice,
    counters: Counters,
    unsaved: Unsaved,
    provisioning: Provisioning,
    /// The last fault that was cleared by command: who commanded it, and what was answered.
    cleared: Option<(DeviceId, CommandId, Answer)>,
    /// Whether the last word before the mains are gone was said.
    farewell: bool,
    telling: Telling,
    claims: Claims,
}

impl ChargingPile {
    /// A pile that has just started: contacts dead, no lease, no clock.
    #[must_use]
    pub fn new(parameters: Parameters) -> Self {
        Self::resume(parameters, Journal::default())
    }

    /// The same, with reports that nobody has acknowledged before this start.
    #[must_use]
    pub fn resume(parameters: Parameters, journal: Journal) -> Self {
        let Parameters { highest_epoch: epoch, latched, counters, .. } = parameters;
        let row = PileRow {
            pile: parameters.pile,
            boot: parameters.boot,
            version: 0,
            stamp: None,
            availability: Availability::Free,
            remaining: protocol::Fraction::MIN,
            planned: DurationMs(0),
        };
        Self {
            parameters,
            now: Millis(0),
            clock: SiteClock::new(),
            leases: Leases::new(parameters.highest_epoch),
            presence: Presence::new(parameters.docked, parameters.tag_timeout),
            served: None,
            faults: Faults::new(parameters.latched),
            safety: Safety::new(parameters.limits, parameters.power_w),
            passes: PassCounter::new(parameters.pass_rule),
            reports: Reports::new(parameters.boot, journal),
            table: PileTable::new(),
            gossip: Gossip::new(),
            voice: Voice::new(PileState {
                row,
                elapsed: DurationMs(0),
                holder: None,
                energised: false,
                ended: None,
                standing: None,
                current: None,
            }),
            counters,
            unsaved: Unsaved::new(Lasting { epoch, latched, counters }),
            provisioning: Provisioning::new(parameters.identity),
            cleared: None,
            farewell: false,
            telling: Telling::Nothing,
            claims: Claims::new(),
        }
    }

    /// Takes one input at `now` on the pile's own clock. Should `now` lie before an earlier step's,
    /// no time has passed.
    pub fn step(&mut self, now: Millis, input: Input<'_>) -> Outputs {
        // Filled where the caller gets it: it is large, and mostly empty.
        let mut outputs = Outputs::default();
        self.pass_time(now);
        self.take(input, &mut outputs.messages);
        self.settle();
        self.records(&mut outputs.store);
        if self.faults.active().contains(FaultCode::MainsLost) {
            outputs.urgent = self.say_farewell(&mut outputs.messages);
        } else {
            self.farewell = false;
            self.speak(&mut outputs.messages);
        }
        self.tell_table(&mut outputs.messages);
        if self.unsaved.has_failed() {
            // An answer may rest on what is not stored.
            let is_answer = |message: &Message| matches!(message, Message::Ack(_) | Message::Nack(_));
            outputs.messages.retain(|outgoing| !is_answer(&outgoing.message));
        }
        outputs.power = self.safety.power();
        outputs.restart = self.provisioning.restart_is_due(self.now) && !self.energised();
        outputs
    }

    /// What the pile does with its place.
    #[must_use]
    pub fn availability(&self) -> Availability {
        match self.leases.current() {
            _ if !self.faults.standing().is_empty() => Availability::Fault,
            Some(lease) if lease.charge.is_some() => Availability::Charging,
            Some(_) => Availability::Reserved,
            None if self.standing().is_some() => Availability::Done,
            None => Availability::Free,
        }
    }

    /// The pile's row of the table as it was last told.
    #[must_use]
    pub const fn row(&self) -> PileRow {
        self.voice.told().row
    }

    /// Whether the contactor is told to be closed.
    #[must_use]
    pub fn energised(&self) -> bool {
        self.safety.power().is_closed()
    }

    /// The command to contactor and power stage.
    #[must_use]
    pub const fn power(&self) -> Power {
        self.safety.power()
    }

    /// What is wrong with the pile.
    #[must_use]
    pub const fn faults(&self) -> &Faults {
        &self.faults
    }

    /// The leases.
    #[must_use]
    pub const fn leases(&self) -> &Leases {
        &self.leases
    }

    /// The site's time as of the last step, once the pile knows it.
    #[must_use]
    pub fn site_now(&self) -> Option<SiteMillis> {
        self.clock.site_now(self.now)
    }

    /// What the other piles said of themselves.
    #[must_use]
    pub const fn table(&self) -> &PileTable {
        &self.table
    }

    /// The pass counts that wait for their report.
    #[must_use]
    pub const fn passes(&self) -> &PassCounter {
        &self.passes
    }

    fn pass_time(&mut self, now: Millis) {
        let passed = now.since(self.now);
        self.now = self.now.max(now);
        if self.energised()
            && let Some(charge) = self.leases.charge_mut()
        {
            charge.advance(passed);
        }
    }

    fn take(&mut self, input: Input<'_>, messages: &mut Messages) {
        match input {
            Input::Tick => {}
            Input::Tag(TagRead { tag, rssi_dbm }) => {
                self.faults.reader_answered(self.now);
                self.presence.read(self.now, tag, rssi_dbm);
                self.passes.read(self.now, self.period(), tag, rssi_dbm);
            }
            Input::ReaderIdle => self.faults.reader_answered(self.now),
            Input::Sensors(sensors) => {
                let given_j = self.safety.sense(self.now, sensors, &mut self.faults);
                if let Some(charge) = self.leases.charge_mut() {
                    charge.deliver(given_j);
                }
            }
            // It does not know of our start.
            Input::Discarded(FrameError::Unauthentic { sender: DeviceId::Coordinator }) => {
                if self.voice.distrusted(self.now) {
                    self.say_hello(messages);
                }
            }
            Input::Discarded(
                FrameError::Unauthentic { sender: DeviceId::Service }
                | FrameError::Unsealed { sender: DeviceId::Service },
            ) => self.answer_tool(messages),
            Input::Discarded(_) => {}
            Input::StoreFailed => {
                self.unsaved.failed(self.now);
                self.reports.store_failed();
                self.provisioning.store_failed();
            }
            Input::Button { held } => self.provisioning.button(held),
            Input::Frame(frame) => match frame.header.sender {
                DeviceId::Coordinator => self.hear_coordinator(&frame.message, messages),
                DeviceId::Pile(_) => {
                    if let Message::PileTable(table) = &frame.message {
                        self.hear_table(table);
                    }
                }
                DeviceId::Service => self.hear_service(&frame.message, messages),
                DeviceId::Robot(robot) => {
                    if let Message::ClaimPile(claim) = &frame.message
                        && claim.pile == self.parameters.pile
                    {
                        self.hear_claim(robot, claim, messages);
                    }
                }
                DeviceId::Chassis(_) | DeviceId::Factory => {}
            },
        }
    }

    fn hear_coordinator(&mut self, message: &Message, messages: &mut Messages) {
        self.leases.coordinator_heard(self.now, self.clock.site_now(self.now));
        self.claims.coordinator_heard(self.now);
        match message {
            Message::Hello(hello) => {
                self.leases.see_epoch(hello.epoch);
                self.clock.ask_again();
                if self.voice.greeted(self.now) {
                    self.say_hello(messages);
                }
            }
            Message::Grant(grant) => {
                let (planned, place) = (self.planned(grant.energy), self.place(grant.tag));
                let answer = self.leases.grant(grant, planned, place);
                say(messages, To::Coordinator, answered(Reference::Command(grant.head.id), answer));
            }
            Message::Revoke(revoke) => {
                let answer = self.leases.revoke(revoke, self.clock.site_now(self.now));
                say(messages, To::Coordinator, answered(Reference::Command(revoke.head.id), answer));
            }
            Message::ClearFault(command) => self.clear_fault(DeviceId::Coordinator, *command, messages),
            Message::TimeSync(sync) => self.clock.accept(self.now, sync),
            Message::ClaimRule(rule) => self.claims.allow(rule.allowed),
            Message::Ack(Ack { of: Reference::Report(report) }) => self.reports.acknowledged(*report),
            Message::PileTable(table) => self.hear_table(table),
            _ => {}
        }
    }

    /// How long a charge of so much energy takes (LMPP eq. 2).
    fn planned(&self, energy: EnergyJ) -> DurationMs {
        let Parameters { power_w, eta, .. } = self.parameters;
        charge::planned_time([energy], power_w, eta)
    }

    fn place(&self, tag: TagId) -> Place {
        Place {
            site_now: self.clock.site_now(self.now),
            faulted: !self.faults.standing().is_empty() || self.provisioning.is_over(),
            occupied: self.is_taken_from(tag),
        }
    }

    /// Clears a latched fault whose cause is gone. Both who may command it number their commands.
    fn clear_fault(&mut self, by: DeviceId, command: ClearFault, messages: &mut Messages) {
        let answer = match self.cleared {
            Some((of, id, answer)) if (of, id) == (by, command.command) => answer,
            _ if self.faults.clear(command.code) => Ok(()),
            _ => Err(NackReason::NotCleared),
        };
        self.cleared = Some((by, command.command, answer));
        let to = if by == DeviceId::Service { To::Service } else { To::Coordinator };
        say(messages, to, answered(Reference::Command(command.command), answer));
    }

    /// Who uses the pile goes on doing so.
    fn provision(&mut self, provision: &Provision, messages: &mut Messages) {
        let answer = match self.leases.current() {
            Some(lease) => Err(NackReason::Held { by: lease.name }),
            None => self.provisioning.provision(self.now, provision),
        };
        say(messages, To::Provisioner, answered(Reference::Command(provision.command), answer));
    }

    /// Who stands here, or has not yet gone, without a lease.
    fn standing(&self) -> Option<TagId> {
        let holder = self.leases.current().map(|lease| lease.tag);
        self.presence.tags(self.now).chain(self.served).find(|standing| Some(*standing) != holder)
    }

    /// Whether a robot stands here, or has not yet gone, that is not the one with `tag`.
    fn is_taken_from(&self, tag: TagId) -> bool {
        self.presence.tags(self.now).chain(self.served).any(|standing| standing != tag)
    }

    /// Rows about this pile are its own to write.
    fn hear_table(&mut self, table: &protocol::PileTable) {
        for row in table.rows.iter().filter(|row| row.pile != self.parameters.pile) {
            self.table.merge_row(*row);
        }
    }

    /// Ends what is over, begins what can begin, and commands the power.
    fn settle(&mut self) {
        let failed = if self.unsaved.has_failed() { STORE } else { FaultSet::EMPTY };
        self.faults.look(self.now, STORE, failed);
        if self.served.is_some_and(|tag| self.has_left(tag)) {
            self.served = None;
        }
        if let Some(reason) = self.end_of_lease() {
            self.leases.end(reason);
        }
        if let Some((lease, began)) = self.arrived() {
            self.leases.begin_charge();
            self.served = Some(lease.tag);
            self.reports.begin_charge(lease.name, lease.tag, began);
        }
        // Nothing may have been planned.
        if self.leases.charge_mut().is_some_and(|charge| charge.is_complete()) {
            self.leases.end(EndReason::Completed);
        }
        self.account();
        if !self.energised() {
            self.reports.take_passes(self.now, self.period(), &mut self.passes);
        }

        let lease = self.leases.current();
        let permit =
            conditions::permit(self.now, &self.clock, lease, &self.presence, &self.faults, &self.safety);
        self.safety.command(self.now, permit);
    }

    /// Keeps the report of the charge under way, and ends it with the charge.
    fn account(&mut self) {
        match (self.leases.current().and_then(|lease| lease.charge), self.leases.ended()) {
            (Some(charge), _) => self.reports.deliver(charge.delivered()),
            (None, Some(ended)) => {
                let site_now = self.clock.site_now(self.now);
                if self.reports.end_charge(ended.reason, ended.charged, site_now) {
                    self.counters.count(ended.charged);
                }
            }
            (None, None) => {}
        }
    }

    /// The lease whose robot has arrived on the contacts, and when, if its charge has not begun. While
    /// another stands here too, nobody knows which of them touches them. What cannot be accounted for
    /// does not begin.
    fn arrived(&self) -> Option<(Lease, SiteMillis)> {
        let lease = self.leases.current().filter(|lease| lease.charge.is_none())?;
        let alone = self.presence.contains(self.now, lease.tag) && !self.is_taken_from(lease.tag);
        let mated = self.safety.sample(self.now).is_some_and(|sample| sample.sensors.mated);
        let began = self.clock.site_now(self.now)?;
        (alone && mated && self.reports.has_place()).then_some((*lease, began))
    }

    fn end_of_lease(&self) -> Option<EndReason> {
        let seen = Circumstances {
            faulted: !self.faults.standing().is_empty(),
            robot_left: self.leases.current().is_some_and(|lease| self.has_left(lease.tag)),
        };
        self.leases.over(self.now, self.clock.site_now(self.now), seen)
    }

    /// Whether `tag` is gone and not just unseen by a reader that has fallen silent.
    fn has_left(&self, tag: TagId) -> bool {
        !self.presence.contains(self.now, tag)
            && self.faults.reader_answered_within(self.now, self.parameters.tag_timeout)
    }

    fn speak(&mut self, messages: &mut Messages) {
        if self.voice.hello_is_due(self.now) {
            self.say_hello(messages);
        }
        let site_now = self.clock.site_now(self.now);
        let overdue = self.leases.current().zip(site_now).is_some_and(|(lease, now)| now >= lease.expiry);
        if let Some(request) = self.clock.request(self.now, overdue) {
            say(messages, To::Coordinator, Message::TimeRequest(request));
        }
        let told = self.voice.tell(self.now, site_now, self.state());
        if let Some(told) = told {
            say(messages, To::Coordinator, Message::PileState(told.state));
        }
        if let Some(report) = self.reports.due(self.now, &mut self.faults) {
            say(messages, To::Coordinator, report);
        }
        let changed = told.is_some_and(|told| told.changed);
        if let Some(part) = self.gossip.part(self.now, changed, self.row(), &self.table) {
            say(messages, To::Peers, Message::PileTable(part));
        }
    }

    /// The mains are lost and there is power for one more frame: what is wrong. Then nothing is said
    /// until they are back, but to a tool that asks: at a desk there may be no mains. Answers whether
    /// it was said now.
    fn say_farewell(&mut self, messages: &mut Messages) -> bool {
        messages.retain(|outgoing| outgoing.to == To::Service);
        let is_first = !core::mem::replace(&mut self.farewell, true);
        if is_first {
            say(messages, To::Coordinator, Message::PileFaults(self.faults.told()));
        }
        is_first
    }

    /// What has changed of that which must outlive a restart.
    fn records(&mut self, records: &mut Records) {
        let lasting = Lasting {
            epoch: self.leases.highest_epoch(),
            latched: self.faults.latched(),
            counters: self.counters,
        };
        self.unsaved.take(self.now, lasting, &mut self.provisioning, &mut self.reports, records);
    }

    fn answer_tool(&mut self, messages: &mut Messages) {
        if let Some(hello) = self.voice.answer_tool(self.now, self.leases.highest_epoch()) {
            say(messages, To::Service, Message::Hello(hello));
        }
    }

    fn say_hello(&mut self, messages: &mut Messages) {
        let hello = self.voice.hello(self.now, self.leases.highest_epoch());
        say(messages, To::Coordinator, Message::Hello(hello));
    }

    /// The state as it is, with the version and stamp of the row that was told last.
    fn state(&self) -> PileState {
        let lease = self.leases.current();
        let charge = lease.and_then(|lease| lease.charge).unwrap_or(Charge::new(DurationMs(0)));
        PileState {
            row: PileRow {
                availability: self.availability(),
                remaining: charge.remaining(),
                planned: charge.planned(),
                ..self.row()
            },
            elapsed: charge.elapsed(),
            holder: lease.map(|lease| lease.name),
            energised: self.energised(),
            ended: self.leases.ended(),
            standing: self.standing(),
            current: self
                .safety
                .sample(self.now)
                .and_then(|sample| sample.readings.current_a)
                .map(CurrentA::clamped),
        }
    }

    fn period(&self) -> Option<u16> {
        let site_now = self.clock.site_now(self.now)?;
        Some(period_of(site_now, self.parameters.period, self.parameters.periods))
    }
}

fn answered(of: Reference, answer: Answer) -> Message {
    match answer {
        Ok(()) => Message::Ack(Ack { of }),
        Err(reason) => Message::Nack(Nack { of, reason }),
    }
}

fn say(messages: &mut Messages, to: To, message: Message) {
    // It fits: a step sends each kind of message at most once, and they are fewer than the room.
    let _ = messages.push(Outgoing { to, message });
}
