//! A run: from one event to the next.

use protocol::{DeviceId, DurationMs, Header, Message, Millis, PileId, RobotId, Sequence};

use super::{
    Ground, Trial,
    agenda::Agenda,
    breach::Breach,
    faults::{Fault, Troubles},
    network::{Letter, Network, Node, Opened},
    office::Office,
    outcome::{Failure, Outcome, Tally},
    piles::Pile,
    rovers::Rover,
};
use crate::simulate::random::Random;

/// How often the coordinator is told that time has passed: as often as the daemon does.
const TICK: DurationMs = DurationMs(200);
/// How often the state is compared with the fold of the log.
const REVIEW: DurationMs = DurationMs(60_000);
/// How long devices and the coordinator don't hear each other, in seconds: from, to.
const CUT_S: (f64, f64) = (5.0, 60.0);
/// Devices are switched on within this.
const MORNING_MS: f64 = 1_000.0;

/// Something to happen. What carries a turn happens only if nothing else was planned since.
#[derive(Clone, Copy, Debug)]
pub(super) enum Occasion {
    Arrives(usize),
    RobotWakes {
        robot: usize,
        turn: u32,
    },
    PileWakes {
        pile: usize,
        turn: u32,
    },
    /// Somebody comes to tow a robot.
    Tows(RobotId),
    /// A robot comes near a pile, if it still has the route it had.
    Nears {
        robot: usize,
        pile: usize,
        route: u32,
    },
    Tick,
    Review,
    Strikes(Fault),
    PileStarts(usize),
    RobotStarts(usize),
    OfficeStarts,
}

/// Everything there is in a run.
#[derive(Debug)]
pub(super) struct Run<'a> {
    pub ground: &'a Ground,
    pub trial: &'a Trial,
    pub now: Millis,
    pub agenda: Agenda<Occasion>,
    pub network: Network,
    pub troubles: Troubles,
    pub office: Office,
    pub piles: Vec<Pile>,
    /// Robots, then mobile chargers.
    pub rovers: Vec<Rover>,
    /// How many of them are robots.
    pub robots: usize,
    /// Those who tow robots.
    pub people: Random,
    pub tally: Tally,
    pub breach: Option<Breach>,
    /// Until when each device is cut off.
    cut_until: Vec<Millis>,
}

impl<'a> Run<'a> {
    /// The beginning of `trial`: everyone is switched on within a second.
    pub fn new(ground: &'a Ground, trial: &'a Trial) -> Self {
        let robots = usize::from(trial.robots.min(ground.robots));
        let all = robots + usize::from(ground.chargers);
        let piles = ground.piles.len();
        let mut random = Random::new(trial.seed, 0x3_0000);
        let mut run = Self {
            ground,
            trial,
            now: Millis(0),
            agenda: Agenda::default(),
            network: Network::new(trial.seed, piles, all),
            troubles: Troubles::new(trial.seed, trial.faults, trial.only.clone()),
            office: Office::new(ground, all, &mut random),
            piles: ground.piles.iter().map(|&(id, power_w, _)| Pile::new(id, power_w)).collect(),
            rovers: (0..all).map(|index| Rover::new(ground, trial.seed, index, robots)).collect(),
            robots,
            people: Random::new(trial.seed, 0x4_0000),
            tally: Tally::default(),
            breach: None,
            cut_until: vec![Millis(0); piles + all],
        };
        run.agenda.put(Millis(0), Occasion::OfficeStarts);
        let mut morning = || Millis(random.between(0.0, MORNING_MS) as u64);
        for pile in 0..piles {
            run.agenda.put(morning(), Occasion::PileStarts(pile));
        }
        for robot in 0..all {
            run.agenda.put(morning(), Occasion::RobotStarts(robot));
        }
        run.agenda.put(Millis(0).after(TICK), Occasion::Tick);
        run.agenda.put(Millis(0).after(REVIEW), Occasion::Review);
        Fault::ALL.into_iter().for_each(|fault| run.plan(fault));
        run
    }

