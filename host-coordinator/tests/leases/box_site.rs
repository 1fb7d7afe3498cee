//! A whole site in memory: the real coordinator core, the real pile cores with their stores, simple
//! robots, and a bad line between them, all frames sealed. All of it follows from a seed.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

use firmware_pile::{Input as PileInput, TagRead, To, plant::Battery};
use host_coordinator::{
    config::{Policy, RobotConfig},
    core::{
        Coordinator, Effect, Event, Input, State, Step,
        state::{Phase, Place},
    },
    site::Site,
};
use planning::grid::Cell;
use protocol::{
    BootEpoch, DeviceId, DurationMs, EnergyJ, Frame, FrameError, LeaseId, Message, PileId, Recipient,
    RequestId, RobotId, Session, Sessions, SiteMillis, TagId, Trust, limits,
};

use crate::bad_line::{self as line, BadLine};
use crate::board::Board;
use crate::random::Random;
use crate::robot::{Mode, Robot};
use crate::secrets::{SITE_KEY, identity, key, robot_sessions, sealed};

const STEP_MS: u64 = 100;
const FULL_J: f32 = 20_000.0;
pub const POWER_W: f32 = 400.0;
const PER_METRE_J: f32 = 20.0;

/// What goes wrong, each in a thousandth of the occasions.
#[derive(Clone, Copy, Debug, Default)]
pub struct Trouble {
    /// On the way.
    pub line: line::Trouble,
    /// Coordinator crashes, in each step.
    pub crash: u64,
    /// Pile restarts, in each step.
    pub pile_restart: u64,
    /// Robots that change their mind, in each step.
    pub abandon: u64,
}

/// The site.
pub struct BoxSite {
    pub seed: u64,
    pub now: u64,
    pub trouble: Trouble,
    pub coordinator: Coordinator,
    pub log: Vec<Event>,
    pub crashes: u32,
    site: Arc<Site>,
    policy: Policy,
    sessions: Sessions<Vec<Session>>,
    /// Events that have been through a restart.
    replayed: usize,
    pub piles: BTreeMap<PileId, Board>,
    robots: BTreeMap<RobotId, Robot>,
    pub line: BadLine,
    pub random: Random,
    /// No robot asks any more.
    pub closing: bool,
    pub pile_restarts: u32,
    /// Times that a robot has docked.
    pub visits: u64,
    /// Under which leases current has flowed.
    pub flowed: BTreeSet<(PileId, LeaseId)>,
}

impl BoxSite {
    pub fn new(seed: u64, robots: u16, piles: usize) -> Self {
        Self::with_power_cap(seed, robots, piles, None)
    }

    /// All piles together may take no more than `power_cap_w` watts.
    pub fn with_power_cap(seed: u64, robots: u16, piles: usize, power_cap_w: Option<f64>) -> Self {
        let mut site = Site::fig7().unwrap();
        site.piles.truncate(piles);
        let site = Arc::new(site);
        let policy = Policy { lease: DurationMs(20_000), power_cap_w, ..Policy::default() };
        let mut random = Random::new(seed);
        let is_pile = |cell: &Cell| site.piles.iter().any(|pile| pile.cell == *cell);
        let free: Vec<_> = site.grid.free_cells().filter(|cell| !is_pile(cell)).collect();
        let robots: BTreeMap<_, _> = (1..=robots)
            .map(|number| {
                let id = RobotId(number);
                let [low, high] = number.to_le_bytes();
                let tag = TagId([low, high, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1]);
                let full = EnergyJ::clamped(FULL_J);
                let cell = free[random.below(free.len() as u64) as usize];
                let robot = Robot {
                    config: RobotConfig {
                        id,
                        tag,
                        full,
                        energy_per_metre_j: PER_METRE_J,
                        speed_mps: 0.8,
                        gives_w: None,
                    },
                    sessions: robot_sessions(id),
                    greeted: false,
                    mode: Mode::Working,
                    energy: FULL_J * (0.3 + random.below(60) as f32 / 100.0),
                    position: site.position(cell),
                    home: site.position(cell),
                    request: RequestId(0),
                    parts: BTreeMap::new(),
                    say_at: random.below(1000),
                };
                (id, robot)
            })
            .collect();
        let now = 1_000_000;
        let piles = site
            .piles
            .iter()
            .map(|pile| (pile.id, Board::new(identity(pile.id), site.position(pile.cell), now)))
            .collect();
        let configs: Vec<_> = robots.values().map(|robot| robot.config).collect();
        let coordinator = Coordinator::recover(Arc::clone(&site), site.lmpp(1.0), policy, &configs, &[]);
        let mut this = Self {
            seed,
            now,
            trouble: Trouble::default(),
            coordinator,
            log: Vec::new(),
            crashes: 0,
            site,
            policy,
            sessions: Sessions::new(DeviceId::Coordinator, BootEpoch(0), Trust::Insecure),
            replayed: 0,
            piles,
            robots,
            line: BadLine::default(),
            random,
            closing: false,
            pile_restarts: 0,
            visits: 0,
            flowed: BTreeSet::new(),
        };
        this.start_coordinator();
        this
    }

