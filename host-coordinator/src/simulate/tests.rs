//! The whole floor without a network: robots and the real pile cores in lockstep, and a dispatcher
//! that gives every robot that asks the nearest free pile.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

use firmware_pile::{ChargingPile, Contactor, Input, Parameters, TagRead};
use planning::search::{Workspace, dijkstra};
use protocol::*;

use super::{
    auditor::{Auditor, Sight},
    fleet::Fleet,
    ground::Point,
    simulation::STEP,
};
use crate::site::Site;

fn site() -> Arc<Site> {
    Arc::new(Site::fig7().unwrap())
}

struct Pile {
    core: ChargingPile,
    closed: bool,
    said: Option<PileState>,
}

/// A site whose network is a few maps in memory.
struct Floor {
    site: Arc<Site>,
    fleet: Fleet,
    now: Millis,
    piles: BTreeMap<PileId, Pile>,
    /// What waits for the robots.
    mail: BTreeMap<RobotId, Vec<Message>>,
    /// Whom the dispatcher gave which pile, until the pile says that the lease has ended.
    given: BTreeMap<PileId, RobotId>,
    next_lease: u32,
    sequence: u32,
    auditor: Auditor,
    completed: BTreeSet<LeaseId>,
}

impl Floor {
    fn new(seed: u64) -> Self {
        let site = site();
        let fleet = Fleet::new(&site, 10, seed);
        let pile = |(&pile, post): (&PileId, &super::world::Post)| {
            let core = ChargingPile::new(Parameters::new(pile, post.power_w as f32));
            (pile, Pile { core, closed: false, said: None })
        };
        let piles = fleet.world.posts.iter().map(pile).collect();
        Self {
            site,
            fleet,
            now: Millis(0),
            piles,
            mail: BTreeMap::new(),
            given: BTreeMap::new(),
            next_lease: 1,
            sequence: 0,
            auditor: Auditor::default(),
            completed: BTreeSet::new(),
        }
    }

    fn site_now(&self) -> SiteMillis {
        SiteMillis(self.now.0)
    }

    fn step(&mut self) {
        self.now = self.now.after(STEP);
        let closed = self.piles.iter().filter(|(_, pile)| pile.closed).map(|(&id, _)| id).collect();
        self.fleet.world.step(STEP, &closed);
        let ids: Vec<PileId> = self.piles.keys().copied().collect();
        for id in ids {
            for (tag, rssi_dbm) in self.fleet.world.read(id) {
                self.input(id, Input::Tag(TagRead { tag, rssi_dbm }));
            }
            let closed = self.piles[&id].closed;
            self.input(id, Input::ReaderIdle);
            self.input(id, Input::ContactorFeedback { closed });
        }
        let mut asked = Vec::new();
        for (&id, robot) in &mut self.fleet.robots {
            let sensed = self.fleet.world.sense(id).unwrap();
            let outputs = robot.step(self.now, &sensed, &self.mail.remove(&id).unwrap_or_default());
            let body = self.fleet.world.bodies.get_mut(&id).unwrap();
            body.moving = outputs.moving;
            if let Some(route) = outputs.route {
                body.route = route;
            }
            asked.extend(outputs.messages.into_iter().filter_map(|message| match message {
                Message::ChargeRequest(request) => Some((id, request)),
                _ => None,
            }));
        }
        for (robot, request) in asked {
            self.dispatch(robot, request);
        }
        let world = &self.fleet.world;
        let sights = self.piles.iter().filter_map(|(&id, pile)| {
            let at_contacts = world.at_contacts(id).collect();
            Some((id, Sight { said: pile.said?, closed: pile.closed, at_contacts }))
        });
        self.auditor.look(self.now, &sights.collect());
    }

    fn input(&mut self, id: PileId, input: Input<'_>) {
        let site_now = self.site_now();
        let pile = self.piles.get_mut(&id).unwrap();
        let outputs = pile.core.step(self.now, input);
        pile.closed = outputs.contactor == Contactor::Closed;
        let mut answers = Vec::new();
        for outgoing in outputs.messages {
            match outgoing.message {
                Message::PileState(state) => {
                    pile.said = Some(state);
                    if let Some(ended) = state.ended.filter(|_| state.holder.is_none()) {
                        self.given.remove(&id);
                        if ended.reason == EndReason::Completed {
                            self.completed.insert(ended.lease.lease);
                        }
                    }
                }
                Message::TimeRequest(TimeRequest { asked_at }) => {
                    answers.push(Message::TimeSync(TimeSync { asked_at, site_now }));
                }
                _ => {}
            }
        }
        for answer in answers {
            self.say(id, answer);
        }
    }

