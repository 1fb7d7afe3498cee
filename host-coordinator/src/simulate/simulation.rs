//! The whole simulated site around a coordinator: piles and robots on their sockets, the world
//! between them, and the auditor who watches.

use std::{collections::BTreeMap, io, net::SocketAddr};

use firmware_pile::Parameters;
use protocol::{Activity, DurationMs, Millis, PileId, RobotId};

use super::{
    auditor::{Auditor, Sight},
    fleet::Fleet,
    pile_node::PileNode,
    pulse::Pulse,
    robot_node::RobotNode,
    world::World,
};
use crate::keys::Keys;

/// How often sensors are read and chargers commanded: as often as a pile's sensors have to be.
pub const STEP: DurationMs = DurationMs(100);

/// A site that runs.
#[derive(Debug)]
pub struct Simulation {
    now: Millis,
    world: World,
    piles: BTreeMap<PileId, PileNode>,
    robots: BTreeMap<RobotId, RobotNode>,
    auditor: Auditor,
    pulse: Pulse,
}

impl Simulation {
    /// Starts every pile and robot of `fleet`'s site, each at its own UDP port on loopback. They
    /// all speak to `coordinator`, each with its key of `keys`; the piles gossip with each other.
    ///
    /// # Errors
    /// A socket cannot be opened.
    pub async fn start(fleet: Fleet, coordinator: SocketAddr, keys: &Keys) -> io::Result<Self> {
        let mut piles = BTreeMap::new();
        for (&pile, post) in &fleet.world.posts {
            let parameters = Parameters::new(pile, post.power_w as f32);
            piles.insert(pile, PileNode::start(parameters, coordinator, keys).await?);
        }
        let addresses: BTreeMap<PileId, SocketAddr> =
            piles.iter().map(|(&pile, node)| Ok((pile, node.address()?))).collect::<io::Result<_>>()?;
        let mut robots = BTreeMap::new();
        for (robot, core) in fleet.robots {
            let piles = addresses.values().copied().collect();
            robots.insert(robot, RobotNode::start(robot, core, coordinator, piles, keys).await?);
        }
        let listeners: Vec<_> = robots.values().map(RobotNode::address).collect::<io::Result<_>>()?;
        for (pile, node) in &mut piles {
            let peers = addresses.iter().filter(|(other, _)| *other != pile).map(|(_, address)| address);
            node.meet(peers.chain(&listeners).copied().collect());
        }
        let (auditor, pulse) = (Auditor::default(), Pulse::default());
        Ok(Self { now: Millis(0), world: fleet.world, piles, robots, auditor, pulse })
    }

    /// Lets [`STEP`] pass.
    pub fn step(&mut self) {
        self.now = self.now.after(STEP);
        let supplies = self.piles.iter().filter_map(|(&pile, node)| Some((pile, node.plant().supply_w()?)));
        self.world.step(STEP, &supplies.collect());
        for (&pile, node) in &mut self.piles {
            node.step(self.now, &self.world.read(pile), self.world.battery(pile));
        }
        for (&robot, node) in &mut self.robots {
            let Some(sensed) = self.world.sense(robot) else { continue };
            let Some(body) = self.world.bodies.get_mut(&robot) else { continue };
            node.step(self.now, &sensed, body);
        }
        if self.pulse.asks(self.now) {
            self.ask_time();
        }
        self.audit();
    }

    /// Whether the coordinator is so far behind that time has to stand still.
    pub fn waits_for_the_coordinator(&mut self) -> bool {
        if let Some((_, first)) = self.robots.iter_mut().next()
            && let Some(question) = first.listen()
        {
            self.pulse.answered(question);
        }
        self.pulse.waits()
    }

    /// Asks the coordinator for the time, or asks again.
    pub fn ask_time(&mut self) {
        if let Some((_, first)) = self.robots.iter_mut().next() {
            first.ask_time(self.now);
        }
    }

    /// The time since the start.
    #[must_use]
    pub const fn now(&self) -> Millis {
        self.now
    }

    /// What the robots do.
    pub fn activities(&self) -> impl Iterator<Item = Activity> {
        self.robots.values().map(|node| node.core().activity())
    }

    /// The one who watches.
    pub const fn auditor(&mut self) -> &mut Auditor {
        &mut self.auditor
    }

    fn audit(&mut self) {
        let sights = self.piles.iter().filter_map(|(&pile, node)| {
            let at_contacts = self.world.at_contacts(pile).collect();
            Some((pile, Sight::new(node.said()?, node.plant(), at_contacts)))
        });
        self.auditor.look(self.now, &sights.collect());
    }
}
