//! The physics of the simulated site, pure: bodies, batteries, charge contacts, reader fields.
//!
//! The world knows where everything is; a robot's or a pile's computer learns of it only what its
//! own sensors tell ([`World::sense`], [`World::read`]). Robots drive through one another: only a
//! pile's one place is contended. Times are steps of simulated time that the caller chooses.

use std::collections::BTreeMap;

use firmware_pile::plant::Battery;
use protocol::{DurationMs, PileId, RobotId, TagId};

use super::ground::{Point, Route, follow};

/// A robot's contacts touch a pile's within this distance in metres.
pub const CONTACT_M: f64 = 0.2;
/// A robot sees whether another stands at the end of its route from this far, in metres.
pub const SIGHT_M: f64 = 8.0;
/// A robot occupies this much floor around its middle, in metres.
const ROBOT_RADIUS_M: f64 = 0.5;
/// What a reader hears of a tag one metre away.
const RSSI_AT_ONE_METRE_DBM: f64 = -66.0;
/// The loss with every tenfold distance.
const RSSI_PER_DECADE_DB: f64 = 20.0;
/// Nearer than this, in metres, a tag is not heard any louder.
const RSSI_NEAREST_M: f64 = 0.2;
/// A reader hears nothing weaker: its field is 4 m deep.
const READER_FLOOR_DBM: f64 = -78.0;

/// How a robot is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Build {
    /// The tag on it.
    pub tag: TagId,
    /// The energy of its full battery, in joules.
    pub full_j: f64,
    /// What its computer and sensors take all the time, in watts.
    pub idle_w: f64,
    /// What a metre of driving takes on top, in joules.
    pub drive_j_per_m: f64,
    /// How fast it drives, in metres a second.
    pub speed_mps: f64,
}

/// A robot's body.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// How it is built.
    pub build: Build,
    /// Where it is.
    pub position: Point,
    /// What its battery holds, in joules; never less than 0 or more than `build.full_j`.
    pub energy_j: f64,
    /// What its drive still has to drive.
    pub route: Route,
    /// Whether its drive does so.
    pub moving: bool,
    /// Whether there is a voltage on its charge contacts.
    contacts_live: bool,
}

impl Body {
    /// A body that stands still.
    #[must_use]
    pub const fn new(build: Build, position: Point, energy_j: f64) -> Self {
        Self { build, position, energy_j, route: Route::new(), moving: false, contacts_live: false }
    }

    /// Whether it stands on these contacts. Whoever drives over them does not touch them.
    fn touches(&self, contacts: Point) -> bool {
        let stands = !self.moving || self.route.is_empty();
        stands && self.position.distance_m(contacts) < CONTACT_M
    }

    fn drive(&mut self, seconds: f64) {
        self.energy_j = (self.energy_j - self.build.idle_w * seconds).max(0.0);
        if !self.moving {
            return;
        }
        let range_m = self.energy_j / self.build.drive_j_per_m;
        let distance_m = range_m.min(self.build.speed_mps * seconds);
        let (position, driven_m) = follow(self.position, &mut self.route, distance_m);
        self.position = position;
        self.energy_j = (self.energy_j - driven_m * self.build.drive_j_per_m).max(0.0);
    }
}

/// A pile as the world sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Post {
    /// Where its contacts are.
    pub position: Point,
    /// The power it charges with, in watts.
    pub power_w: f64,
}

/// What a robot's own sensors tell it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensed {
    /// Where it is.
    pub position: Point,
    /// What its battery holds, in joules.
    pub energy_j: f64,
    /// Whether its route has been driven to the end.
    pub arrived: bool,
    /// Whether no other robot can be seen at the end of its route.
    pub end_clear: bool,
    /// Whether there is a voltage on its charge contacts.
    pub contacts_live: bool,
    /// Of a mobile charger: whether the robot that it is to charge stands at its coupling.
    pub partner: bool,
}

/// Everything that moves or stands.
#[derive(Clone, Debug, Default)]
pub struct World {
    /// The piles.
    pub posts: BTreeMap<PileId, Post>,
    /// The robots.
    pub bodies: BTreeMap<RobotId, Body>,
}

