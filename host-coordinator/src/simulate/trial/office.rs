//! The coordinator: its core, its log, its clock, and how it crashes.

use std::mem;

use protocol::{BootEpoch, DeviceId, DurationMs, EndReason, Message, RobotId, SiteMillis, limits};

use super::{
    Ground,
    breach::Breach,
    faults::Fault,
    network::{Letter, Node, Session},
    piles::Pile,
    run::{Occasion, Run},
};
use crate::{
    core::{
        Coordinator, Effect, Event, Fact, Input, State, Step,
        event::{HelpEnd, LeaseEnd, Opener},
        state::Phase,
    },
    simulate::{auditor::Violation, random::Random},
};

/// How long a crashed coordinator is away, in seconds: from, to.
const AWAY_S: (f64, f64) = (1.0, 20.0);
/// How long it is away when nobody starts it again, in seconds: from, to.
const OUTAGE_S: (f64, f64) = (60.0, 240.0);
/// Steps of the clock in milliseconds: up to one of these, forwards or back.
const CLOCK_STEPS_MS: [f64; 3] = [2_000.0, 60_000.0, 3_600_000.0];
/// A run begins at this hour of the site's day, so that the clock can be set back.
const FIRST_HOURS: (f64, f64) = (2.0, 24.0);
/// An hour in milliseconds.
const HOUR_MS: f64 = 3_600_000.0;

/// Where in its next step that records something the coordinator crashes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Doom {
    /// Before the events are recorded.
    Unrecorded,
    /// After that, when this share of the effects is done.
    Performed(f64),
}

/// The coordinator.
#[derive(Debug)]
pub(super) struct Office {
    pub coordinator: Coordinator,
    up: bool,
    pub log: Vec<Event>,
    /// Events that were read back from the log.
    read_back: usize,
    /// The fold of the log, event by event.
    shadow: State,
    pub piles: Vec<Session>,
    pub robots: Vec<Session>,
    doom: Option<Doom>,
    /// What the site's clock is ahead of the run's, in milliseconds.
    ahead_ms: i64,
}

impl Office {
    /// A coordinator that has not started yet, at some hour of the day.
    pub fn new(ground: &Ground, robots: usize, random: &mut Random) -> Self {
        Self {
            coordinator: ground.coordinator.restarted([]),
            up: false,
            log: Vec::new(),
            read_back: 0,
            shadow: State::default(),
            piles: vec![Session::default(); ground.piles.len()],
            robots: vec![Session::default(); robots],
            doom: None,
            ahead_ms: (random.between(FIRST_HOURS.0, FIRST_HOURS.1) * HOUR_MS) as i64,
        }
    }

    /// Whether it runs.
    pub const fn is_up(&self) -> bool {
        self.up
    }

    /// Which start it is in.
    pub const fn boot(&self) -> BootEpoch {
        self.coordinator.state().boot
    }

    /// Charges that were cut short for a critical robot.
    pub const fn preempted(&self) -> u64 {
        self.shadow.totals.preempted
    }

    /// Adds events to the log and to its fold.
    fn record(&mut self, events: Vec<Event>) {
        events.iter().for_each(|event| self.shadow.apply(event));
        self.log.extend(events);
    }

    /// What the log says wrong, if anything: of the state, and of events since it was last asked.
    fn wrong(&mut self) -> Option<Breach> {
        let since = mem::replace(&mut self.read_back, self.log.len());
        let new = self.log.iter().enumerate().skip(since);
        let reads_back = |event: &Event| {
            let text = serde_json::to_string(&event.fact).ok();
            text.and_then(|text| serde_json::from_str::<Fact>(&text).ok()).as_ref() == Some(&event.fact)
        };
        if let Some((index, _)) = new.into_iter().find(|(_, event)| !reads_back(event)) {
            return Some(Breach::OtherEvent { index });
        }
        (self.shadow != *self.coordinator.state()).then_some(Breach::OtherState)
    }
}

