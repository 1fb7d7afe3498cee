//! A whole site in memory: the real coordinator core, the real pile cores, simple robots, and a
//! network that loses, repeats, delays and reorders frames, all of them sealed. All but the keys follows
//! from a seed.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

use firmware_pile::{
    ChargingPile, Input as PileInput, Parameters, TagRead, To,
    plant::{Battery, Plant},
    store::Record,
};
use host_coordinator::{
    config::{Policy, RobotConfig},
    core::{
        Coordinator, Effect, Event, Input, State,
        state::{Phase, Place},
    },
    keys::Keys,
    site::Site,
};
use protocol::{
    Activity, Assignment, BootEpoch, ChargeRequest, Deframer, DeviceId, DurationMs, EnergyJ, Epoch, Frame,
    FrameError, Hello, Message, Millis, PileId, Position, Recipient, RequestId, RobotId, RobotState,
    SealError, Session, Sessions, SiteMillis, TagId, limits,
};

const STEP_MS: u64 = 100;
const FULL_J: f32 = 20_000.0;
const POWER_W: f32 = 400.0;
const SPEED_MPS: f64 = 2.0;
const PER_METRE_J: f32 = 20.0;

/// Random numbers from a seed (SplitMix64).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, end: u64) -> u64 {
        self.next() % end
    }

    pub fn chance(&mut self, per_mille: u64) -> bool {
        self.below(1000) < per_mille
    }
}

/// What goes wrong, each in a thousandth of the occasions.
#[derive(Clone, Copy, Debug, Default)]
pub struct Trouble {
    /// Frames lost.
    pub lost: u64,
    /// Frames delivered twice.
    pub repeated: u64,
    /// The longest delay of a frame, in milliseconds.
    pub delay_ms: u64,
    /// Coordinator crashes, in each step.
    pub crash: u64,
    /// Pile restarts, in each step.
    pub pile_restart: u64,
    /// Robots that change their mind, in each step.
    pub abandon: u64,
}

struct Pile {
    core: ChargingPile,
    sessions: Sessions<Vec<Session>>,
    plant: Plant,
    boot: BootEpoch,
    stored_epoch: Epoch,
    started: u64,
    cell_position: Position,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Mode {
    Working,
    Waiting,
    Approaching { pile: PileId, arrival: u64 },
    Docked { pile: PileId, since: u64, live_at: Option<u64> },
}

struct Robot {
    config: RobotConfig,
    greeted: bool,
    sessions: Sessions<Vec<Session>>,
    mode: Mode,
    energy: f32,
    position: Position,
    request: RequestId,
    parts: BTreeMap<u16, Vec<Position>>,
    say_at: u64,
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
    keys: Keys,
    piles: BTreeMap<PileId, Pile>,
    robots: BTreeMap<RobotId, Robot>,
    /// Frames on their way, by arrival.
    wire: BTreeMap<(u64, u64), (DeviceId, Vec<u8>)>,
    sent: u64,
    random: Random,
}

impl BoxSite {
    pub fn new(seed: u64, robots: u16, piles: usize) -> Self {
        let mut site = Site::fig7().unwrap();
        site.piles.truncate(piles);
        let site = Arc::new(site);
        let policy = Policy { lease: DurationMs(20_000), ..Policy::default() };
        let mut random = Random::new(seed);
        let free: Vec<_> = site.grid.free_cells().collect();
        let keys = keys(&site, robots);
        let robots: BTreeMap<_, _> = (1..=robots)
            .map(|number| {
                let id = RobotId(number);
                let [low, high] = number.to_le_bytes();
                let tag = TagId([low, high, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1]);
                let full = EnergyJ::clamped(FULL_J);
                let cell = free[random.below(free.len() as u64) as usize];
                let robot = Robot {
                    config: RobotConfig { id, tag, full, energy_per_metre_j: PER_METRE_J },
                    sessions: sessions(&keys, DeviceId::Robot(id), BootEpoch(1)),
                    greeted: false,
                    mode: Mode::Working,
                    energy: FULL_J * (0.3 + random.below(60) as f32 / 100.0),
                    position: site.position(cell),
                    request: RequestId(0),
                    parts: BTreeMap::new(),
                    say_at: random.below(1000),
                };
                (id, robot)
            })
            .collect();
        let piles = site
            .piles
            .iter()
            .map(|pile| {
                let sessions = sessions(&keys, DeviceId::Pile(pile.id), BootEpoch(1));
                (pile.id, Pile::new(pile.id, sessions, BootEpoch(1), Epoch(0), 0, site.position(pile.cell)))
            })
            .collect();
        let configs: Vec<_> = robots.values().map(|robot| robot.config).collect();
        let coordinator = Coordinator::recover(Arc::clone(&site), policy, &configs, &[]);
        let mut this = Self {
            seed,
            now: 1_000_000,
            trouble: Trouble::default(),
            coordinator,
            log: Vec::new(),
            crashes: 0,
            site,
            policy,
            sessions: keys.sessions(BootEpoch(0)),
            keys,
            piles,
            robots,
            wire: BTreeMap::new(),
            sent: 0,
            random,
        };
        this.start_coordinator();
        this
    }