impl World {
    /// Lets `time` pass. The piles in `supplies` have their contactors closed and give so many watts.
    pub fn step(&mut self, time: DurationMs, supplies: &BTreeMap<PileId, f32>) {
        let seconds = f64::from(time.0) / 1000.0;
        for body in self.bodies.values_mut() {
            body.drive(seconds);
            let touched = |pile| self.posts.get(pile).is_some_and(|post| body.touches(post.position));
            let supply = supplies.iter().find(|(pile, _)| touched(pile));
            body.contacts_live = supply.is_some();
            if let Some((_, supply_w)) = supply {
                body.energy_j = (body.energy_j + f64::from(*supply_w) * seconds).min(body.build.full_j);
            }
        }
    }

    /// What `robot`'s sensors tell it; `None` if there is no such robot.
    #[must_use]
    pub fn sense(&self, robot: RobotId) -> Option<Sensed> {
        let body = self.bodies.get(&robot)?;
        let end = body.route.back().copied().unwrap_or(body.position);
        let in_sight = body.position.distance_m(end) <= SIGHT_M;
        let taken = self
            .bodies
            .iter()
            .any(|(&other, there)| other != robot && there.position.distance_m(end) < 2.0 * ROBOT_RADIUS_M);
        Some(Sensed {
            position: body.position,
            energy_j: body.energy_j,
            arrived: body.route.is_empty(),
            end_clear: !(in_sight && taken),
            contacts_live: body.contacts_live,
            partner: false,
        })
    }

    /// What `pile`'s reader hears in one poll: tags and their signal strengths in dBm.
    #[must_use]
    pub fn read(&self, pile: PileId) -> Vec<(TagId, i8)> {
        let Some(post) = self.posts.get(&pile) else { return Vec::new() };
        let heard = |body: &Body| {
            let rssi_dbm = rssi_dbm(body.position.distance_m(post.position));
            (rssi_dbm >= READER_FLOOR_DBM).then_some((body.build.tag, rssi_dbm as i8))
        };
        self.bodies.values().filter_map(heard).collect()
    }

    /// The battery of the robot that stands on `pile`'s contacts.
    #[must_use]
    pub fn battery(&self, pile: PileId) -> Option<Battery> {
        let body = self.at_contacts(pile).next().and_then(|robot| self.bodies.get(&robot))?;
        Some(Battery::new(body.build.full_j as f32, body.energy_j as f32))
    }

    /// The robots that stand on `pile`'s contacts.
    pub fn at_contacts(&self, pile: PileId) -> impl Iterator<Item = RobotId> {
        let post = self.posts.get(&pile);
        self.bodies
            .iter()
            .filter(move |(_, body)| post.is_some_and(|post| body.touches(post.position)))
            .map(|(&robot, _)| robot)
    }
}