impl Run<'_> {
    /// The site's time by the coordinator's computer.
    pub fn site_now(&self) -> SiteMillis {
        SiteMillis(self.now.0.saturating_add_signed(self.office.ahead_ms))
    }

    pub fn start_office(&mut self) {
        if self.office.up {
            return;
        }
        self.office.coordinator = self.ground.coordinator.restarted(&self.office.log);
        self.office.up = true;
        self.coordinate(Input::Started { boot_floor: BootEpoch(0) });
    }

    pub fn tick(&mut self) {
        self.coordinate(Input::Tick);
        self.check_book();
    }

    /// Compares the state with the log.
    pub fn review(&mut self) {
        if self.office.up
            && let Some(breach) = self.office.wrong()
        {
            self.note(breach);
        }
        self.check_two_piles();
    }

    /// No two piles hold to one robot for longer than a robot may take to a pile it has claimed.
    fn check_two_piles(&mut self) {
        for index in 0..self.rovers.len() {
            let robot = self.rovers[index].id;
            let holds = |pile: &&Pile| pile.holder() == Some(robot);
            let mut held = self.piles.iter().filter(holds).map(|pile| pile.id);
            let two = held.next().zip(held.next());
            let since = &mut self.rovers[index].two_since;
            let Some((one, other)) = two else {
                *since = None;
                continue;
            };
            if self.now.since(*since.get_or_insert(self.now)) > limits::LONGEST_CLAIM {
                self.note(Breach::DoubleGrant(Violation::TwoPiles { robot, one, other }));
            }
        }
    }

    pub fn office_takes(&mut self, letter: Letter) {
        let asks = match (letter.from, &letter.frame.message) {
            (Node::Robot(robot), Message::ChargeRequest(asked)) => {
                Some((robot, letter.frame.header.boot, asked.request))
            }
            _ => None,
        };
        self.coordinate(Input::Frame(*letter.frame));
        if let Some((robot, boot, request)) = asks
            && self.office.up
        {
            let rover = &mut self.rovers[robot];
            rover.heard = Some((boot, request));
            let id = rover.id;
            if !self.is_booked(id) {
                self.note(Breach::Forgotten { robot: id });
            }
        }
    }

    pub fn office_distrusts(&mut self, sender: DeviceId) {
        self.coordinate(Input::Distrusted(sender));
    }

    /// Whether a robot's request is in the coordinator's book.
    pub fn is_booked(&self, robot: RobotId) -> bool {
        self.office.coordinator.state().requests.contains_key(&robot)
    }

    pub fn coordinate(&mut self, input: Input) {
        if !self.office.up {
            return;
        }
        let now = self.site_now();
        let Step { events, effects } = self.office.coordinator.step(now, input);
        self.tally.counts.coordinator_steps += 1;
        let doom = if events.is_empty() { None } else { self.office.doom.take() };
        if doom == Some(Doom::Unrecorded) {
            self.crash_office();
            return;
        }
        self.count(&events);
        self.office.record(events);
        let performed = match doom {
            Some(Doom::Performed(share)) => (share * effects.len() as f64) as usize,
            _ => effects.len(),
        };
        for effect in effects.into_iter().take(performed) {
            if let Effect::Send { to, message } = effect
                && let Some(to) = self.node(to)
            {
                self.send(Node::Office, to, message);
            }
        }
        if doom.is_some() {
            self.review();
            self.crash_office();
        }
    }

    fn count(&mut self, events: &[Event]) {
        for event in events {
            match event.fact {
                Fact::Asked { robot, opener: Opener::Coordinator, .. } => {
                    if let Some(index) = self.robot_index(robot) {
                        self.sum_up(index);
                        self.needs(index);
                    }
                }
                Fact::Granted { .. } => self.tally.counts.granted += 1,
                Fact::Ended { why: LeaseEnd::ByPile(EndReason::Completed), .. } => {
                    self.tally.counts.completed += 1
                }
                Fact::HelpEnded { why: HelpEnd::Charged { .. }, .. } => self.tally.counts.rescued += 1,
                Fact::HelpEnded { why: HelpEnd::Towed { .. }, .. } => self.tally.counts.towed += 1,
                Fact::TowWanted { robot, .. } => self.call_for_tow(robot),
                _ => {}
            }
        }
    }

    /// The coordinator will crash in its next step that records something.
    pub fn doom_office(&mut self) {
        let chance = self.troubles.chance(Fault::CoordinatorCrash);
        let doom = match chance.between(0.0, 1.0) {
            unrecorded if unrecorded < 0.3 => Doom::Unrecorded,
            _ => Doom::Performed(chance.between(0.0, 1.0)),
        };
        self.office.doom.get_or_insert(doom);
    }

    /// The coordinator's computer starts anew, with another time.
    pub fn step_clock(&mut self) {
        let chance = self.troubles.chance(Fault::Clock);
        let most_ms = chance.choose(&CLOCK_STEPS_MS).copied().unwrap_or(0.0);
        let step_ms = chance.between(-most_ms, most_ms) as i64;
        self.crash_office();
        self.office.ahead_ms += step_ms;
    }

    /// The coordinator stops, and nobody starts it again for minutes.
    pub fn stop_office_for_long(&mut self) {
        self.stop_office(Fault::Outage, OUTAGE_S);
    }

    fn crash_office(&mut self) {
        self.stop_office(Fault::CoordinatorCrash, AWAY_S);
    }

    fn stop_office(&mut self, fault: Fault, away_s: (f64, f64)) {
        if !self.office.up {
            return;
        }
        self.office.up = false;
        self.office.doom = None;
        if State::fold(&self.office.log) != self.office.shadow {
            self.note(Breach::OtherState);
        }
        self.office.piles.fill(Session::default());
        self.office.robots.fill(Session::default());
        let away_s = self.troubles.chance(fault).between(away_s.0, away_s.1);
        self.agenda.put(self.now.after(DurationMs::from_seconds(away_s as f32)), Occasion::OfficeStarts);
    }

    /// No lease stays in the book that can't be alive any more.
    fn check_book(&mut self) {
        if !self.office.up {
            return;
        }
        let dead = self.site_now();
        let state = self.office.coordinator.state();
        let over = state.piles.iter().find_map(|(pile, record)| {
            let lease = record.lease.as_ref()?;
            let held = matches!(lease.phase, Phase::Held { .. });
            let over = !held && dead > lease.expiry.after(crate::core::CLOCK_MARGIN);
            over.then_some(Breach::BookedTooLong { pile: *pile, lease: lease.name.lease })
        });
        if let Some(breach) = over {
            self.note(breach);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use protocol::{Activity, Millis};

    use super::*;
    use crate::{
        config::Policy,
        simulate::trial::{Trial, faults::Faults, rovers::Rover},
        site::Site,
    };

    const TRIAL: Trial =
        Trial { seed: 1, robots: 20, duration: DurationMs(600_000), faults: Faults::NONE, only: 0..u64::MAX };

    fn ground() -> Ground {
        let mut site = Site::fig7().unwrap();
        site.piles.truncate(2);
        Ground::new(&Arc::new(site), Policy::default(), 20, 0)
    }

    /// A run up to when robots wait for one of two piles.
    fn crowded(ground: &Ground) -> Run<'_> {
        let mut run = Run::new(ground, &TRIAL);
        run.run_until(Millis(400_000));
        assert_eq!(run.breach, None);
        assert!(run.office.coordinator.state().requests.len() > 2, "nobody waits");
        run
    }

    #[test]
    fn a_log_with_an_event_too_few_is_found_at_the_next_crash() {
        let ground = ground();
        let mut run = crowded(&ground);
        run.office.log.pop();
        run.crash_office();
        assert_eq!(run.breach, Some(Breach::OtherState));
    }

    #[test]
    fn a_state_that_is_not_in_the_log_is_found_at_the_next_review() {
        let ground = ground();
        let mut run = crowded(&ground);
        let robot = *run.office.coordinator.state().requests.keys().next().unwrap();
        let secret = Event { at: run.site_now(), fact: Fact::Stranded { robot } };
        let past = run.office.log.iter().chain([&secret]);
        run.office.coordinator = ground.coordinator.restarted(past);
        run.review();
        assert_eq!(run.breach, Some(Breach::OtherState));
    }

    #[test]
    fn a_robot_that_the_coordinator_forgets_is_found() {
        let ground = ground();
        let mut run = crowded(&ground);
        // Who is only called works on, and misses nothing.
        let asks = |rover: &Rover| rover.activity() == Some(Activity::Waiting) && rover.heard.is_some();
        while !run.rovers.iter().any(asks) {
            let until = Millis(run.now.0 + 1_000);
            run.run_until(until);
            run.now = until;
        }
        let waiting: Vec<_> = run.office.coordinator.state().requests.keys().copied().collect();
        let at = run.site_now();
        let dropped = waiting.iter().map(|&robot| Event { at, fact: Fact::Withdrawn { robot } });
        run.office.record(dropped.collect());
        run.office.coordinator = ground.coordinator.restarted(&run.office.log);
        // A coordinator that does not hear and so cannot take them in again.
        let until = Millis(run.now.0 + 60_000);
        let lost = run.rovers.iter().position(asks).unwrap();
        run.office.robots[lost] = Session::default();
        while run.now < until && run.breach.is_none() {
            let robots: Vec<_> = (0..run.rovers.len()).collect();
            run.now.0 += 1_000;
            robots.into_iter().for_each(|robot| run.check_booked(robot));
        }
        assert!(matches!(run.breach, Some(Breach::Forgotten { .. })), "{:?}", run.breach);
    }

    #[test]
    fn a_lease_that_stays_in_the_book_is_found() {
        let ground = ground();
        let mut run = crowded(&ground);
        let lease = loop {
            let state = run.office.coordinator.state();
            let offered = state.piles.iter().find_map(|(pile, record)| {
                let lease = record.lease.filter(|lease| lease.phase == Phase::Offered)?;
                Some((*pile, lease.name.lease))
            });
            if let Some(found) = offered {
                break found;
            }
            let until = Millis(run.now.0 + 5);
            run.run_until(until);
            run.now = until;
        };
        run.check_book();
        assert_eq!(run.breach, None);
        run.office.ahead_ms += 120_000;
        run.check_book();
        let (pile, lease) = lease;
        assert_eq!(run.breach, Some(Breach::BookedTooLong { pile, lease }));
    }
}
