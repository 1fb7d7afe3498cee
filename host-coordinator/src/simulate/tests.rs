//! The whole site without a network: the real coordinator's core, the real pile cores and the
//! robots, in lockstep, over a wire in memory that may lose what it carries.

use std::{collections::BTreeMap, sync::Arc};

use firmware_pile::{ChargingPile, Parameters, TagRead, To, plant::Plant};
use protocol::*;

use super::{
    auditor::{Auditor, Claim, Sight},
    fleet::Fleet,
    ground::Point,
    random::Random,
    simulation::STEP,
};
use crate::{
    config::Policy,
    core::{Coordinator, Effect, Input, state::Phase},
    site::Site,
};

/// A pile and the end of its wire.
struct Pile {
    core: ChargingPile,
    plant: Plant,
    said: Option<PileState>,
}

/// What goes over the wire, who sent it, and how much of it is lost.
struct Wire {
    sequences: BTreeMap<DeviceId, Sequence>,
    inboxes: BTreeMap<DeviceId, Vec<Frame>>,
    loss: f64,
    random: Random,
}

impl Wire {
    fn send(&mut self, from: DeviceId, to: DeviceId, message: Message) {
        let sequence = self.sequences.entry(from).or_default();
        sequence.0 += 1;
        let frame = Frame { header: Header::new(from, BootEpoch(1), *sequence), message };
        if self.random.between(0.0, 1.0) >= self.loss {
            self.inboxes.entry(to).or_default().push(frame);
        }
    }

    fn receive(&mut self, at: DeviceId) -> Vec<Frame> {
        self.inboxes.remove(&at).unwrap_or_default()
    }
}

/// A site whose time the test moves.
struct Lockstep {
    site: Arc<Site>,
    fleet: Fleet,
    now: Millis,
    piles: BTreeMap<PileId, Pile>,
    coordinator: Coordinator,
    wire: Wire,
    auditor: Auditor,
}

impl Lockstep {
    /// Ten robots on Fig. 7 with only these of its piles, or with all of them if none is named.
    fn new(seed: u64, piles: &[u16], loss: f64) -> Self {
        let mut site = Site::fig7().unwrap();
        site.piles.retain(|pile| piles.is_empty() || piles.contains(&pile.id.0));
        let site = Arc::new(site);
        let fleet = Fleet::new(&site, 10, seed);
        let pile = |pile: &crate::site::SitePile| {
            let core = ChargingPile::new(Parameters::new(pile.id, pile.power_w));
            (pile.id, Pile { core, plant: Plant::new(), said: None })
        };
        let piles = site.piles.iter().map(pile).collect();
        let mut coordinator =
            Coordinator::recover(Arc::clone(&site), site.lmpp(1.0), Policy::default(), &fleet.configs, &[]);
        coordinator.step(SiteMillis(0), Input::Started { boot_floor: BootEpoch(0) });
        let (sequences, inboxes) = (BTreeMap::new(), BTreeMap::new());
        let wire = Wire { sequences, inboxes, loss, random: Random::new(seed, 1_000) };
        Self { site, fleet, now: Millis(0), piles, coordinator, wire, auditor: Auditor::default() }
    }

    fn run(&mut self, minutes: u32) {
        (0..minutes * 60_000 / STEP.0).for_each(|_| self.step());
    }

    fn step(&mut self) {
        self.now = self.now.after(STEP);
        let supplies = self.piles.iter().filter_map(|(&id, pile)| Some((id, pile.plant.supply_w()?)));
        self.fleet.world.step(STEP, &supplies.collect());
        let frames = self.wire.receive(DeviceId::Coordinator).into_iter().map(Input::Frame);
        frames.chain([Input::Tick]).for_each(|input| self.coordinate(input));
        let piles: Vec<PileId> = self.piles.keys().copied().collect();
        piles.into_iter().for_each(|pile| self.step_pile(pile));
        let robots: Vec<RobotId> = self.fleet.robots.keys().copied().collect();
        robots.into_iter().for_each(|robot| self.step_robot(robot));
        self.audit();
    }

    fn coordinate(&mut self, input: Input) {
        for effect in self.coordinator.step(SiteMillis(self.now.0), input).effects {
            if let Effect::Send { to, message } = effect {
                self.wire.send(DeviceId::Coordinator, to, message);
            }
        }
    }