/// How loud a tag is at a distance in metres: a log-distance model.
#[must_use]
pub fn rssi_dbm(distance_m: f64) -> f64 {
    RSSI_AT_ONE_METRE_DBM - RSSI_PER_DECADE_DB * distance_m.max(RSSI_NEAREST_M).log10()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const BUILD: Build =
        Build { tag: TagId([7; 12]), full_j: 1_000.0, idle_w: 1.0, drive_j_per_m: 10.0, speed_mps: 0.5 };
    const PILE: PileId = PileId(1);
    const ROBOT: RobotId = RobotId(1);
    const OTHER: RobotId = RobotId(2);
    const SECOND: DurationMs = DurationMs(1_000);

    fn point(x_m: f64) -> Point {
        Point { x_m, y_m: 0.0 }
    }

    fn world(robots: &[(RobotId, f64)]) -> World {
        let post = Post { position: point(0.0), power_w: 50.0 };
        let bodies = robots.iter().map(|&(robot, x_m)| (robot, Body::new(BUILD, point(x_m), 100.0)));
        World { posts: [(PILE, post)].into(), bodies: bodies.collect() }
    }

    #[test]
    fn a_robot_is_charged_on_live_contacts_only_and_never_beyond_full() {
        let mut world = world(&[(ROBOT, 0.0), (OTHER, 1.0)]);
        world.step(SECOND, &BTreeMap::new());
        assert_eq!(world.bodies[&ROBOT].energy_j, 99.0);
        assert!(!world.sense(ROBOT).unwrap().contacts_live);
        world.step(SECOND, &[(PILE, 50.0)].into());
        assert_eq!(world.bodies[&ROBOT].energy_j, 148.0);
        assert_eq!(world.bodies[&OTHER].energy_j, 98.0);
        assert!(world.sense(ROBOT).unwrap().contacts_live);
        assert!(!world.sense(OTHER).unwrap().contacts_live);
        for _ in 0..60 {
            world.step(SECOND, &[(PILE, 50.0)].into());
        }
        assert_eq!(world.bodies[&ROBOT].energy_j, 1_000.0);
    }

    #[test]
    fn a_robot_that_drives_over_live_contacts_is_not_charged() {
        let mut world = world(&[(ROBOT, 0.0)]);
        let body = world.bodies.get_mut(&ROBOT).unwrap();
        (body.route, body.moving) = ([point(3.0)].into(), true);
        world.step(DurationMs(100), &[(PILE, 50.0)].into());
        assert!(!world.sense(ROBOT).unwrap().contacts_live);
        assert_eq!(world.at_contacts(PILE).count(), 0);
    }

    #[test]
    fn a_robot_that_drives_pays_for_every_metre_and_stops_where_its_energy_ends() {
        let mut world = world(&[(ROBOT, 0.0)]);
        let body = world.bodies.get_mut(&ROBOT).unwrap();
        (body.route, body.moving) = ([point(3.0), point(1_000.0)].into(), true);
        world.step(SECOND, &BTreeMap::new());
        assert_eq!(world.bodies[&ROBOT].position, point(0.5));
        assert_eq!(world.bodies[&ROBOT].energy_j, 100.0 - 1.0 - 5.0);
        for _ in 0..60 {
            world.step(SECOND, &BTreeMap::new());
        }
        let body = &world.bodies[&ROBOT];
        assert_eq!(body.energy_j, 0.0);
        assert!((8.0..9.0).contains(&body.position.x_m), "{:?}", body.position);
    }

    #[test]
    fn a_tag_is_louder_the_nearer_it_is_and_unheard_beyond_the_field() {
        let heard = |x_m| world(&[(ROBOT, x_m)]).read(PILE).first().map(|&(_, rssi_dbm)| rssi_dbm);
        let loudness: Vec<_> = [0.0, 0.5, 1.0, 2.0, 3.9].into_iter().map(heard).collect();
        assert!(loudness.iter().all(Option::is_some), "{loudness:?}");
        assert!(loudness.is_sorted_by(|near, far| near > far), "{loudness:?}");
        assert_eq!(heard(4.1), None);
    }

    #[test]
    fn a_tag_on_the_contacts_is_docked_for_the_firmware_and_one_that_waits_is_not() {
        let docked = firmware_pile::Parameters::new(PILE, 50.0).docked;
        assert!(rssi_dbm(CONTACT_M) as i8 >= docked.enter_dbm);
        assert!((rssi_dbm(super::super::ground::KEEP_CLEAR_M) as i8) < docked.leave_dbm);
    }

    #[test]
    fn a_robot_sees_that_its_dock_is_taken_only_from_nearby() {
        let clear = |x_m| {
            let mut world = world(&[(ROBOT, x_m), (OTHER, 0.0)]);
            world.bodies.get_mut(&ROBOT).unwrap().route = [point(0.0)].into();
            world.sense(ROBOT).unwrap().end_clear
        };
        assert!(!clear(5.0));
        assert!(clear(20.0));
    }

    proptest! {
        #[test]
        fn energy_stays_between_nothing_and_full(
            steps in proptest::collection::vec((any::<bool>(), any::<bool>(), 0_u32..10_000, -50.0..50.0), 1..100),
        ) {
            let mut world = world(&[(ROBOT, 0.0)]);
            for (moving, closed, time, x_m) in steps {
                let body = world.bodies.get_mut(&ROBOT).unwrap();
                body.moving = moving;
                body.route = [point(x_m), point(0.0)].into();
                world.step(DurationMs(time), &closed.then_some((PILE, 50.0)).into_iter().collect());
                let energy_j = world.bodies[&ROBOT].energy_j;
                prop_assert!((0.0..=BUILD.full_j).contains(&energy_j), "{energy_j}");
            }
        }
    }
}