    /// Lets everything happen, up to the end or the first broken promise.
    pub fn outcome(mut self) -> Outcome {
        self.run_until(Millis(self.trial.duration.0.into()));
        if self.breach.is_none() {
            self.review();
        }
        self.finish()
    }

    /// Lets happen what is due before `end`.
    pub fn run_until(&mut self, end: Millis) {
        while self.breach.is_none()
            && let Some((now, occasion)) = self.agenda.take()
        {
            if now >= end {
                self.agenda.put(now, occasion);
                break;
            }
            self.now = now;
            self.happen(occasion);
        }
    }

    fn finish(mut self) -> Outcome {
        (0..self.rovers.len()).for_each(|robot| self.sum_up(robot));
        self.count_open_waits();
        let mut tally = self.tally;
        tally.robots_ms = self.robots as u64 * self.now.0;
        tally.counts.preempted = self.office.preempted();
        let failure = self.breach.map(|breach| {
            match &breach {
                Breach::DoubleGrant(_) => tally.counts.double_grants += 1,
                Breach::Forgotten { .. } | Breach::Unhelped { .. } => tally.counts.lost_requests += 1,
                _ => {}
            }
            Failure { at: self.now, breach, struck: self.troubles.struck() }
        });
        Outcome { seed: self.trial.seed, tally, failure }
    }

    fn happen(&mut self, occasion: Occasion) {
        match occasion {
            Occasion::Arrives(number) => self.arrive(number),
            Occasion::RobotWakes { robot, turn } => self.robot_wakes(robot, turn),
            Occasion::PileWakes { pile, turn } => self.pile_wakes(pile, turn),
            Occasion::Tows(robot) => self.tow(robot),
            Occasion::Nears { robot, pile, route } => self.robot_nears(robot, pile, route),
            Occasion::Tick => {
                self.agenda.put(self.now.after(TICK), Occasion::Tick);
                self.tick();
            }
            Occasion::Review => {
                self.agenda.put(self.now.after(REVIEW), Occasion::Review);
                self.review();
            }
            Occasion::Strikes(fault) => {
                self.plan(fault);
                if self.troubles.happens() {
                    self.strike(fault);
                }
            }
            Occasion::PileStarts(pile) => self.start_pile(pile),
            Occasion::RobotStarts(robot) => self.start_robot(robot),
            Occasion::OfficeStarts => self.start_office(),
        }
    }

    /// Puts down when a fault strikes the next time.
    fn plan(&mut self, fault: Fault) {
        if let Some(wait) = self.troubles.next(fault, self.piles.len(), self.rovers.len()) {
            self.agenda.put(self.now.after(wait), Occasion::Strikes(fault));
        }
    }

    fn strike(&mut self, fault: Fault) {
        match fault {
            Fault::Partition => self.cut_off(),
            Fault::PileCrash => self.doom_pile(),
            Fault::RobotCrash => self.crash_robot(),
            Fault::CoordinatorCrash => self.doom_office(),
            Fault::Outage => self.stop_office_for_long(),
            Fault::Clock => self.step_clock(),
            // They strike frames.
            Fault::Loss | Fault::Delay | Fault::Duplicate | Fault::Reorder => {}
        }
    }

    /// Cuts off one device, half of them, or all.
    fn cut_off(&mut self) {
        let chance = self.troubles.chance(Fault::Partition);
        let until = self.now.after(DurationMs::from_seconds(chance.between(CUT_S.0, CUT_S.1) as f32));
        let share = chance.choose(&[0.0, 0.5, 1.0]).copied().unwrap_or(0.0);
        let one = chance.between(0.0, self.cut_until.len() as f64) as usize;
        for (device, cut) in self.cut_until.iter_mut().enumerate() {
            if device == one || chance.between(0.0, 1.0) < share {
                *cut = until;
            }
        }
    }

    /// Whether a device and the coordinator hear each other.
    pub fn is_connected(&self, node: Node) -> bool {
        let cut_until = self.network.device(node).and_then(|device| self.cut_until.get(device));
        cut_until.is_none_or(|cut| self.now >= *cut)
    }

