//! The demo's robots: built alike, charged and placed by chance.

use std::{collections::BTreeMap, sync::Arc};

use protocol::{EnergyJ, RobotId, TagId};

use super::{
    navigator::Navigator,
    random::Random,
    robot::Robot,
    terrain::Terrain,
    world::{Body, Build, Post, World},
};
use crate::{config::RobotConfig, selection::reach::alert_energy, site::Site};

/// A kind of robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// The energy of a full battery, in joules.
    pub full_j: f32,
    /// What a metre of driving takes on top of what a robot takes all the time, in joules.
    pub drive_j_per_m: f32,
    /// What a robot's computer and sensors take all the time, in watts.
    pub idle_w: f32,
    /// How fast it drives, in metres a second.
    pub speed_mps: f32,
    /// What is kept on top of a drive across the site (delta of LMPP eq. 3), as a time of waiting in
    /// seconds.
    pub reserve_s: f32,
}

/// Of the demo: it needs a charge about every ten minutes, and can wait for three.
pub const LIVELY: Model =
    Model { full_j: 120_000.0, drive_j_per_m: 100.0, idle_w: 60.0, speed_mps: 0.8, reserve_s: 180.0 };
/// The initial charge, as a share of a full battery: from, to.
pub const INITIAL_CHARGE: (f64, f64) = (0.3, 1.0);

/// The robots and the floor they stand on.
#[derive(Debug)]
pub struct Fleet {
    /// What the coordinator knows of them.
    pub configs: Vec<RobotConfig>,
    /// Their computers.
    pub robots: BTreeMap<RobotId, Robot>,
    /// Their bodies, and the site's piles.
    pub world: World,
}

impl Fleet {
    /// `count` robots on `site`, the same for the same `seed`.
    #[must_use]
    pub fn new(site: &Arc<Site>, count: u16, seed: u64) -> Self {
        let terrain = Arc::new(Terrain::new(site));
        let alert = LIVELY.alert(site);
        let posts = site.piles.iter().map(|pile| {
            (pile.id, Post { position: site.position(pile.cell).into(), power_w: pile.power_w.into() })
        });
        let world = World { posts: posts.collect(), bodies: BTreeMap::new() };
        let mut fleet = Self { configs: Vec::new(), robots: BTreeMap::new(), world };
        for id in (1..=count).map(RobotId) {
            let mut random = Random::new(seed, id.0.into());
            let energy_j = f64::from(LIVELY.full_j) * random.between(INITIAL_CHARGE.0, INITIAL_CHARGE.1);
            let mut navigator = Navigator::new(Arc::clone(&terrain), random);
            // A site without a place to work at has no robots.
            let Some(position) = navigator.place() else { break };
            let build = LIVELY.build(id);
            fleet.configs.push(LIVELY.config(id));
            fleet.robots.insert(id, Robot::new(id, build, navigator, alert.get().into()));
            fleet.world.bodies.insert(id, Body::new(build, position, energy_j));
        }
        fleet
    }
}

impl Model {
    /// What a metre takes in all, which is what a robot's reach depends on.
    fn energy_per_metre_j(&self) -> f32 {
        self.drive_j_per_m + self.idle_w / self.speed_mps
    }

    /// The energy at which a robot asks for a charge (LMPP eq. 3).
    #[must_use]
    pub fn alert(&self, site: &Site) -> EnergyJ {
        let diameter_m = f64::from(site.grid.width()).hypot(site.grid.height().into()) * site.resolution_m;
        alert_energy(self.energy_per_metre_j(), diameter_m, EnergyJ::clamped(self.reserve_s * self.idle_w))
    }

    /// How a robot is built.
    #[must_use]
    pub fn build(&self, robot: RobotId) -> Build {
        Build {
            tag: tag(robot),
            full_j: self.full_j.into(),
            idle_w: self.idle_w.into(),
            drive_j_per_m: self.drive_j_per_m.into(),
            speed_mps: self.speed_mps.into(),
        }
    }

    /// What the coordinator knows of a robot.
    #[must_use]
    pub fn config(&self, robot: RobotId) -> RobotConfig {
        let full = EnergyJ::clamped(self.full_j);
        let energy_per_metre_j = self.energy_per_metre_j();
        let speed_mps = self.speed_mps;
        RobotConfig { id: robot, tag: tag(robot), full, energy_per_metre_j, speed_mps, gives_w: None }
    }
}

/// An EPC as a fleet's owner would number them: a fixed head, the robot's number at the end.
fn tag(robot: RobotId) -> TagId {
    let [high, low] = robot.0.to_be_bytes();
    TagId([0x30, 0x75, 0x1F, 0xEB, 0x70, 0x5C, 0x59, 0x04, 0xE3, 0xD5, high, low])
}