    fn start_coordinator(&mut self) {
        let configs: Vec<_> = self.robots.values().map(|robot| robot.config).collect();
        self.coordinator = Coordinator::recover(
            Arc::clone(&self.site),
            self.site.lmpp(1.0),
            self.policy,
            &configs,
            &self.log,
        );
        self.coordinate(Input::Started { boot_floor: BootEpoch(0) });
        let boot = self.coordinator.state().boot;
        let piles = self.piles.keys().map(|id| DeviceId::Pile(*id));
        let peers = piles.chain(self.robots.keys().map(|id| DeviceId::Robot(*id)));
        let peers = peers.map(|peer| Session::new(peer, key(peer))).collect();
        let trust = Trust::Keys { site: Some(SITE_KEY), peers };
        self.sessions = Sessions::new(DeviceId::Coordinator, boot, trust);
    }

    /// A crash: everything but the log is lost, and the leases are the same after it.
    pub fn crash(&mut self) {
        self.crashes += 1;
        let before = leases(self.coordinator.state());
        self.log.iter_mut().skip(self.replayed).for_each(|event| *event = through_json(event));
        self.replayed = self.log.len();
        self.line.forget(DeviceId::Coordinator);
        let folded = State::fold(&self.log);
        assert_eq!(folded, *self.coordinator.state(), "seed {}: a replay gives another state", self.seed);
        self.start_coordinator();
        assert_eq!(leases(self.coordinator.state()), before, "seed {}: a restart changed leases", self.seed);
    }

    fn coordinate(&mut self, input: Input) {
        let step = self.coordinator.step(SiteMillis(self.now), input);
        self.log.extend(step.events);
        for effect in step.effects {
            if let Effect::Send { to, message } = effect
                && let Some(bytes) = sealed(&mut self.sessions, Recipient::Device(to), &message)
            {
                self.post((DeviceId::Coordinator, to), &bytes);
            }
        }
    }

    /// A frame settles only whom it concerns: at the same instant a tick, which settles everybody, must find
    /// nothing that was forgotten.
    fn nothing_is_left_to_do(&mut self) {
        let more = self.coordinator.step(SiteMillis(self.now), Input::Tick);
        assert_eq!(more, Step::default(), "seed {}: a frame left something undone", self.seed);
    }

    fn post(&mut self, route: (DeviceId, DeviceId), bytes: &[u8]) {
        self.line.post(self.now, self.trouble.line, &mut self.random, route, bytes);
    }

    /// Runs for a time, checking everything at every step.
    pub fn run(&mut self, duration_ms: u64) {
        let end = self.now + duration_ms;
        while self.now < end {
            self.now += STEP_MS;
            self.coordinate(Input::Tick);
            self.deliver();
            if self.random.chance(self.trouble.crash) {
                self.crash();
            }
            self.step_piles();
            self.step_robots();
            self.check();
        }
    }

    fn opened(&mut self, route: (DeviceId, DeviceId), bytes: &[u8]) -> Vec<Result<Frame, FrameError>> {
        match route.1 {
            DeviceId::Coordinator => self.line.open(route, &mut self.sessions, bytes),
            DeviceId::Pile(pile) => {
                self.line.open(route, &mut self.piles.get_mut(&pile).unwrap().sessions, bytes)
            }
            DeviceId::Robot(robot) => {
                self.line.open(route, &mut self.robots.get_mut(&robot).unwrap().sessions, bytes)
            }
            stranger => panic!("the coordinator talks to {stranger}"),
        }
    }

