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

/// A full battery: small, so that a robot needs a charge about every ten minutes.
const FULL_J: f32 = 120_000.0;
/// What a metre of driving takes, on top of what a robot takes all the time.
const DRIVE_J_PER_M: f32 = 100.0;
/// What a robot's computer and sensors take all the time.
const IDLE_W: f32 = 60.0;
/// How fast a robot drives.
const SPEED_MPS: f32 = 0.8;
/// What a metre takes in all, which is what a robot's reach depends on.
const ENERGY_PER_METRE_J: f32 = DRIVE_J_PER_M + IDLE_W / SPEED_MPS;
/// Kept on top of a drive across the site (delta of LMPP eq. 3): three minutes of waiting.
const RESERVE_J: f32 = 180.0 * IDLE_W;
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
        let alert = alert(site);
        let posts = site.piles.iter().map(|pile| {
            (pile.id, Post { position: site.position(pile.cell).into(), power_w: pile.power_w.into() })
        });
        let world = World { posts: posts.collect(), bodies: BTreeMap::new() };
        let mut fleet = Self { configs: Vec::new(), robots: BTreeMap::new(), world };
        for id in (1..=count).map(RobotId) {
            let mut random = Random::new(seed, id.0.into());
            let energy_j = f64::from(FULL_J) * random.between(INITIAL_CHARGE.0, INITIAL_CHARGE.1);
            let mut navigator = Navigator::new(Arc::clone(&terrain), random);
            // A site without a place to work at has no robots.
            let Some(position) = navigator.place() else { break };
            let build = build(id);
            fleet.configs.push(config(id));
            fleet.robots.insert(id, Robot::new(navigator, alert.get().into()));
            fleet.world.bodies.insert(id, Body::new(build, position, energy_j));
        }
        fleet
    }
}

/// The energy at which a robot asks for a charge (LMPP eq. 3).
#[must_use]
pub fn alert(site: &Site) -> EnergyJ {
    let diameter_m = f64::from(site.grid.width()).hypot(site.grid.height().into()) * site.resolution_m;
    alert_energy(ENERGY_PER_METRE_J, diameter_m, EnergyJ::clamped(RESERVE_J))
}

/// How a robot is built.
#[must_use]
pub fn build(robot: RobotId) -> Build {
    Build {
        tag: tag(robot),
        full_j: FULL_J.into(),
        idle_w: IDLE_W.into(),
        drive_j_per_m: DRIVE_J_PER_M.into(),
        speed_mps: SPEED_MPS.into(),
    }
}

/// What the coordinator knows of a robot.
#[must_use]
pub fn config(robot: RobotId) -> RobotConfig {
    let full = EnergyJ::clamped(FULL_J);
    RobotConfig { id: robot, tag: tag(robot), full, energy_per_metre_j: ENERGY_PER_METRE_J, speed_mps: SPEED_MPS }
}

/// An EPC as a fleet's owner would number them: a fixed head, the robot's number at the end.
fn tag(robot: RobotId) -> TagId {
    let [high, low] = robot.0.to_be_bytes();
    TagId([0x30, 0x75, 0x1F, 0xEB, 0x70, 0x5C, 0x59, 0x04, 0xE3, 0xD5, high, low])
}
