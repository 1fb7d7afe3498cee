//! All that can happen, one thing at a time, and what must hold after each.

use std::{collections::HashMap, sync::Mutex};

use protocol::{DurationMs, Message, PileId, RobotId, SiteMillis};
use stateright::{Model, Property};

use crate::{
    interner::Interner,
    office::{Desk, Hear, Office},
    pile::{self, Firmware, Pile},
    rules,
};

/// When it begins.
pub const START: SiteMillis = SiteMillis(1_000_000);
/// How far time goes at once.
pub const TICK: DurationMs = DurationMs(5_000);
/// How often robots claim piles, where they do.
const CLAIMS: u8 = 2;
/// How far a pile's clock may be behind.
const MARGIN: DurationMs = DurationMs(5_000);

pub const PILES: [PileId; 2] = [PileId(1), PileId(2)];
const ROBOTS: [RobotId; 2] = [RobotId(1), RobotId(2)];

/// What is asked of the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// One log, one coordinator at a time.
    Succession,
    /// The same, and robots claim piles by themselves.
    Claims,
    /// Two coordinators, the second with an old copy of the first one's log.
    Rivals,
}

/// The state of everything.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Snapshot {
    ticks: u8,
    late: bool,
    seats: Vec<Seat>,
    piles: [PileSnapshot; 2],
    robots: [RobotSnapshot; 2],
    /// What was sent: it may arrive at any time, any number of times, or never.
    network: Vec<Envelope>,
    /// What may still go wrong.
    crashes: [u8; 3],
    /// How often robots may still claim.
    claims: u8,
}

