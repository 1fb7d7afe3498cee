//! A robot's body: where it is and what its battery holds, computed when somebody asks.
//!
//! Between two instants at which something changes, a body moves and consumes evenly, so it is moved on
//! only when it is looked at.

use std::collections::VecDeque;

use protocol::Millis;

use super::super::{
    ground::{Point, Route},
    world::Build,
};

/// A straight part of a way, and how long the robot stands before it: the door there is crowded.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Leg {
    to: Point,
    left_m: f64,
    pause_ms: f64,
}

/// A robot's body.
#[derive(Clone, Debug)]
pub struct Body {
    /// How it really is built, whatever others believe.
    build: Build,
    at: Millis,
    position: Point,
    energy_j: f64,
    legs: VecDeque<Leg>,
    moving: bool,
    /// What its work takes on top of what it takes all the time, in watts.
    work_w: f64,
    driven_m: f64,
}

impl Body {
    /// A body that stands still.
    #[must_use]
    pub const fn new(build: Build, position: Point, energy_j: f64) -> Self {
        Self {
            build,
            at: Millis(0),
            position,
            energy_j,
            legs: VecDeque::new(),
            moving: false,
            work_w: 0.0,
            driven_m: 0.0,
        }
    }

    /// How it really is built.
    #[must_use]
    pub const fn build(&self) -> &Build {
        &self.build
    }

    /// Where it is, as of the last time it was moved on.
    #[must_use]
    pub const fn position(&self) -> Point {
        self.position
    }

    /// What its battery holds in joules, as of the last time it was moved on.
    #[must_use]
    pub const fn energy_j(&self) -> f64 {
        self.energy_j
    }

    /// How far it has driven in all, in metres.
    #[must_use]
    pub const fn driven_m(&self) -> f64 {
        self.driven_m
    }

    /// Whether its route is driven to the end.
    #[must_use]
    pub fn has_arrived(&self) -> bool {
        self.legs.is_empty()
    }

    /// Whether it stands.
    #[must_use]
    pub fn stands(&self) -> bool {
        !self.moving || self.legs.is_empty()
    }

    /// Where its route ends.
    #[must_use]
    pub fn end(&self) -> Point {
        self.legs.back().map_or(self.position, |leg| leg.to)
    }

    /// What a metre of driving takes in all, in joules.
    #[must_use]
    pub fn per_metre_j(&self) -> f64 {
        self.build.drive_j_per_m + self.build.idle_w / self.build.speed_mps
    }

    /// Gives it another route, with a pause at the beginning of each part that `pause_ms` says one for.
    pub fn take_route(&mut self, route: &Route, mut pause_ms: impl FnMut(Point, Point) -> f64) {
        self.legs.clear();
        let mut from = self.position;
        for &to in route {
            let left_m = from.distance_m(to);
            if left_m > 0.0 {
                self.legs.push_back(Leg { to, left_m, pause_ms: pause_ms(from, to) });
                from = to;
            }
        }
    }

    /// Somebody puts it there.
    pub fn put(&mut self, position: Point) {
        self.legs.clear();
        self.position = position;
    }

    /// Drops its route.
    pub fn stop(&mut self) {
        self.legs.clear();
        self.moving = false;
    }

    /// Whether it drives from now on, and what its work takes in watts.
    pub const fn command(&mut self, moving: bool, work_w: f64) {
        self.moving = moving;
        self.work_w = work_w;
    }

    /// So much came into its battery, or went to another's if it is negative, in joules.
    pub fn charge(&mut self, energy_j: f64) {
        self.energy_j = (self.energy_j + energy_j).clamp(0.0, self.build.full_j);
    }

    /// Lets the time up to `now` pass.
    pub fn advance(&mut self, now: Millis) {
        let mut left_ms = now.0.saturating_sub(self.at.0) as f64;
        self.at = self.at.max(now);
        let resting_w = self.build.idle_w + self.work_w;
        if self.moving {
            while left_ms > 0.0 && self.energy_j > 0.0 {
                let Some(leg) = self.legs.front_mut() else { break };
                let paused_ms = leg.pause_ms.min(left_ms);
                leg.pause_ms -= paused_ms;
                left_ms -= paused_ms;
                self.energy_j = (self.energy_j - resting_w * paused_ms / 1e3).max(0.0);
                self.drive(&mut left_ms);
            }
        }
        self.energy_j = (self.energy_j - resting_w * left_ms / 1e3).max(0.0);
    }

    /// Drives along the first part of the route, to its end or for as long as there is time and energy.
    fn drive(&mut self, left_ms: &mut f64) {
        let Some(leg) = self.legs.front_mut() else { return };
        let speed_mps = self.build.speed_mps;
        let per_metre_j = self.build.drive_j_per_m + (self.build.idle_w + self.work_w) / speed_mps;
        let range_m = self.energy_j / per_metre_j;
        let driven_m = leg.left_m.min(*left_ms / 1e3 * speed_mps).min(range_m);
        self.energy_j = if driven_m < range_m { self.energy_j - driven_m * per_metre_j } else { 0.0 };
        self.driven_m += driven_m;
        *left_ms -= driven_m / speed_mps * 1e3;
        // What is left below this is rounding.
        if leg.left_m - driven_m < 1e-6 {
            self.position = leg.to;
            self.legs.pop_front();
        } else {
            let share = driven_m / leg.left_m;
            self.position.x_m += share * (leg.to.x_m - self.position.x_m);
            self.position.y_m += share * (leg.to.y_m - self.position.y_m);
            leg.left_m -= driven_m;
        }
    }