    fn deliver(&mut self) {
        while let Some((route, bytes)) = self.line.arrived(self.now) {
            for found in self.opened(route, &bytes) {
                match (route.1, found) {
                    (DeviceId::Coordinator, Ok(frame)) => {
                        self.coordinate(Input::Frame(frame));
                        self.nothing_is_left_to_do();
                    }
                    (DeviceId::Coordinator, Err(FrameError::Unauthentic { sender })) => {
                        self.coordinate(Input::Distrusted(sender));
                        self.nothing_is_left_to_do();
                    }
                    (DeviceId::Pile(pile), Ok(frame)) => self.step_pile(pile, PileInput::Frame(&frame)),
                    (DeviceId::Pile(pile), Err(error)) => self.step_pile(pile, PileInput::Discarded(error)),
                    (DeviceId::Robot(robot), Ok(frame)) => self.robot_hears(robot, &frame),
                    (DeviceId::Robot(robot), Err(FrameError::Unauthentic { .. })) => {
                        self.robots.get_mut(&robot).unwrap().greeted = false;
                    }
                    // Late, or repeated by the network.
                    (_, Err(FrameError::Replayed { .. } | FrameError::EarlierStart { .. })) => {}
                    (_, Err(FrameError::Crc | FrameError::Garbled | FrameError::Oversize))
                        if self.line.figures.damaged > 0 => {}
                    (to, found) => panic!("seed {}: {to} got {found:?}", self.seed),
                }
            }
        }
    }

    /// A pile's power goes and comes.
    pub fn restart_pile(&mut self, id: PileId) {
        self.pile_restarts += 1;
        self.line.forget(DeviceId::Pile(id));
        self.piles.get_mut(&id).unwrap().restart(self.now);
    }

    fn step_piles(&mut self) {
        let ids: Vec<_> = self.piles.keys().copied().collect();
        for id in ids {
            if self.random.chance(self.trouble.pile_restart) || self.piles[&id].is_dead() {
                self.restart_pile(id);
            }
            let docked = self.docked(id).map(|robot| robot.config.tag);
            let read = docked.map(|tag| TagRead { tag, rssi_dbm: -45 });
            self.step_pile(id, read.map_or(PileInput::ReaderIdle, PileInput::Tag));
            let pile = self.piles.get_mut(&id).unwrap();
            pile.plant.battery = docked.map(|_| Battery::new(FULL_J, 0.5 * FULL_J));
            let sensors = pile.sense(self.now);
            self.step_pile(id, PileInput::Sensors(sensors));
            self.check_live(id);
        }
    }

    fn docked(&self, id: PileId) -> Option<&Robot> {
        self.robots.values().find(|robot| matches!(robot.mode, Mode::Docked { pile, .. } if pile == id))
    }

    /// Current is given under a lease only, and to nobody but its holder. A robot that has just left
    /// is still believed for the reader's timeout.
    fn check_live(&mut self, id: PileId) {
        let Board { core, plant, .. } = &self.piles[&id];
        let flows = plant.current_a() > 0.0;
        if plant.power().current_limit_a > 0.0 {
            let holder = core.leases().current().map(|lease| lease.name.robot);
            let docked = self.docked(id).map(|robot| robot.config.id);
            assert!(holder.is_some(), "seed {}: pile {id} is live without a lease", self.seed);
            assert!(
                docked.is_none() || docked == holder,
                "seed {}: pile {id} charges {docked:?} for {holder:?}",
                self.seed
            );
            if flows && let Some(lease) = core.leases().current() {
                self.flowed.insert((id, lease.name.lease));
            }
        }
    }

    fn step_pile(&mut self, id: PileId, input: PileInput<'_>) {
        let pile = self.piles.get_mut(&id).unwrap();
        let mut post = Vec::new();
        for outgoing in pile.step(self.now, input) {
            if outgoing.to == To::Coordinator {
                post.extend(sealed(&mut pile.sessions, outgoing.to.into(), &outgoing.message));
            }
        }
        let route = (DeviceId::Pile(id), DeviceId::Coordinator);
        post.into_iter().for_each(|bytes| self.post(route, &bytes));
    }

    fn robot_hears(&mut self, id: RobotId, frame: &Frame) {
        let Some(robot) = self.robots.get_mut(&id) else { return };
        match &frame.message {
            Message::Hello(_) => robot.greeted = true,
            Message::Unassigned(answer) if answer.request == robot.request => {
                if let Mode::Approaching { .. } = robot.mode {
                    robot.mode = Mode::Waiting;
                    robot.parts.clear();
                    robot.say_at = self.now;
                }
            }
            Message::Assignment(part) if part.request == robot.request && robot.mode == Mode::Waiting => {
                robot.take(part, self.now);
            }
            _ => {}
        }
    }

