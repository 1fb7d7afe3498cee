//! The pile's core: which input concerns which room, and what is said to others.
//!
//! A step has four parts: time passes, the input is taken in, the lease is settled and the
//! contactor commanded, and messages that are due go out. A step's work and memory are bounded.

use heapless::Vec;
use protocol::{
    Ack, Availability, BootEpoch, DeviceId, DurationMs, EndReason, Epoch, Frame, Hello, Message, Millis,
    Nack, PileId, PileRow, PileState, Reference, TagId, limits, version,
};

use crate::{
    charge::{self, Charge},
    clock::SiteClock,
    faults::Faults,
    lease::{Answer, Leases, Place},
    passes::{PassCounter, PassRule, period_of},
    presence::{Presence, RssiBand},
    reports::Reports,
    safety,
    table::{Gossip, PileTable},
};

/// The most messages a step sends: one of each kind.
pub const MESSAGES_PER_STEP: usize = 8;
/// Tags that can stand at the contacts at a time.
const MAX_DOCKED: usize = 4;
/// The charge state is told at the latest when it has changed by this share.
const REMAINING_STEP: f32 = 0.01;

/// What differs from pile to pile.
#[derive(Clone, Copy, Debug)]
pub struct Parameters {
    /// Which pile this is.
    pub pile: PileId,
    /// Which of its starts this is, from non-volatile memory.
    pub boot: BootEpoch,
    /// The highest epoch seen before this start, from non-volatile memory.
    pub highest_epoch: Epoch,
    /// What the pile gives a robot, in watts (g_pertime of LMPP eq. 2).
    pub power_w: f32,
    /// The adjustment of the planned time (eta of eq. 2).
    pub eta: DurationMs,
    /// The length of a period of the day (lambda of eq. 8).
    pub period: DurationMs,
    /// How many periods make a day.
    pub periods: u16,
    /// What counts as a pass (eq. 4).
    pub pass_rule: PassRule,
    /// The signal strengths at which a tag stands at the contacts and has left them.
    pub docked: RssiBand,
    /// A tag that was not read for this long has left the contacts.
    pub tag_timeout: DurationMs,
}

impl Parameters {
    /// Usual values for a pile in its first start: two-hour periods as in the paper's example, a
    /// reader whose field is about 3 m deep.
    #[must_use]
    pub const fn new(pile: PileId, power_w: f32) -> Self {
        Self {
            pile,
            boot: BootEpoch(1),
            highest_epoch: Epoch(0),
            power_w,
            eta: DurationMs(5_000),
            period: DurationMs(7_200_000),
            periods: 12,
            pass_rule: PassRule::PerApproach {
                band: RssiBand { enter_dbm: -70, leave_dbm: -76 },
                gap: DurationMs(3_000),
            },
            docked: RssiBand { enter_dbm: -60, leave_dbm: -66 },
            tag_timeout: DurationMs(2_000),
        }
    }
}

/// A tag the reader has read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TagRead {
    /// Which.
    pub tag: TagId,
    /// How strong its signal was.
    pub rssi_dbm: i8,
}

/// What can happen to a pile.
#[derive(Clone, Copy, Debug)]
pub enum Input<'a> {
    /// Time has passed; at least every 100 ms.
    Tick,
    /// The reader read a tag.
    Tag(TagRead),
    /// The reader answered that nothing is in its field.
    ReaderIdle,
    /// A frame arrived.
    Frame(&'a Frame),
    /// The contactor was found closed or open; at least every 100 ms if the pile has such a
    /// contact.
    ContactorFeedback {
        /// Which of the two.
        closed: bool,
    },
}

/// The contactor's command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contactor {
    /// The contacts are dead.
    Open,
    /// The contacts are live.
    Closed,
}

/// Whom a message is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum To {
    /// The coordinator.
    Coordinator,
    /// All other piles.
    Peers,
}

/// A message to send.
#[derive(Clone, Debug, PartialEq)]
pub struct Outgoing {
    /// To whom.
    pub to: To,
    /// What.
    pub message: Message,
}

/// What a step asks of the shell: the contactor first, then the memory, then the messages.
#[derive(Clone, Debug)]
pub struct Outputs {
    /// The contactor's command from now on.
    pub contactor: Contactor,
    /// An epoch that must be in non-volatile memory before the messages go out.
    pub store_epoch: Option<Epoch>,
    /// What to send, in order.
    pub messages: Vec<Outgoing, MESSAGES_PER_STEP>,
}

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
    contactor: Contactor,
    passes: PassCounter,
    reports: Reports,
    table: PileTable,
    gossip: Gossip,
    voice: Voice,
}

/// What was said last, and when.
#[derive(Clone, Debug)]
struct Voice {
    state: PileState,
    state_at: Option<Millis>,
    hello_at: Option<Millis>,
    greeted: bool,
    stored_epoch: Epoch,
}