    /// How long it drives until it is at the end of its route but for `short_m`, in milliseconds rounded
    /// up, if its energy suffices; `None` if it stands.
    #[must_use]
    pub fn time_to_end_ms(&self, short_m: f64) -> Option<u64> {
        if self.stands() {
            return None;
        }
        let (left_m, paused_ms) = self
            .legs
            .iter()
            .fold((0.0, 0.0), |(left_m, paused_ms), leg| (left_m + leg.left_m, paused_ms + leg.pause_ms));
        Some((paused_ms + (left_m - short_m).max(0.0) / self.build.speed_mps * 1e3).ceil() as u64)
    }

    /// How long it drives until it is within `radius_m` of `centre` for the first time, in milliseconds;
    /// `None` if its route does not lead there. It need not drive yet.
    #[must_use]
    pub fn time_to_disc_ms(&self, centre: Point, radius_m: f64) -> Option<u64> {
        if self.position.distance_m(centre) <= radius_m {
            return Some(0);
        }
        let mut from = self.position;
        let mut passed_ms = 0.0;
        for leg in &self.legs {
            passed_ms += leg.pause_ms;
            if let Some(entry_m) = entry_m(from, leg.to, leg.left_m, centre, radius_m) {
                return Some((passed_ms + entry_m / self.build.speed_mps * 1e3).ceil() as u64);
            }
            passed_ms += leg.left_m / self.build.speed_mps * 1e3;
            from = leg.to;
        }
        None
    }
}

/// How far from `from`, on the straight way of `length_m` to `to`, a disc begins; the way begins outside.
fn entry_m(from: Point, to: Point, length_m: f64, centre: Point, radius_m: f64) -> Option<f64> {
    let (dx, dy) = ((to.x_m - from.x_m) / length_m, (to.y_m - from.y_m) / length_m);
    let (cx, cy) = (centre.x_m - from.x_m, centre.y_m - from.y_m);
    let along = cx * dx + cy * dy;
    let aside = cx * dy - cy * dx;
    let half_square = radius_m * radius_m - aside * aside;
    if half_square < 0.0 {
        return None;
    }
    let entry = along - half_square.sqrt();
    (0.0..=length_m).contains(&entry).then_some(entry)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use protocol::TagId;

    use super::*;

    const BUILD: Build =
        Build { tag: TagId([7; 12]), full_j: 10_000.0, idle_w: 1.0, drive_j_per_m: 10.0, speed_mps: 0.5 };

    fn point(x_m: f64, y_m: f64) -> Point {
        Point { x_m, y_m }
    }

    fn body(energy_j: f64) -> Body {
        let mut body = Body::new(BUILD, point(0.0, 0.0), energy_j);
        body.take_route(&[point(0.0, 0.0), point(3.0, 0.0), point(3.0, 4.0)].into(), |from, _| {
            if from.x_m > 0.0 { 2_000.0 } else { 0.0 }
        });
        body.command(true, 0.0);
        body
    }

    #[test]
    fn a_body_pauses_at_a_crowded_door_and_pays_for_driving_and_waiting() {
        let mut body = body(1_000.0);
        assert_eq!(body.time_to_end_ms(0.0), Some(16_000));
        body.advance(Millis(7_000));
        assert_eq!((body.position(), body.energy_j()), (point(3.0, 0.0), 1_000.0 - 7.0 - 30.0));
        body.advance(Millis(15_000));
        assert_eq!((body.position(), body.has_arrived()), (point(3.0, 3.5), false));
        body.advance(Millis(16_000));
        assert_eq!((body.position(), body.has_arrived(), body.driven_m()), (point(3.0, 4.0), true, 7.0));
        body.advance(Millis(20_000));
        assert_eq!(body.energy_j(), 1_000.0 - 20.0 - 70.0);
    }

    #[test]
    fn a_body_stops_where_its_energy_ends() {
        let mut body = body(24.0);
        body.advance(Millis(60_000));
        assert_eq!((body.position(), body.energy_j()), (point(2.0, 0.0), 0.0));
        body.advance(Millis(90_000));
        assert_eq!(body.position(), point(2.0, 0.0));
    }

    #[test]
    fn the_time_to_a_disc_counts_pauses_and_is_none_beside_the_way() {
        let body = body(1_000.0);
        assert_eq!(body.time_to_disc_ms(point(3.0, 4.0), 1.0), Some(6_000 + 2_000 + 6_000));
        assert_eq!(body.time_to_disc_ms(point(1.0, 0.5), 0.5), Some(2_000));
        assert_eq!(body.time_to_disc_ms(point(1.0, 2.0), 1.0), None);
        assert_eq!(body.time_to_disc_ms(point(-0.5, 0.0), 1.0), Some(0));
    }

    proptest! {
        #[test]
        fn it_does_not_matter_how_often_a_body_is_looked_at(looks in prop::collection::vec(1_u64..900, 1..60), energy_j in 0.0..120.0) {
            let (mut often, mut once) = (body(energy_j), body(energy_j));
            let mut now = 0;
            for look in looks {
                now += look;
                often.advance(Millis(now));
            }
            once.advance(Millis(now));
            prop_assert!(often.position().distance_m(once.position()) < 1e-6);
            prop_assert!((often.energy_j() - once.energy_j()).abs() < 1e-6);
        }
    }
}
