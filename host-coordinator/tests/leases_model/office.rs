//! The coordinators of the model: the real core. It cannot be copied, so what is kept of one is its log and
//! what it has heard since its start; from these it is made again.

use std::{
    collections::{HashMap, hash_map::DefaultHasher},
    fmt::{self, Write as _},
    fs,
    hash::Hasher,
    sync::Arc,
};

use host_coordinator::{
    config::{Policy, RobotConfig},
    core::{Coordinator, Effect, Event, Input, State, observed::Observed},
    site::{Site, SitePile},
};
use planning::lmpp::Lmpp;
use protocol::{
    Activity, BootEpoch, ChargeRequest, DeviceId, DurationMs, EnergyJ, Frame, Header, Message, PileId,
    Position, RequestId, RobotId, RobotState, Sequence, SiteMillis, TagId, TaskPriority,
};

use crate::interner::Interner;

/// How long a lease lasts unless extended.
const LEASE: DurationMs = DurationMs(15_000);

/// What a coordinator hears.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Hear {
    /// Nothing, but time has passed.
    Tick,
    /// It starts with this log.
    Start,
    /// A frame of a pile: its start, the number of the frame, and that of the message.
    Pile { pile: PileId, boot: u8, sequence: u8, message: u32 },
    /// A robot says that it waits, with a request if it has one, or that it works.
    Robot { robot: RobotId, boot: u8, sequence: u8, asks: Option<u8>, waits: bool },
}

/// A coordinator between two steps.
pub struct Desk {
    /// Everything it has recorded, and its predecessors.
    pub log: Arc<Vec<Event>>,
    /// What follows from the log.
    pub state: State,
    /// Which start of each pile it has heard, and when last.
    pub heard: Vec<Option<(u8, SiteMillis)>>,
    /// When it was started.
    pub started: SiteMillis,
    /// How much of the log was there when it started, and what it took in since.
    recovered: usize,
    inputs: Vec<(SiteMillis, Input)>,
}

/// What a coordinator says to the piles in a step.
pub type Said = Vec<(PileId, Message)>;

/// All coordinators that there can be.
pub struct Office {
    site: Arc<Site>,
    memory: Lmpp,
    policy: Policy,
    robots: Vec<RobotConfig>,
    desks: Interner<u64, Desk>,
    steps: HashMap<(u32, SiteMillis, Hear), (u32, Said)>,
}