    fn start_coordinator(&mut self) {
        let configs: Vec<_> = self.robots.values().map(|robot| robot.config).collect();
        self.coordinator = Coordinator::recover(Arc::clone(&self.site), self.policy, &configs, &self.log);
        self.coordinate(Input::Started { boot_floor: BootEpoch(0) });
        let boot = self.coordinator.state().boot;
        self.sessions = self.keys.sessions(boot);
    }

    /// A crash: everything but the log is lost, and the leases are the same after it.
    pub fn crash(&mut self) {
        self.crashes += 1;
        let before = leases(self.coordinator.state());
        self.log = self.log.iter().map(through_json).collect();
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
                self.post(to, bytes);
            }
        }
    }

    fn post(&mut self, to: DeviceId, bytes: Vec<u8>) {
        let copies = if self.random.chance(self.trouble.lost) {
            0
        } else {
            1 + u64::from(self.random.chance(self.trouble.repeated))
        };
        for _ in 0..copies {
            let delay = 1 + self.random.below(self.trouble.delay_ms + 1);
            self.sent += 1;
            self.wire.insert((self.now + delay, self.sent), (to, bytes.clone()));
        }
    }

    /// Runs for a time, checking everything at every step.
    pub fn run(&mut self, duration_ms: u64) {
        let end = self.now + duration_ms;
        while self.now < end {
            self.now += STEP_MS;
            self.deliver();
            if self.random.chance(self.trouble.crash) {
                self.crash();
            }
            self.coordinate(Input::Tick);
            self.step_piles();
            self.step_robots();
            self.check();
        }
    }

    fn opened(&mut self, receiver: DeviceId, bytes: &[u8]) -> Vec<Result<Frame, FrameError>> {
        let sessions = match receiver {
            DeviceId::Coordinator => &mut self.sessions,
            DeviceId::Pile(pile) => &mut self.piles.get_mut(&pile).unwrap().sessions,
            DeviceId::Robot(robot) => &mut self.robots.get_mut(&robot).unwrap().sessions,
            stranger => panic!("the coordinator talks to {stranger}"),
        };
        let mut found = Vec::new();
        Deframer::new().feed(bytes, |packet| found.push(sessions.open(packet.unwrap())));
        found
    }

    fn deliver(&mut self) {
        while let Some(entry) = self.wire.first_entry()
            && entry.key().0 <= self.now
        {
            let (to, bytes) = entry.remove();
            for found in self.opened(to, &bytes) {
                match (to, found) {
                    (DeviceId::Coordinator, Ok(frame)) => self.coordinate(Input::Frame(frame)),
                    (DeviceId::Coordinator, Err(FrameError::Unauthentic { sender })) => {
                        self.coordinate(Input::Distrusted(sender));
                    }
                    (DeviceId::Pile(pile), Ok(frame)) => self.step_pile(pile, PileInput::Frame(&frame)),
                    (DeviceId::Pile(pile), Err(error)) => self.step_pile(pile, PileInput::Discarded(error)),
                    (DeviceId::Robot(robot), Ok(frame)) => self.robot_hears(robot, &frame),
                    (DeviceId::Robot(robot), Err(FrameError::Unauthentic { .. })) => {
                        self.robots.get_mut(&robot).unwrap().greeted = false;
                    }
                    // Late, or repeated by the network.
                    (_, Err(FrameError::Replayed { .. } | FrameError::EarlierStart { .. })) => {}
                    (to, found) => panic!("{to} got {found:?}"),
                }
            }
        }
    }

    fn step_piles(&mut self) {
        let ids: Vec<_> = self.piles.keys().copied().collect();
        for id in ids {
            if self.random.chance(self.trouble.pile_restart) {
                let pile = &self.piles[&id];
                let boot = BootEpoch(pile.boot.0 + 1);
                let sessions = sessions(&self.keys, DeviceId::Pile(id), boot);
                let pile = Pile::new(id, sessions, boot, pile.stored_epoch, self.now, pile.cell_position);
                self.piles.insert(id, pile);
            }
            let docked = self.docked(id).map(|robot| robot.config.tag);
            let read = docked.map(|tag| TagRead { tag, rssi_dbm: -45 });
            self.step_pile(id, read.map_or(PileInput::ReaderIdle, PileInput::Tag));
            let pile = self.piles.get_mut(&id).unwrap();
            pile.plant.battery = docked.map(|_| Battery::new(FULL_J, 0.5 * FULL_J));
            let sensors = pile.plant.sense(Millis(self.now - pile.started));
            self.step_pile(id, PileInput::Sensors(sensors));
            self.check_live(id);
        }
    }

    fn docked(&self, id: PileId) -> Option<&Robot> {
        self.robots.values().find(|robot| matches!(robot.mode, Mode::Docked { pile, .. } if pile == id))
    }

    /// Current is given under a lease only, and to nobody but its holder. A robot that has just left
    /// is still believed for the reader's timeout.
    fn check_live(&self, id: PileId) {
        let core = &self.piles[&id].core;
        if core.power().current_limit_a > 0.0 {
            let holder = core.leases().current().map(|lease| lease.name.robot);
            let docked = self.docked(id).map(|robot| robot.config.id);
            assert!(holder.is_some(), "seed {}: pile {id} is live without a lease", self.seed);
            assert!(
                docked.is_none() || docked == holder,
                "seed {}: pile {id} charges {docked:?} for {holder:?}",
                self.seed
            );
        }
    }

    fn step_pile(&mut self, id: PileId, input: PileInput<'_>) {
        let Some(pile) = self.piles.get_mut(&id) else { return };
        let outputs = pile.core.step(Millis(self.now - pile.started), input);
        for record in outputs.store {
            if let Record::Epoch(epoch) = record {
                pile.stored_epoch = epoch;
            }
        }
        pile.plant.command(outputs.power);
        let mut post = Vec::new();
        for outgoing in outputs.messages {
            if outgoing.to == To::Coordinator {
                post.extend(sealed(&mut pile.sessions, outgoing.to.into(), &outgoing.message));
            }
        }
        post.into_iter().for_each(|bytes| self.post(DeviceId::Coordinator, bytes));
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
            let wants = self.random.chance(5);
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
                        robot.position = self.piles[&pile].cell_position;
                        robot.mode = Mode::Docked { pile, since: now, live_at: None };
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
                    robot.mode = if over { Mode::Working } else { Mode::Docked { pile, since, live_at } };
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
            bytes.into_iter().for_each(|bytes| self.post(DeviceId::Coordinator, bytes));
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

fn keys(site: &Site, robots: u16) -> Keys {
    let mut keys = Keys::default();
    keys.make_site().unwrap();
    let piles = site.piles.iter().map(|pile| DeviceId::Pile(pile.id));
    for device in piles.chain((1..=robots).map(|robot| DeviceId::Robot(RobotId(robot)))) {
        keys.make(device).unwrap();
    }
    keys
}

fn sessions(keys: &Keys, device: DeviceId, boot: BootEpoch) -> Sessions<Vec<Session>> {
    Sessions::new(device, boot, keys.trust_of(device))
}

/// Nothing but Hello goes to who was not heard.
fn sealed(sessions: &mut Sessions<Vec<Session>>, to: Recipient, message: &Message) -> Option<Vec<u8>> {
    match sessions.seal(to, message) {
        Ok(bytes) => Some(bytes.to_vec()),
        Err(SealError::Unheard { .. }) => None,
        Err(error) => panic!("{error}"),
    }
}

fn through_json(event: &Event) -> Event {
    let json = serde_json::to_string(&event.fact).unwrap();
    Event { at: event.at, fact: serde_json::from_str(&json).unwrap() }
}

impl Pile {
    fn new(
        id: PileId,
        sessions: Sessions<Vec<Session>>,
        boot: BootEpoch,
        highest_epoch: Epoch,
        started: u64,
        cell_position: Position,
    ) -> Self {
        let parameters = Parameters { boot, highest_epoch, ..Parameters::new(id, POWER_W) };
        Self {
            core: ChargingPile::new(parameters),
            sessions,
            plant: Plant::new(),
            boot,
            stored_epoch: highest_epoch,
            started,
            cell_position,
        }
    }
}

impl Robot {
    fn take(&mut self, part: &Assignment, now: u64) {
        self.parts.insert(part.first, part.waypoints.to_vec());
        let route: Vec<_> = self.parts.values().flatten().copied().collect();
        if route.len() < usize::from(part.total) {
            return;
        }
        let coordinate = |position: &Position| (f64::from(position.x.get()), f64::from(position.y.get()));
        let length: f64 = route
            .windows(2)
            .map(|pair| {
                let ((x, y), (to_x, to_y)) = (coordinate(&pair[0]), coordinate(&pair[1]));
                (to_x - x).hypot(to_y - y)
            })
            .sum();
        self.parts.clear();
        let arrival = now + (length / SPEED_MPS * 1000.0) as u64;
        self.mode = Mode::Approaching { pile: part.pile, arrival };
        self.say_at = now;
    }

    fn talk(&self) -> Vec<Message> {
        let (position, energy) = (self.position, EnergyJ::clamped(self.energy));
        let (activity, accepted) = match self.mode {
            Mode::Working => (Activity::Working, None),
            Mode::Waiting => (Activity::Waiting, None),
            Mode::Approaching { .. } => (Activity::Approaching, Some(self.request)),
            Mode::Docked { .. } => (Activity::Docked, Some(self.request)),
        };
        let hello = (!self.greeted).then(|| Message::Hello(Hello::new(Epoch(0))));
        let mut messages: Vec<_> = hello.into_iter().collect();
        messages.push(Message::RobotState(RobotState { position, energy, activity, accepted }));
        if self.mode == Mode::Waiting {
            messages.push(Message::ChargeRequest(ChargeRequest { request: self.request, position, energy }));
        }
        messages
    }
}
