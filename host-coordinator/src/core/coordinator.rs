//! The coordinator's step: who is heard, what it means, and what follows from it.
//!
//! A step takes one input in, and then settles what follows from it: leases (`grants`), the queue and
//! what robots are told (`queue`). A frame concerns its sender and whoever an event names; what only time
//! brings, for everybody, is settled at each tick. So a frame does not walk through all leases and requests.

use std::{collections::BTreeMap, sync::Arc};

use planning::lmpp::Lmpp;
use protocol::{
    Ack, Activity, Availability, BootEpoch, ChargeReport, ClaimRule, DeviceId, DurationMs, Epoch, Fault,
    Frame, Hello, LeaseId, LeaseRef, Message, PassReport, PileFaults, PileId, Reference, RobotId, RobotState,
    SiteMillis, TagId, TimeSync, version,
};

use super::{
    event::{Event, Fact, Passes},
    observed::{Distrust, Freshness, Observed},
    orders::Order,
    routes::Routes,
    site_view::SiteView,
    state::{Phase, State},
    turn::{Concerned, Turn},
};
use crate::{
    config::{Policy, RobotConfig},
    selection::ChargingPolicy,
    site::Site,
};

/// What happens to the coordinator.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "nearly all inputs are frames")]
pub enum Input {
    /// It begins, or begins again after a crash: always the first input.
    Started {
        /// The time in seconds since 1970. The start gets at least this number, so that it is a new one
        /// also when the log was lost.
        boot_floor: BootEpoch,
    },
    /// A frame arrived.
    Frame(Frame),
    /// A frame arrived that says it is of this device and does not authenticate.
    Distrusted(DeviceId),
    /// Somebody orders something over the API.
    Order(Order),
    /// Time has passed; several times a second.
    Tick,
}

/// What the shell is to do, once the step's events are in the log.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "nearly all effects are messages")]
pub enum Effect {
    /// Send a message.
    Send {
        /// To whom.
        to: DeviceId,
        /// What.
        message: Message,
    },
    /// Tell the operator. The same trouble has the same text, so that it can be told once.
    Warn(String),
}

/// The outcome of a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Step {
    /// What changed, to be recorded before anything else.
    pub events: Vec<Event>,
    /// What is to be done after that, in order.
    pub effects: Vec<Effect>,
}

/// Decides who charges where. Pure: its time, its input and its past are arguments.
#[derive(Debug)]
pub struct Coordinator {
    pub(super) site: Arc<Site>,
    pub(super) policy: Policy,
    pub(super) chooser: Box<dyn ChargingPolicy>,
    pub(super) robots: BTreeMap<RobotId, RobotConfig>,
    pub(super) state: State,
    pub(super) observed: Observed,
    pub(super) routes: Arc<Routes>,
    pub(super) site_view: Arc<SiteView>,
}