/// A coordinator, by its number in the office.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Seat {
    desk: u32,
    up: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct PileSnapshot {
    number: u32,
    boot: u8,
    sequence: u8,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct RobotSnapshot {
    boot: u8,
    sequence: u8,
    request: u8,
    waits: bool,
    /// The coordinators that have heard the request.
    heard: [bool; 2],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
struct Envelope {
    pile: usize,
    seat: usize,
    way: Way,
    message: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
enum Way {
    /// Sealed for one start of the pile; Hello is for all.
    ToPile {
        boot: Option<u8>,
    },
    ToCoordinator {
        boot: u8,
        sequence: u8,
    },
}

/// One thing that happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Time passes; the robots are heard, or not.
    Tick {
        robots_are_heard: bool,
    },
    /// Something sent arrives.
    Arrive(usize),
    /// A robot asks a coordinator for a charge.
    Ask {
        robot: usize,
        seat: usize,
    },
    /// A robot that waits claims a pile.
    Claim {
        robot: usize,
        pile: usize,
    },
    /// A robot goes back to work.
    Quit {
        robot: usize,
    },
    RobotRestarts {
        robot: usize,
    },
    /// The robot of the lease is on the contacts.
    Dock {
        pile: usize,
    },
    Undock {
        pile: usize,
    },
    PileRestarts {
        pile: usize,
    },
    Crash {
        seat: usize,
    },
    Start {
        seat: usize,
    },
}

pub struct World {
    pub rule: Rule,
    pub firmware: Firmware,
    /// Crashes of coordinators, restarts of piles, restarts of robots: so many of each.
    crashes: [u8; 3],
    tables: Mutex<Tables>,
}

/// A pile by its number, when, whether its clock is late, and what happens to it.
type PileStep = (u32, u8, bool, pile::Input);

/// Everything that was met so far, by number.
struct Tables {
    office: Office,
    piles: Interner<String, Pile>,
    messages: Interner<String, Message>,
    pile_steps: HashMap<PileStep, (u32, Vec<u32>)>,
}

impl World {
    pub fn new(rule: Rule, firmware: Firmware, crashes: [u8; 3]) -> Self {
        let tables = Tables {
            office: Office::new(),
            piles: Interner::default(),
            messages: Interner::default(),
            pile_steps: HashMap::new(),
        };
        Self { rule, firmware, crashes, tables: Mutex::new(tables) }
    }

    /// Whether all coordinators, or their logs, are so.
    pub fn each_desk(&self, of: &Snapshot, is: impl Fn(&Desk) -> bool) -> bool {
        let tables = self.tables.lock().unwrap();
        of.seats.iter().all(|seat| is(tables.office.desk(seat.desk)))
    }

    /// Whether all coordinators that are up are so.
    pub fn each_at_work(&self, of: &Snapshot, is: impl Fn(&Desk) -> bool) -> bool {
        let tables = self.tables.lock().unwrap();
        of.seats.iter().all(|seat| !seat.up || is(tables.office.desk(seat.desk)))
    }

    /// Whether all piles are so.
    pub fn each_pile(&self, of: &Snapshot, is: impl Fn(&Pile) -> bool) -> bool {
        let tables = self.tables.lock().unwrap();
        of.piles.iter().all(|pile| is(tables.piles.get(pile.number)))
    }

    /// Whether each pile and each log are so together.
    pub fn each_pile_and_desk(&self, of: &Snapshot, is: impl Fn(PileId, &Pile, &Desk) -> bool) -> bool {
        let tables = self.tables.lock().unwrap();
        PILES.iter().zip(&of.piles).all(|(id, pile)| {
            let pile = tables.piles.get(pile.number);
            of.seats.iter().all(|seat| is(*id, pile, tables.office.desk(seat.desk)))
        })
    }

    fn begin(&self, late: bool) -> Snapshot {
        let tables = &mut *self.tables.lock().unwrap();
        let number = tables.pile_number(Pile::new());
        let seats = if self.rule == Rule::Rivals { 2 } else { 1 };
        let mut snapshot = Snapshot {
            ticks: 0,
            late,
            seats: vec![Seat { desk: Office::NOBODY, up: false }; seats],
            piles: [PileSnapshot { number, boot: 1, sequence: 0 }; 2],
            robots: [RobotSnapshot { boot: 1, sequence: 0, request: 0, waits: false, heard: [false; 2] }; 2],
            network: Vec::new(),
            crashes: self.crashes,
            claims: if self.rule == Rule::Claims { CLAIMS } else { 0 },
        };
        // The coordinators are up and have heard both piles; who comes second has the log of the first start.
        let mut turn = Turn { firmware: self.firmware, tables, of: &mut snapshot };
        for seat in 0..seats {
            turn.of.seats[seat].desk = turn.of.seats[0].desk;
            turn.coordinate(seat, Hear::Start);
        }
        for pile in 0..PILES.len() {
            turn.pile(pile, pile::Input::Tick, 0);
        }
        for envelope in std::mem::take(&mut turn.of.network) {
            turn.deliver(envelope);
        }
        snapshot
    }
}

impl Snapshot {
    /// The site's time.
    pub fn now(&self) -> SiteMillis {
        START.after(DurationMs(TICK.0 * u32::from(self.ticks)))
    }

    /// The site's time as the piles have it.
    pub fn piles_now(&self) -> SiteMillis {
        SiteMillis(self.now().0 - u64::from(self.lateness().0))
    }

    fn lateness(&self) -> DurationMs {
        if self.late { MARGIN } else { DurationMs(0) }
    }
}

impl Tables {
    fn pile_number(&mut self, pile: Pile) -> u32 {
        self.piles.number(pile.canonical(), || pile)
    }

    fn message_number(&mut self, message: Message) -> u32 {
        self.messages.number(format!("{message:?}"), || message)
    }
}

/// A step of the world in the making.
struct Turn<'a> {
    firmware: Firmware,
    tables: &'a mut Tables,
    of: &'a mut Snapshot,
}

impl Turn<'_> {
    fn take(&mut self, action: Action) {
        match action {
            Action::Tick { robots_are_heard } => self.tick(robots_are_heard),
            Action::Arrive(at) => self.deliver(self.of.network[at]),
            Action::Ask { robot, seat } => {
                let asker = &mut self.of.robots[robot];
                if !asker.waits {
                    *asker = RobotSnapshot {
                        request: asker.request + 1,
                        waits: true,
                        heard: [false; 2],
                        ..*asker
                    };
                }
                asker.heard[seat] = true;
                let asks = Some(asker.request);
                self.say(robot, seat, asks);
            }
            Action::Claim { robot, pile } => {
                self.of.claims -= 1;
                self.pile(pile, pile::Input::Claimed(ROBOTS[robot]), 0);
            }
            Action::Quit { robot } => {
                self.of.robots[robot].waits = false;
                (0..self.of.seats.len()).for_each(|seat| self.say(robot, seat, None));
            }
            Action::RobotRestarts { robot } => {
                self.of.crashes[2] -= 1;
                let old = self.of.robots[robot];
                self.of.robots[robot] = RobotSnapshot {
                    boot: old.boot + 1,
                    sequence: 0,
                    request: 0,
                    waits: false,
                    heard: [false; 2],
                };
            }
            Action::Dock { pile } => self.pile(pile, pile::Input::Arrives, 0),
            Action::Undock { pile } => self.pile(pile, pile::Input::Leaves, 0),
            Action::PileRestarts { pile } => {
                self.of.crashes[1] -= 1;
                let old = self.of.piles[pile];
                self.of.piles[pile] = PileSnapshot { boot: old.boot + 1, sequence: 0, ..old };
                self.pile(pile, pile::Input::Restart, 0);
            }
            Action::Crash { seat } => {
                self.of.crashes[0] -= 1;
                self.of.seats[seat].up = false;
            }
            Action::Start { seat } => {
                self.coordinate(seat, Hear::Start);
                self.of.robots.iter_mut().for_each(|robot| robot.heard[seat] = false);
            }
        }
    }

    fn tick(&mut self, robots_are_heard: bool) {
        self.of.ticks += 1;
        (0..PILES.len()).for_each(|pile| self.pile(pile, pile::Input::Tick, 0));
        for seat in 0..self.of.seats.len() {
            for robot in 0..ROBOTS.len() {
                if robots_are_heard && self.of.robots[robot].heard[seat] {
                    self.say(robot, seat, None);
                }
            }
            self.coordinate(seat, Hear::Tick);
        }
    }

    /// A robot is heard by a coordinator.
    fn say(&mut self, robot: usize, seat: usize, asks: Option<u8>) {
        if !self.of.seats[seat].up {
            return;
        }
        let speaker = &mut self.of.robots[robot];
        speaker.sequence += 1;
        let RobotSnapshot { boot, sequence, waits, .. } = *speaker;
        self.coordinate(seat, Hear::Robot { robot: ROBOTS[robot], boot, sequence, asks, waits });
    }

    fn deliver(&mut self, envelope: Envelope) {
        let Envelope { pile, seat, way, message } = envelope;
        match way {
            Way::ToPile { boot } => {
                let is_bound = self.firmware != Firmware::BelievesFramesForOtherStarts;
                if !is_bound || boot.is_none_or(|boot| boot == self.of.piles[pile].boot) {
                    self.pile(pile, pile::Input::Hear(message), seat);
                }
            }
            Way::ToCoordinator { boot, sequence } => {
                self.coordinate(seat, Hear::Pile { pile: PILES[pile], boot, sequence, message });
            }
        }
    }

    fn coordinate(&mut self, seat: usize, hear: Hear) {
        let Seat { desk, up } = self.of.seats[seat];
        if !up && hear != Hear::Start {
            return;
        }
        let message = match hear {
            Hear::Pile { message, .. } => Some(self.tables.messages.get(message)),
            _ => None,
        };
        let (next, said) = self.tables.office.step(desk, self.of.now(), hear, message);
        self.of.seats[seat] = Seat { desk: next, up: true };
        for (to, message) in said {
            let pile = PILES.iter().position(|pile| *pile == to).expect("a pile of the site");
            let boot = self.tables.office.desk(next).heard[pile].map(|(boot, _)| boot);
            let boot = boot.filter(|_| !matches!(message, Message::Hello(_)));
            let message = self.tables.message_number(message);
            self.post(Envelope { pile, seat, way: Way::ToPile { boot }, message });
        }
    }

    /// A pile's answer to a command goes to who gave it: a frame is sealed for one start of one coordinator.
    /// What it says of itself, all hear.
    fn pile(&mut self, pile: usize, input: pile::Input, answered: usize) {
        let number = self.of.piles[pile].number;
        let key = (number, self.of.ticks, self.of.late, input);
        let (next, said) = match self.tables.pile_steps.get(&key) {
            Some(known) => known.clone(),
            None => {
                let mut stepped = self.tables.piles.get(number).clone();
                let heard = match input {
                    pile::Input::Hear(message) => Some(self.tables.messages.get(message)),
                    _ => None,
                };
                let said = stepped.step(self.firmware, (self.of.now(), self.of.lateness()), input, heard);
                let said: Vec<_> = said.into_iter().map(|said| self.tables.message_number(said)).collect();
                let result = (self.tables.pile_number(stepped), said);
                self.tables.pile_steps.insert(key, result.clone());
                result
            }
        };
        self.of.piles[pile].number = next;
        for message in said {
            let speaker = &mut self.of.piles[pile];
            speaker.sequence += 1;
            let way = Way::ToCoordinator { boot: speaker.boot, sequence: speaker.sequence };
            let is_answer = matches!(self.tables.messages.get(message), Message::Ack(_) | Message::Nack(_));
            for seat in 0..self.of.seats.len() {
                if !is_answer || seat == answered {
                    self.post(Envelope { pile, seat, way, message });
                }
            }
        }
    }

    fn post(&mut self, envelope: Envelope) {
        if let Err(at) = self.of.network.binary_search(&envelope) {
            self.of.network.insert(at, envelope);
        }
    }
}