impl Office {
    pub fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
        write("map", "type octile\nheight 1\nwidth 4\nmap\n....\n");
        write("rooms", "AAAA\n");
        let piles: String = [(1, 0), (2, 3)]
            .map(|(id, x)| format!("[[pile]]\nid = {id}\nat = [{x}, 0]\npower_w = 500\n"))
            .concat();
        let text = format!(
            "name = \"Model\"\nmap = \"map\"\nsubareas = \"rooms\"\nresolution_m = 1.0\nneighbours = 8\n{piles}"
        );
        write("site.toml", &text);
        let site = Arc::new(Site::load(folder.path()).unwrap());
        let memory = site.lmpp(1.0);
        let robots = [1, 2].map(|number| RobotConfig {
            id: RobotId(number),
            tag: TagId([number as u8; 12]),
            full: EnergyJ::clamped(10_000.0),
            energy_per_metre_j: 10.0,
            speed_mps: 0.5,
            gives_w: None,
        });
        let policy = Policy { lease: LEASE, ..Policy::default() };
        let (desks, steps) = (Interner::default(), HashMap::new());
        let mut this = Self { site, memory, policy, robots: robots.to_vec(), desks, steps };
        this.desks.number(0, || Desk {
            log: Arc::default(),
            state: State::default(),
            heard: Vec::new(),
            started: SiteMillis(0),
            recovered: 0,
            inputs: Vec::new(),
        });
        this
    }

    /// The coordinator with no past.
    pub const NOBODY: u32 = 0;

    pub fn desk(&self, number: u32) -> &Desk {
        self.desks.get(number)
    }

    /// The step of a coordinator; the message of a pile is looked up.
    pub fn step(&mut self, desk: u32, now: SiteMillis, hear: Hear, message: Option<&Message>) -> (u32, Said) {
        if let Some(known) = self.steps.get(&(desk, now, hear)) {
            return known.clone();
        }
        let result = self.work_out(desk, now, hear, message);
        self.steps.insert((desk, now, hear), result.clone());
        result
    }

    fn work_out(
        &mut self,
        number: u32,
        now: SiteMillis,
        hear: Hear,
        message: Option<&Message>,
    ) -> (u32, Said) {
        let desk = self.desks.get(number);
        let (recovered, mut inputs) = match hear {
            Hear::Start => (desk.log.len(), Vec::new()),
            _ => (desk.recovered, desk.inputs.clone()),
        };
        let mut log = desk.log[..recovered].to_vec();
        let mut coordinator = Coordinator::recover(
            Arc::clone(&self.site),
            self.memory.clone(),
            self.policy,
            &self.robots,
            &log,
        );
        for (at, input) in &inputs {
            log.extend(coordinator.step(*at, input.clone()).events);
        }
        let mut said = Said::new();
        for input in self.inputs(hear, message) {
            let step = coordinator.step(now, input.clone());
            inputs.push((now, input));
            log.extend(step.events);
            said.extend(step.effects.into_iter().filter_map(|effect| match effect {
                Effect::Send { to: DeviceId::Pile(pile), message } => Some((pile, message)),
                _ => None,
            }));
        }
        let (state, observed) = (coordinator.state(), coordinator.observed());
        assert_eq!(State::fold(&log), *state, "a replay of the log gives another state");
        let heard = |pile: &SitePile| {
            let contact = observed.piles.get(&pile.id)?.contact;
            Some((contact.boot()?.0 as u8, contact.heard?))
        };
        let heard = self.site.piles.iter().map(heard).collect();
        let next = self.desks.number(canonical(state, observed), || Desk {
            heard,
            started: observed.started,
            state: state.clone(),
            log: Arc::new(log),
            recovered,
            inputs,
        });
        (next, said)
    }

    fn inputs(&self, hear: Hear, message: Option<&Message>) -> Vec<Input> {
        let frame = |sender, boot: u8, sequence: u8, message| {
            let header = Header::new(sender, BootEpoch(boot.into()), Sequence(sequence.into()));
            Input::Frame(Frame { header, message })
        };
        match hear {
            Hear::Tick => vec![Input::Tick],
            Hear::Start => vec![Input::Started { boot_floor: BootEpoch(0) }],
            Hear::Pile { pile, boot, sequence, .. } => {
                let message = message.expect("a pile's frame has a message").clone();
                vec![frame(DeviceId::Pile(pile), boot, sequence, message)]
            }
            Hear::Robot { robot, boot, sequence, asks, waits } => {
                let (position, energy) = (self.place_of(robot), EnergyJ::clamped(5_000.0));
                let activity = if waits { Activity::Waiting } else { Activity::Working };
                let state = RobotState { position, energy, activity, accepted: None };
                let request = asks.map(|request| {
                    let request = RequestId(request.into());
                    Message::ChargeRequest(ChargeRequest {
                        request,
                        position,
                        energy,
                        task: None,
                        priority: TaskPriority::USUAL,
                    })
                });
                // Each has its own number.
                let said = [Some(Message::RobotState(state)), request].into_iter().flatten();
                let numbered = (0..).zip(said);
                let frame = |(n, message)| frame(DeviceId::Robot(robot), boot, 2 * sequence + n, message);
                numbered.map(frame).collect()
            }
        }
    }

    /// Between the piles, so that each robot is nearer to one of them.
    fn place_of(&self, robot: RobotId) -> Position {
        self.site.position(planning::grid::Cell { x: i32::from(robot.0), y: 0 })
    }
}

/// What tells a coordinator from others: all that its steps depend on. Decisions, charges, sums, who is silent
/// and when the last event was are for people; nothing is decided by them.
fn canonical(state: &State, observed: &Observed) -> u64 {
    let mut state = state.clone();
    state.decisions.clear();
    state.charges.clear();
    state.next_decision = 0;
    state.totals = Default::default();
    state.silent.clear();
    state.last_at = Default::default();
    let mut digest = Digest(DefaultHasher::new());
    write!(digest, "{state:?}{observed:?}").unwrap();
    digest.0.finish()
}

struct Digest(DefaultHasher);

impl fmt::Write for Digest {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.write(text.as_bytes());
        Ok(())
    }
}