    /// Sends a message from a device to the coordinator or back.
    pub fn send(&mut self, from: Node, to: Node, message: Message) {
        let letter = match (from, to) {
            (Node::Office, Node::Pile(pile)) => {
                let sender = (DeviceId::Coordinator, self.office.boot());
                self.office.piles[pile].seal((from, to), sender, self.now, message)
            }
            (Node::Office, Node::Robot(robot)) => {
                let sender = (DeviceId::Coordinator, self.office.boot());
                self.office.robots[robot].seal((from, to), sender, self.now, message)
            }
            (Node::Pile(pile), _) => {
                let pile = &mut self.piles[pile];
                pile.session.seal((from, to), (DeviceId::Pile(pile.id), pile.kept.boot), self.now, message)
            }
            (Node::Robot(robot), _) => {
                let rover = &mut self.rovers[robot];
                rover.session.seal((from, to), (DeviceId::Robot(rover.id), rover.boot), self.now, message)
            }
            (Node::Office, Node::Office) => None,
        };
        let Some(letter) = letter else { return };
        let device = if from == Node::Office { to } else { from };
        if self.is_connected(device) {
            self.post(letter);
        }
    }

    /// Sends a message between a pile and a robot, which hear each other whether or not they hear the
    /// coordinator.
    pub fn send_directly(&mut self, from: Node, to: Node, message: Message) {
        let (sender, boot) = match from {
            Node::Pile(pile) => (DeviceId::Pile(self.piles[pile].id), self.piles[pile].kept.boot),
            Node::Robot(robot) => (DeviceId::Robot(self.rovers[robot].id), self.rovers[robot].boot),
            Node::Office => return,
        };
        let header = Header::new(sender, boot, Sequence(0));
        self.post(Letter::of_site((from, to), header, self.now, message));
    }

    fn post(&mut self, letter: Letter) {
        let arrivals = self.network.post(self.now, &mut self.troubles, letter);
        for (at, number) in arrivals.into_iter().flatten() {
            self.agenda.put(at, Occasion::Arrives(number));
        }
    }

    fn arrive(&mut self, number: usize) {
        let Some(letter) = self.network.take(number) else { return };
        match letter.to {
            Node::Office => self.office_hears(letter),
            Node::Pile(pile) => self.pile_hears(pile, &letter),
            Node::Robot(robot) => self.robot_hears(robot, letter),
        }
    }

    fn office_hears(&mut self, letter: Letter) {
        if !self.office.is_up() {
            return;
        }
        let boot = self.office.boot();
        let session = match letter.from {
            Node::Pile(pile) => &mut self.office.piles[pile],
            Node::Robot(robot) => &mut self.office.robots[robot],
            Node::Office => return,
        };
        match session.open(boot, &letter) {
            Opened::Taken => self.office_takes(letter),
            Opened::Stale => {}
            Opened::Unauthentic => self.office_distrusts(letter.frame.header.sender),
        }
    }

    /// Notes a broken promise; the first one counts.
    pub fn note(&mut self, breach: Breach) {
        self.breach.get_or_insert(breach);
    }

    /// The node of a device on the network.
    pub fn node(&self, device: DeviceId) -> Option<Node> {
        match device {
            DeviceId::Pile(pile) => self.pile_index(pile).map(Node::Pile),
            DeviceId::Robot(robot) => self.robot_index(robot).map(Node::Robot),
            DeviceId::Coordinator => Some(Node::Office),
            DeviceId::Chassis(_) | DeviceId::Service | DeviceId::Factory => None,
        }
    }

    fn pile_index(&self, id: PileId) -> Option<usize> {
        self.ground.pile_index(id)
    }

    pub fn robot_index(&self, RobotId(number): RobotId) -> Option<usize> {
        let index = usize::from(number).checked_sub(1)?;
        let charger = usize::from(number.checked_sub(self.ground.robots + 1).unwrap_or(u16::MAX));
        let index = if number > self.ground.robots { self.robots + charger } else { index };
        let known = if number > self.ground.robots { self.rovers.len() } else { self.robots };
        (index < known).then_some(index)
    }
}