    fn say(&mut self, pile: PileId, message: Message) {
        self.sequence += 1;
        let header = Header::new(DeviceId::Coordinator, BootEpoch(1), Sequence(self.sequence));
        self.input(pile, Input::Frame(&Frame { header, message }));
    }

    /// The nearest pile that is free, and the way there.
    fn dispatch(&mut self, robot: RobotId, request: ChargeRequest) {
        let start = self.site.cell_of(request.position).unwrap();
        let mut workspace = Workspace::default();
        let ways = dijkstra(&self.site.grid, self.site.moves, start, &[], &mut workspace).unwrap();
        let free = self.site.piles.iter().filter(|pile| {
            self.piles[&pile.id].core.availability() == Availability::Free
                && !self.given.contains_key(&pile.id)
        });
        let Some(pile) = free.min_by_key(|pile| ways.length_to(pile.cell)) else { return };
        let path = ways.path_to(pile.cell).unwrap();
        let waypoints: Vec<Position> =
            path.waypoints().iter().map(|&cell| self.site.position(cell)).collect();
        for (part, points) in waypoints.chunks(limits::WAYPOINTS_PER_PART).enumerate() {
            self.mail.entry(robot).or_default().push(Message::Assignment(Assignment {
                request: request.request,
                pile: pile.id,
                total: waypoints.len() as u16,
                first: (part * limits::WAYPOINTS_PER_PART) as u16,
                waypoints: points.iter().copied().collect(),
            }));
        }
        let (id, body) = (pile.id, &self.fleet.world.bodies[&robot]);
        let grant = Grant {
            head: CommandHead {
                id: CommandId(self.next_lease),
                valid_until: self.site_now().after(DurationMs(9_000)),
            },
            lease: LeaseRef { epoch: Epoch(1), lease: LeaseId(self.next_lease), robot },
            tag: body.build.tag,
            expiry: self.site_now().after(DurationMs(1_200_000)),
            energy: EnergyJ::clamped((body.build.full_j - body.energy_j) as f32),
        };
        self.next_lease += 1;
        self.given.insert(id, robot);
        self.say(id, Message::Grant(grant));
    }

    /// Everything that can be seen of the robots.
    fn picture(&self) -> Vec<(Point, f64, Activity)> {
        let bodies = self.fleet.world.bodies.iter();
        bodies.map(|(id, body)| (body.position, body.energy_j, self.fleet.robots[id].activity())).collect()
    }
}

#[test]
fn ten_robots_keep_one_another_charged_for_half_an_hour() {
    for seed in 0..4 {
        let mut floor = Floor::new(seed);
        for _ in 0..30 * 60 * 10 {
            floor.step();
            for (id, body) in &floor.fleet.world.bodies {
                assert!((0.0..=body.build.full_j).contains(&body.energy_j), "robot {id}: {body:?}");
                let cell = floor.site.cell_of(body.position.into()).unwrap();
                assert!(floor.site.grid.is_free(cell), "robot {id} is in a wall at {cell}");
            }
        }
        assert_eq!(floor.auditor.violations().count(), 0, "{:?}", floor.auditor);
        let activities = floor.picture();
        let stranded = activities.iter().filter(|(.., activity)| *activity == Activity::Stranded).count();
        assert_eq!(stranded, 0, "seed {seed}: {activities:?}");
        assert!(floor.completed.len() >= 10, "seed {seed}: {} charges", floor.completed.len());
    }
}

#[test]
fn a_seed_gives_the_same_run_every_time_and_another_seed_another() {
    let run = |seed| {
        let mut floor = Floor::new(seed);
        let mut pictures = Vec::new();
        for second in 0..300 {
            (0..10).for_each(|_| floor.step());
            if second % 10 == 0 {
                pictures.push(floor.picture());
            }
        }
        pictures
    };
    assert_eq!(run(7), run(7));
    assert_ne!(run(7), run(8));
}