    fn step_robots(&mut self) {
        let ids: Vec<_> = self.robots.keys().copied().collect();
        for id in ids {
            let abandons = self.random.chance(self.trouble.abandon);
            let wants = self.random.chance(5) && !self.closing;
            let (now, robot) = (self.now, self.robots.get_mut(&id).unwrap());
            let before = robot.mode;
            match robot.mode {
                Mode::Working => {
                    robot.energy = (robot.energy - 3.0).max(0.2 * FULL_J);
                    if wants && robot.energy < 0.7 * FULL_J {
                        robot.request.0 += 1;
                        robot.parts.clear();
                        robot.mode = Mode::Waiting;
                    }
                }
                Mode::Waiting | Mode::Approaching { .. } if abandons => robot.mode = Mode::Working,
                Mode::Waiting => {}
                Mode::Approaching { pile, arrival } => {
                    // Only one robot fits.
                    let taken = self
                        .robots
                        .values()
                        .any(|other| matches!(other.mode, Mode::Docked { pile: at, .. } if at == pile));
                    let robot = self.robots.get_mut(&id).unwrap();
                    if now >= arrival && !taken {
                        robot.position = self.piles[&pile].position;
                        robot.mode = Mode::Docked { pile, since: now, live_at: None };
                        self.visits += 1;
                    }
                }
                Mode::Docked { pile, since, live_at } => {
                    let live = self.piles[&pile].core.energised();
                    let live_at = if live { Some(now) } else { live_at };
                    if live {
                        robot.energy = (robot.energy + POWER_W * STEP_MS as f32 / 1000.0).min(FULL_J);
                    }
                    let over = live_at.is_some_and(|at| now >= at + 2_000)
                        || (live_at.is_none() && now >= since + 60_000);
                    robot.mode = Mode::Docked { pile, since, live_at };
                    if over {
                        (robot.mode, robot.position) = (Mode::Working, robot.home);
                    }
                }
            }
            let robot = self.robots.get_mut(&id).unwrap();
            let changed = std::mem::discriminant(&before) != std::mem::discriminant(&robot.mode);
            let mut bytes = Vec::new();
            if changed || now >= robot.say_at {
                robot.say_at = now + u64::from(limits::STATE_INTERVAL.0);
                for message in robot.talk() {
                    let to = Recipient::Device(DeviceId::Coordinator);
                    bytes.extend(sealed(&mut robot.sessions, to, &message));
                }
            }
            let route = (DeviceId::Robot(id), DeviceId::Coordinator);
            bytes.into_iter().for_each(|bytes| self.post(route, &bytes));
        }
    }

    /// The last events about a pile, newest first.
    fn story_of(&self, pile: PileId) -> String {
        let about = format!("{pile:?}");
        let told = self.log.iter().rev().map(|event| format!("\n  {event:?}"));
        told.filter(|event| event.contains(&about) || event.contains("EpochStarted")).take(16).collect()
    }

    /// What must hold at every instant.
    fn check(&self) {
        let state = self.coordinator.state();
        let mut served = BTreeSet::new();
        for (id, pile) in &self.piles {
            let recorded = state.lease(*id).filter(|lease| lease.is_wanted());
            let held = pile.core.leases().current();
            if let (Some(recorded), Some(held)) = (recorded, held) {
                assert_eq!(
                    recorded.name.lease,
                    held.name.lease,
                    "seed {}, {} ms: two holders of pile {id}: {recorded:?} and {held:?}, after{}",
                    self.seed,
                    self.now,
                    self.story_of(*id)
                );
            }
            if let Some(lease) = recorded {
                assert!(
                    served.insert(lease.name.robot),
                    "seed {}: robot {} has two piles",
                    self.seed,
                    lease.name.robot
                );
            }
        }
        for (robot, request) in &state.requests {
            let kept = match request.place {
                Place::Waiting => true,
                Place::Next(pile) => state.next(pile) == Some(*robot),
                Place::Granted(pile) => state.lease(pile).is_some_and(|lease| lease.name.robot == *robot),
            };
            assert!(
                kept,
                "seed {}: robot {robot} is at {:?}, which does not know it",
                self.seed, request.place
            );
        }
    }

    /// Whether every robot that waits is known to wait or to have been granted a pile.
    pub fn every_asker_is_in_the_book(&self) -> bool {
        self.robots.values().filter(|robot| robot.mode == Mode::Waiting).all(|robot| {
            let request = self.coordinator.state().requests.get(&robot.config.id);
            request.is_some_and(|request| request.id == robot.request)
        })
    }
}

/// The leases of all piles, by what a restart must keep.
pub fn leases(state: &State) -> BTreeMap<PileId, (u32, RobotId, bool)> {
    let row = |(pile, record): (&PileId, &host_coordinator::core::state::PileRecord)| {
        let lease = record.lease?;
        let held = matches!(lease.phase, Phase::Held { .. });
        Some((*pile, (lease.name.lease.0, lease.name.robot, held)))
    };
    state.piles.iter().filter_map(row).collect()
}

fn through_json(event: &Event) -> Event {
    let json = serde_json::to_string(&event.fact).unwrap();
    Event { at: event.at, fact: serde_json::from_str(&json).unwrap() }
}