impl Model for World {
    type State = Snapshot;
    type Action = Action;

    fn init_states(&self) -> Vec<Snapshot> {
        vec![self.begin(false), self.begin(true)]
    }

    fn actions(&self, of: &Snapshot, actions: &mut Vec<Action>) {
        let up = |seat: usize| of.seats.get(seat).is_some_and(|seat| seat.up);
        actions.extend([true, false].map(|robots_are_heard| Action::Tick { robots_are_heard }));
        actions.extend((0..of.network.len()).map(Action::Arrive));
        for (robot, now) in of.robots.iter().enumerate() {
            let asks = (0..2).filter(|seat| up(*seat) && !(now.waits && now.heard[*seat]));
            actions.extend(asks.map(|seat| Action::Ask { robot, seat }));
            actions.extend(now.waits.then_some(Action::Quit { robot }));
            let claims = (0..PILES.len()).filter(|_| now.waits && of.claims > 0);
            actions.extend(claims.map(|pile| Action::Claim { robot, pile }));
            actions.extend((now.waits && of.crashes[2] > 0).then_some(Action::RobotRestarts { robot }));
        }
        let tables = self.tables.lock().unwrap();
        for (pile, now) in of.piles.iter().enumerate() {
            if let Some(lease) = tables.piles.get(now.number).leases.current() {
                actions.push(match lease.charge {
                    None => Action::Dock { pile },
                    Some(_) => Action::Undock { pile },
                });
            }
            actions.extend((of.crashes[1] > 0).then_some(Action::PileRestarts { pile }));
        }
        for (seat, now) in of.seats.iter().enumerate() {
            if !now.up {
                actions.push(Action::Start { seat });
            } else if of.crashes[0] > 0 {
                actions.push(Action::Crash { seat });
            }
        }
    }

    fn next_state(&self, last: &Snapshot, action: Action) -> Option<Snapshot> {
        let mut next = last.clone();
        let tables = &mut *self.tables.lock().unwrap();
        Turn { firmware: self.firmware, tables, of: &mut next }.take(action);
        (next != *last).then_some(next)
    }

    fn properties(&self) -> Vec<Property<Self>> {
        rules::properties(self.rule)
    }
}