    fn step_pile(&mut self, id: PileId) {
        use firmware_pile::Input;
        let pile = self.piles.get_mut(&id).unwrap();
        let frames = self.wire.receive(DeviceId::Pile(id));
        let reads = self.fleet.world.read(id);
        let mut inputs: Vec<Input<'_>> = frames.iter().map(Input::Frame).collect();
        inputs.extend(reads.iter().map(|&(tag, rssi_dbm)| Input::Tag(TagRead { tag, rssi_dbm })));
        pile.plant.battery = self.fleet.world.battery(id);
        inputs.extend([Input::ReaderIdle, Input::Sensors(pile.plant.sense(self.now))]);
        for input in inputs {
            let outputs = pile.core.step(self.now, input);
            pile.plant.command(outputs.power);
            for outgoing in outputs.messages {
                if let Message::PileState(state) = &outgoing.message {
                    pile.said = Some(*state);
                }
                match outgoing.to {
                    To::Coordinator => {
                        self.wire.send(DeviceId::Pile(id), DeviceId::Coordinator, outgoing.message);
                    }
                    To::Service | To::Provisioner => {}
                    To::Peers => {
                        for other in self.site.piles.iter().map(|pile| pile.id).filter(|&other| other != id) {
                            let to = DeviceId::Pile(other);
                            self.wire.send(DeviceId::Pile(id), to, outgoing.message.clone());
                        }
                    }
                }
            }
        }
    }

    fn step_robot(&mut self, id: RobotId) {
        let device = DeviceId::Robot(id);
        let heard: Vec<Message> = self.wire.receive(device).into_iter().map(|frame| frame.message).collect();
        let sensed = self.fleet.world.sense(id).unwrap();
        let outputs = self.fleet.robots.get_mut(&id).unwrap().step(self.now, &sensed, &heard);
        let body = self.fleet.world.bodies.get_mut(&id).unwrap();
        body.moving = outputs.moving;
        if let Some(route) = outputs.route {
            body.route = route;
        }
        for message in outputs.messages {
            self.wire.send(device, DeviceId::Coordinator, message);
        }
        assert!((0.0..=body.build.full_j).contains(&body.energy_j), "robot {id}: {body:?}");
        let cell = self.site.cell_of(body.position.into()).unwrap();
        assert!(self.site.grid.is_free(cell), "robot {id} is in a wall at {cell}");
    }

    fn audit(&mut self) {
        for (&pile, record) in &self.coordinator.state().piles {
            if let Some(lease) = record.lease.filter(|lease| matches!(lease.phase, Phase::Held { .. })) {
                self.auditor.hear(Claim { at: self.now, pile, granted: lease.name.robot });
            }
        }
        let world = &self.fleet.world;
        let sights = self.piles.iter().filter_map(|(&id, pile)| {
            let at_contacts = world.at_contacts(id).collect();
            Some((id, Sight::new(pile.said?, &pile.plant, at_contacts)))
        });
        self.auditor.look(self.now, &sights.collect());
    }

    /// Everything that can be seen of the robots.
    fn picture(&self) -> Vec<(Point, f64, Activity)> {
        let bodies = self.fleet.world.bodies.iter();
        bodies.map(|(id, body)| (body.position, body.energy_j, self.fleet.robots[id].activity())).collect()
    }

    /// Charges completed, after a check that nothing has gone wrong.
    fn charges(&self) -> u64 {
        let violations: Vec<_> = self.auditor.violations().map(ToString::to_string).collect();
        assert_eq!(violations, Vec::<String>::new());
        let picture = self.picture();
        assert!(picture.iter().all(|(.., activity)| *activity != Activity::Stranded), "{picture:?}");
        self.coordinator.state().totals.charges_completed
    }
}

#[test]
fn ten_robots_stay_charged_for_half_an_hour() {
    for seed in 0..3 {
        let mut site = Lockstep::new(seed, &[], 0.0);
        site.run(30);
        let charges = site.charges();
        assert!(charges >= 10, "seed {seed}: {charges} charges");
    }
}

#[test]
fn robots_queue_where_piles_are_scarce_and_everyone_is_served() {
    let mut site = Lockstep::new(1, &[2, 7, 8, 13], 0.0);
    site.run(60);
    let charges = site.charges();
    let totals = site.coordinator.state().totals;
    assert!(totals.worst_wait > DurationMs(30_000), "nobody had to queue: {totals:?}");
    assert!(charges >= 10, "{totals:?}");
}

#[test]
fn a_wire_that_loses_every_fifth_frame_delays_charges_and_spoils_none() {
    let mut site = Lockstep::new(1, &[], 0.2);
    site.run(30);
    let charges = site.charges();
    assert!(charges >= 10, "{charges} charges");
}

#[test]
fn a_seed_gives_the_same_run_every_time_and_another_seed_another() {
    let run = |seed| {
        let mut site = Lockstep::new(seed, &[], 0.1);
        let minutes = (0..5).map(|_| {
            site.run(1);
            site.picture()
        });
        minutes.collect::<Vec<_>>()
    };
    assert_eq!(run(7), run(7));
    assert_ne!(run(7), run(8));
}