impl ChargingPile {
    /// A pile that has just started: contacts dead, no lease, no clock.
    #[must_use]
    pub const fn new(parameters: Parameters) -> Self {
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
            faults: Faults::new(),
            contactor: Contactor::Open,
            passes: PassCounter::new(parameters.pass_rule),
            reports: Reports::new(),
            table: PileTable::new(),
            gossip: Gossip::new(),
            voice: Voice {
                state: PileState { row, elapsed: DurationMs(0), holder: None, energised: false, ended: None },
                state_at: None,
                hello_at: None,
                greeted: false,
                stored_epoch: parameters.highest_epoch,
            },
        }
    }

    /// Takes one input at `now` on the pile's own clock. Should `now` lie before an earlier step's,
    /// no time has passed.
    pub fn step(&mut self, now: Millis, input: Input<'_>) -> Outputs {
        self.pass_time(now);
        let mut messages = Vec::new();
        self.take(input, &mut messages);
        self.settle();
        self.speak(&mut messages);

        let epoch = self.leases.highest_epoch();
        let store_epoch = (epoch > self.voice.stored_epoch).then_some(epoch);
        self.voice.stored_epoch = epoch;
        Outputs { contactor: self.contactor, store_epoch, messages }
    }

    /// What the pile does with its place.
    #[must_use]
    pub fn availability(&self) -> Availability {
        match self.leases.current() {
            _ if !self.faults.active().is_empty() => Availability::Fault,
            Some(lease) if lease.charge.is_some() => Availability::Charging,
            Some(_) => Availability::Reserved,
            None if self.served.is_some() => Availability::Done,
            None => Availability::Free,
        }
    }

    /// The pile's row of the table as it was last told.
    #[must_use]
    pub const fn row(&self) -> PileRow {
        self.voice.state.row
    }

    /// Whether the contactor is told to be closed.
    #[must_use]
    pub fn energised(&self) -> bool {
        self.contactor == Contactor::Closed
    }

    /// The leases.
    #[must_use]
    pub const fn leases(&self) -> &Leases {
        &self.leases
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

    fn take(&mut self, input: Input<'_>, messages: &mut Vec<Outgoing, MESSAGES_PER_STEP>) {
        match input {
            Input::Tick => {}
            Input::Tag(TagRead { tag, rssi_dbm }) => {
                self.faults.reader_answered(self.now);
                self.presence.read(self.now, tag, rssi_dbm);
                self.passes.read(self.now, self.period(), tag, rssi_dbm);
            }
            Input::ReaderIdle => self.faults.reader_answered(self.now),
            Input::ContactorFeedback { closed } => {
                self.faults.contactor_found(self.now, closed, self.energised());
            }
            Input::Frame(frame) => match frame.header.sender {
                DeviceId::Coordinator => self.hear_coordinator(&frame.message, messages),
                DeviceId::Pile(_) => {
                    if let Message::PileTable(table) = &frame.message {
                        self.hear_table(table);
                    }
                }
                DeviceId::Robot(_) => {}
            },
        }
    }

    fn hear_coordinator(&mut self, message: &Message, messages: &mut Vec<Outgoing, MESSAGES_PER_STEP>) {
        self.leases.coordinator_heard(self.now, self.clock.site_now(self.now));
        match message {
            Message::Hello(hello) => self.greet(hello, messages),
            Message::Grant(grant) => {
                let stranger = self.presence.tags(self.now).any(|tag| tag != grant.tag);
                let place = Place {
                    site_now: self.clock.site_now(self.now),
                    faulted: !self.faults.active().is_empty(),
                    occupied: stranger,
                };
                let Parameters { power_w, eta, .. } = self.parameters;
                let planned = charge::planned_time([grant.energy], power_w, eta);
                let answer = self.leases.grant(grant, planned, place);
                say(messages, To::Coordinator, answered(Reference::Command(grant.head.id), answer));
            }
            Message::Revoke(revoke) => {
                let answer = self.leases.revoke(revoke, self.clock.site_now(self.now));
                say(messages, To::Coordinator, answered(Reference::Command(revoke.head.id), answer));
            }
            Message::TimeSync(sync) => self.clock.accept(self.now, sync),
            Message::Ack(Ack { of: Reference::Report(report) }) => self.reports.acknowledged(*report),
            Message::PileTable(table) => self.hear_table(table),
            _ => {}
        }
    }

    /// The coordinator's Hello answers ours, or is the first of its start and wants ours. Ours
    /// is held back while the last is fresh, so that two answers never chase each other.
    fn greet(&mut self, hello: &Hello, messages: &mut Vec<Outgoing, MESSAGES_PER_STEP>) {
        self.leases.see_epoch(hello.epoch);
        if self.voice.greeted && self.is_due(self.voice.hello_at, limits::REPEAT_INTERVAL) {
            self.say_hello(messages);
        }
        self.voice.greeted = true;
    }

    /// Rows about this pile are its own to write.
    fn hear_table(&mut self, table: &protocol::PileTable) {
        for row in table.rows.iter().filter(|row| row.pile != self.parameters.pile) {
            self.table.merge_row(*row);
        }
    }

    /// Ends what is over, begins what can begin, and commands the contactor.
    fn settle(&mut self) {
        self.faults.tick(self.now);
        if self.served.is_some_and(|tag| !self.presence.contains(self.now, tag)) {
            self.served = None;
        }
        if let Some(reason) = self.end_of_lease() {
            self.leases.end(reason);
        }
        let expected = self.leases.current().map(|lease| lease.tag);
        if let Some(tag) = expected.filter(|&tag| self.presence.contains(self.now, tag)) {
            self.leases.begin_charge();
            self.served = Some(tag);
        }
        // Nothing may have been planned.
        if self.leases.charge_mut().is_some_and(|charge| charge.is_complete()) {
            self.leases.end(EndReason::Completed);
        }

        let lease = self.leases.current();
        let live = safety::may_energise(self.now, &self.clock, lease, &self.presence, &self.faults);
        if live != self.energised() {
            self.contactor = if live { Contactor::Closed } else { Contactor::Open };
            self.faults.contactor_switched();
        }
    }

    fn end_of_lease(&self) -> Option<EndReason> {
        let lease = self.leases.current()?;
        let site_now = self.clock.site_now(self.now)?;
        if lease.charge.is_some_and(|charge| charge.is_complete()) {
            Some(EndReason::Completed)
        } else if !self.faults.active().is_empty() {
            Some(EndReason::Fault)
        } else if lease.has_run_out(self.now, site_now) {
            Some(EndReason::Expired)
        } else if lease.charge.is_some() && !self.presence.contains(self.now, lease.tag) {
            Some(EndReason::RobotLeft)
        } else {
            None
        }
    }

    fn speak(&mut self, messages: &mut Vec<Outgoing, MESSAGES_PER_STEP>) {
        if !self.voice.greeted && self.is_due(self.voice.hello_at, limits::REPEAT_INTERVAL) {
            self.say_hello(messages);
        }
        if let Some(request) = self.clock.request(self.now, self.lease_is_overdue()) {
            say(messages, To::Coordinator, Message::TimeRequest(request));
        }
        self.say_state(messages);
        let period = self.period();
        if let Some(report) = self.reports.due(self.now, period, &mut self.faults, &mut self.passes) {
            say(messages, To::Coordinator, report);
        }
        if let Some(part) = self.gossip.part(self.now, &self.voice.state.row, &self.table) {
            say(messages, To::Peers, Message::PileTable(part));
        }
    }

    fn say_hello(&mut self, messages: &mut Vec<Outgoing, MESSAGES_PER_STEP>) {
        let part = |text: &str| text.parse().unwrap_or(0);
        let software = [
            part(env!("CARGO_PKG_VERSION_MAJOR")),
            part(env!("CARGO_PKG_VERSION_MINOR")),
            part(env!("CARGO_PKG_VERSION_PATCH")),
        ];
        let epoch = self.leases.highest_epoch();
        let hello = Hello { min: version::MIN, current: version::CURRENT, software, epoch };
        self.voice.hello_at = Some(self.now);
        say(messages, To::Coordinator, Message::Hello(hello));
    }

    /// Tells the state if it has changed, or was told long ago (LMPP Fig. 1).
    fn say_state(&mut self, messages: &mut Vec<Outgoing, MESSAGES_PER_STEP>) {
        let told = self.voice.state;
        let mut state = self.state();
        let changed = (state.holder, state.energised, state.ended, state.row.availability, state.row.planned)
            != (told.holder, told.energised, told.ended, told.row.availability, told.row.planned)
            || (state.row.remaining.get() - told.row.remaining.get()).abs() >= REMAINING_STEP;
        if !changed && !self.is_due(self.voice.state_at, limits::STATE_INTERVAL) {
            return;
        }
        if state.row != told.row {
            state.row.version = told.row.version.saturating_add(1);
            state.row.stamp = self.clock.site_now(self.now);
        }
        self.voice.state = state;
        self.voice.state_at = Some(self.now);
        say(messages, To::Coordinator, Message::PileState(state));
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
                ..self.voice.state.row
            },
            elapsed: charge.elapsed(),
            holder: lease.map(|lease| lease.name),
            energised: self.energised(),
            ended: self.leases.ended(),
        }
    }

    fn period(&self) -> Option<u16> {
        let site_now = self.clock.site_now(self.now)?;
        Some(period_of(site_now, self.parameters.period, self.parameters.periods))
    }

    fn lease_is_overdue(&self) -> bool {
        let site_now = self.clock.site_now(self.now);
        self.leases.current().zip(site_now).is_some_and(|(lease, site_now)| site_now >= lease.expiry)
    }

    fn is_due(&self, last: Option<Millis>, interval: DurationMs) -> bool {
        last.is_none_or(|last| self.now.since(last) >= interval)
    }
}

fn answered(of: Reference, answer: Answer) -> Message {
    match answer {
        Ok(()) => Message::Ack(Ack { of }),
        Err(reason) => Message::Nack(Nack { of, reason }),
    }
}

fn say(messages: &mut Vec<Outgoing, MESSAGES_PER_STEP>, to: To, message: Message) {
    // It fits: a step sends each kind of message at most once, and they are fewer than the room.
    let _ = messages.push(Outgoing { to, message });
}