impl Coordinator {
    /// A coordinator with the past that `events` tell, and with the memory of `site`'s paths.
    #[must_use]
    pub fn recover<'a>(
        site: Arc<Site>,
        memory: Lmpp,
        policy: Policy,
        robots: &[RobotConfig],
        events: impl IntoIterator<Item = &'a Event>,
    ) -> Self {
        let routes = Routes::new(memory, &site, policy.theta);
        Self {
            site_view: Arc::new(SiteView::new(&site, |door| routes.is_open(door))),
            routes: Arc::new(routes),
            site,
            chooser: policy.choose.policy(policy.q_threshold),
            policy,
            robots: robots.iter().map(|robot| (robot.id, *robot)).collect(),
            state: State::fold(events),
            observed: Observed::default(),
        }
    }

    /// This coordinator as it is after a crash: with the past that `events` tell, and nothing but what
    /// never changes. As [`Self::recover`], without planning anything again.
    #[must_use]
    pub fn restarted<'a>(&self, events: impl IntoIterator<Item = &'a Event>) -> Self {
        Self {
            site: Arc::clone(&self.site),
            chooser: self.policy.choose.policy(self.policy.q_threshold),
            policy: self.policy,
            robots: self.robots.clone(),
            state: State::fold(events),
            observed: Observed::default(),
            routes: Arc::clone(&self.routes),
            site_view: Arc::clone(&self.site_view),
        }
    }

    /// Takes one input. The events are already part of [`Self::state`]; the effects must wait until
    /// they are recorded.
    pub fn step(&mut self, now: SiteMillis, input: Input) -> Step {
        let mut turn = Turn { now, step: Step::default(), concerned: Concerned::default() };
        match input {
            Input::Started { boot_floor } => {
                self.observed = Observed { started: now, queue_is_due: true, ..Observed::default() };
                self.note_clock(&mut turn);
                let boot = BootEpoch(self.state.boot.0.saturating_add(1)).max(boot_floor);
                self.record(&mut turn, Fact::Started { boot });
                self.start_epoch(&mut turn, Epoch(0), LeaseId(1));
            }
            Input::Distrusted(device) => {
                turn.concerned.device(device);
                self.distrust(&mut turn, device);
            }
            Input::Frame(frame) => {
                turn.concerned.device(frame.header.sender);
                self.hear(&mut turn, frame);
            }
            Input::Order(order) => self.obey(&mut turn, &order),
            Input::Tick => {
                turn.concerned.everybody();
                self.compare_words(&mut turn);
                self.call_robots(&mut turn);
            }
        }
        let robots = self.concerned_robots(&turn);
        self.withdraw_requests(&mut turn, &robots);
        let piles = self.concerned_piles(&turn);
        self.tend_leases(&mut turn, &piles);
        self.tend_help(&mut turn);
        self.serve_queue(&mut turn);
        self.serve_helpless(&mut turn);
        let robots = self.concerned_robots(&turn);
        self.instruct_robots(&mut turn, &robots);
        turn.step
    }

    /// The durable state.
    #[must_use]
    pub const fn state(&self) -> &State {
        &self.state
    }

    /// What was heard since the start. With the durable state it is all that a step depends on.
    #[must_use]
    pub const fn observed(&self) -> &Observed {
        &self.observed
    }

    /// Whether the device belongs to the site or the fleet.
    #[must_use]
    pub fn knows(&self, device: DeviceId) -> bool {
        match device {
            // A chassis talks to its robot's computer only, the others at a desk.
            DeviceId::Coordinator | DeviceId::Chassis(_) | DeviceId::Service | DeviceId::Factory => false,
            DeviceId::Pile(pile) => self.site.pile(pile).is_some(),
            DeviceId::Robot(robot) => self.robots.contains_key(&robot),
        }
    }

    /// A start at an earlier time than the log has reached.
    fn note_clock(&mut self, turn: &mut Turn) {
        let by = self.state.last_at.since(turn.now);
        if by > DurationMs(0) {
            self.record(turn, Fact::ClockSetBack { by });
            turn.warn(format!(
                "this computer's clock is {:.0} s behind the event log: leases that were granted before may last \
                 so much longer; set the clock",
                by.as_seconds()
            ));
        }
    }

    /// Makes a change, and notes it for the log.
    pub(super) fn record(&mut self, turn: &mut Turn, fact: Fact) {
        let event = Event { at: turn.now, fact };
        self.state.apply(&event);
        turn.concerned.fact(&event.fact);
        turn.step.events.push(event);
    }

    fn hear(&mut self, turn: &mut Turn, frame: Frame) {
        let Frame { header, message } = frame;
        let sender = header.sender;
        if !self.knows(sender) {
            turn.warn(format!("{sender} is not of this site; its frames are ignored"));
            return;
        }
        let Some(contact) = self.observed.contact(sender) else { return };
        match contact.hear(turn.now, header) {
            Freshness::FirstOfBoot => {
                contact.greeted = false;
                if let DeviceId::Pile(pile) = sender {
                    self.observed.piles.entry(pile).or_default().report = None;
                }
            }
            Freshness::Newer => {}
            Freshness::Old => return,
            Freshness::OldBoot => {
                turn.warn(format!(
                    "{sender} sends frames of an earlier start than one heard before; they are ignored. \
                     If its memory was replaced, restart the coordinator"
                ));
                return;
            }
        }
        self.greet(turn, sender, &message);
        match sender {
            DeviceId::Pile(pile) => self.hear_pile(turn, pile, message),
            DeviceId::Robot(robot) => self.hear_robot(turn, robot, header.boot, message),
            DeviceId::Coordinator | DeviceId::Chassis(_) | DeviceId::Service | DeviceId::Factory => {}
        }
    }

    /// Answers every Hello, and sends one to a device that does not know of our start yet.
    fn greet(&mut self, turn: &mut Turn, device: DeviceId, message: &Message) {
        let Some(contact) = self.observed.contact(device) else { return };
        if let Message::Hello(theirs) = message {
            let theirs = version::Range { min: theirs.min, current: theirs.current };
            if let Err(error) = version::negotiate(version::OURS, theirs) {
                turn.warn(format!("{device}: {error}"));
            }
        } else if contact.greeted {
            return;
        }
        contact.greeted = true;
        if let Message::Hello(hello) = message
            && matches!(device, DeviceId::Pile(_))
            && hello.epoch > self.state.epoch
        {
            self.start_epoch(turn, hello.epoch, LeaseId(0));
        }
        self.say_hello(turn, device);
    }

    fn say_hello(&self, turn: &mut Turn, device: DeviceId) {
        turn.send(device, Message::Hello(Hello::new(self.state.epoch)));
    }

    /// Says Hello to who does not know of our start yet, if it is that.
    fn distrust(&mut self, turn: &mut Turn, device: DeviceId) {
        if !self.knows(device) {
            return;
        }
        let Some(contact) = self.observed.contact(device) else { return };
        let Distrust { greet, warn } = contact.distrust(turn.now);
        if greet {
            self.say_hello(turn, device);
        }
        if warn {
            turn.warn(format!(
                "frames that say they are of {device} do not authenticate: its key is not the one in the \
                 coordinator's file of keys, or somebody forges them"
            ));
        }
    }

    /// Goes beyond every epoch heard of, and beyond every lease number.
    pub(super) fn start_epoch(&mut self, turn: &mut Turn, heard: Epoch, next_lease: LeaseId) {
        let epoch = Epoch(self.state.epoch.max(heard).0.saturating_add(1));
        let next_lease = self.state.next_lease.max(next_lease);
        self.record(turn, Fact::EpochStarted { epoch, next_lease });
    }

    fn hear_pile(&mut self, turn: &mut Turn, pile: PileId, message: Message) {
        let to = DeviceId::Pile(pile);
        match message {
            Message::PileState(report) => self.hear_report(turn, pile, report),
            Message::Ack(Ack { of: Reference::Command(command) }) => self.hear_ack(turn, pile, command),
            Message::Nack(nack) => {
                if let Reference::Command(command) = nack.of {
                    self.hear_nack(turn, pile, command, nack.reason);
                }
            }
            Message::PassReport(report) => {
                self.count_passes(turn, pile, &report);
                turn.send(to, Message::Ack(Ack { of: Reference::Report(report.report) }));
            }
            Message::ChargeReport(report) => {
                self.note_charge(turn, pile, &report);
                turn.send(to, Message::Ack(Ack { of: Reference::Report(report.report) }));
            }
            Message::Fault(fault) => {
                self.note_fault(turn, pile, fault);
                turn.send(to, Message::Ack(Ack { of: Reference::Report(fault.report) }));
            }
            Message::PileFaults(told) => self.hear_farewell(turn, pile, &told),
            Message::TimeRequest(request) => {
                turn.send(to, Message::TimeSync(TimeSync { asked_at: request.asked_at, site_now: turn.now }));
                // Piles that serve claims don't know what power there is.
                let allowed = self.policy.power_cap_w.is_none();
                turn.send(to, Message::ClaimRule(ClaimRule { allowed }));
            }
            // Hello is answered, gossip is forwarded by the links, the rest is not a pile's to say.
            _ => {}
        }
    }

    fn hear_robot(&mut self, turn: &mut Turn, robot: RobotId, boot: BootEpoch, message: Message) {
        match message {
            Message::RobotState(report) => self.hear_robot_state(turn, robot, report),
            Message::RescueState(report) => self.hear_rescue(turn, robot, report),
            Message::ChargeRequest(request) => self.hear_request(turn, robot, boot, request),
            Message::TaskEnergy(done) => {
                self.record(turn, Fact::TaskDone { robot, task: done.task, energy: done.last });
            }
            Message::TimeRequest(request) => turn.send(
                DeviceId::Robot(robot),
                Message::TimeSync(TimeSync { asked_at: request.asked_at, site_now: turn.now }),
            ),
            _ => {}
        }
    }

    fn hear_robot_state(&mut self, turn: &mut Turn, robot: RobotId, report: RobotState) {
        self.observed.robots.entry(robot).or_default().hear(turn.now, report);
        // It follows a call of which the end was not heard.
        if let Some(request) = report.accepted.filter(|request| request.is_call())
            && matches!(report.activity, Activity::Approaching | Activity::Docked)
            && !self.state.requests.contains_key(&robot)
        {
            self.send_to_work(turn, robot, request);
        }
        let stranded = self.state.stranded.contains(&robot);
        match report.activity {
            Activity::Stranded if !stranded => {
                self.record(turn, Fact::Stranded { robot });
                turn.warn(format!("robot {robot} has stranded: help has to come"));
            }
            Activity::Working
            | Activity::Waiting
            | Activity::Approaching
            | Activity::Docked
            | Activity::Charging
                if stranded =>
            {
                self.record(turn, Fact::Recovered { robot });
            }
            _ => {}
        }
    }

    /// Whose tag it is.
    pub(super) fn robot_of(&self, tag: TagId) -> Option<RobotId> {
        self.robots.values().find(|robot| robot.tag == tag).map(|robot| robot.id)
    }

    /// Adds a report's passes once, however often it comes.
    fn count_passes(&mut self, turn: &mut Turn, pile: PileId, report: &PassReport) {
        let counted = self.state.piles.get(&pile).and_then(|record| record.pass_report);
        if counted.is_some_and(|counted| report.report <= counted) {
            return;
        }
        let counts = report.passes.iter().filter(|count| count.period < super::PILE.periods);
        let passes = counts.filter_map(|count| {
            Some(Passes { robot: self.robot_of(count.tag)?, period: count.period, passes: count.passes })
        });
        let passes = passes.collect();
        self.record(turn, Fact::Passed { pile, report: report.report, passes });
    }

    /// Notes a charge once, however often it is reported.
    fn note_charge(&mut self, turn: &mut Turn, pile: PileId, told: &ChargeReport) {
        let noted = self.state.piles.get(&pile).and_then(|record| record.charge_report);
        if noted.is_some_and(|noted| told.report <= noted) {
            return;
        }
        let ChargeReport { report, lease: LeaseRef { lease, robot, .. }, reason, .. } = *told;
        let ChargeReport { began, ended, charged, energy, .. } = *told;
        self.record(
            turn,
            Fact::Charged { pile, report, lease, robot, reason, began, ended, charged, energy },
        );
    }

    fn note_fault(&mut self, turn: &mut Turn, pile: PileId, fault: Fault) {
        let noted = self.state.piles.get(&pile).and_then(|record| record.fault_report);
        if noted.is_some_and(|noted| fault.report <= noted) {
            return;
        }
        let Fault { report, code, active } = fault;
        self.record(turn, Fact::FaultReported { pile, report, code, active });
        if active {
            turn.warn(format!("pile {pile} has a fault: {}", super::view::fault_name(code)));
        }
    }

    /// The last word of a pile that loses its mains. What it names is reported, for the record, when
    /// the pile is back.
    fn hear_farewell(&mut self, turn: &mut Turn, pile: PileId, told: &PileFaults) {
        if let Some(report) = &mut self.observed.piles.entry(pile).or_default().report {
            report.row.availability = Availability::Fault;
        }
        for fault in told.faults.iter().filter(|fault| fault.active) {
            turn.warn(format!("pile {pile} falls silent: {}", super::view::fault_name(fault.code)));
        }
    }

    /// Raises epoch and lease numbers when a pile knows of higher ones: the event log was lost, or
    /// another coordinator reigned in between.
    pub(super) fn outdo(&mut self, turn: &mut Turn, named: LeaseRef) {
        let next = named.lease.next();
        if named.epoch > self.state.epoch || next > self.state.next_lease {
            self.start_epoch(turn, named.epoch, next);
        }
    }

    /// Whether a robot went back to work although it asked for a charge.
    pub(super) fn is_back_at_work(&self, robot: RobotId) -> bool {
        self.observed.robots.get(&robot).is_some_and(|seen| {
            seen.left_work && seen.report.is_some_and(|report| report.activity == Activity::Working)
        })
    }

    /// Whether a robot does not follow its assignment but works on, long after the grant.
    pub(super) fn ignores_its_assignment(&self, robot: RobotId, now: SiteMillis) -> bool {
        let Some(since) = self.observed.robots.get(&robot).and_then(|seen| seen.working_since) else {
            return false;
        };
        let granted =
            self.state.piles.values().filter_map(|record| record.lease.as_ref()).find_map(|lease| {
                (lease.name.robot == robot && matches!(lease.phase, Phase::Held { .. }))
                    .then_some(lease.granted_at)
            });
        granted.is_some_and(|granted| now.since(since.max(granted)) > super::ROBOT_PATIENCE)
    }
}
