//! The dynamic window approach for a Mecanum chassis: velocities that follow a path smoothly (Mecanum's
//! step 4 and III.C; the paper prints no formula of it).
//!
//! Every few ticks a robot asks for its next velocity. The window is what the chassis' ramp can reach until
//! it asks again ([`Chassis::wheel_change_mps`]). A velocity of it is admissible if the robot, having
//! taken it up, can still stop before anything blocked: the whole way to standstill is checked, as the
//! ramp will drive it. To brake is to drive the end of a way that was checked before, so that a robot
//! that starts clear never touches what does not move.
//!
//! The robot aims at a *carrot*: the farthest place of its route, not more than [`Dwa::lookahead_m`] ahead,
//! that it could reach straight on. Of the admissible velocities it takes the one that costs least:
//! how far from the carrot it would be after [`Dwa::horizon_s`], plus what it lacks in clearance, plus how
//! far its front points away from the carrot, plus what moving obstacles would come too near.
//!
//! That it gets on: going straight for the carrot takes it nearer by more than clearance, with its weight
//! below 1, can cost, so that standing still is never cheapest while there is a carrot ahead. A route
//! that is blocked has no carrot beyond the block: the robot stops there and says that it is stuck.

mod clearance;
mod motion;
mod route;

pub use self::{
    clearance::Obstacles,
    motion::{Chassis, Point, Pose, Velocity},
    route::Route,
};

/// How a robot follows routes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dwa {
    /// What its chassis can do.
    pub chassis: Chassis,
    /// Of a disc around it, in m.
    pub radius_m: f64,
    /// The room beside it that a route needs on top, in m. At least what it drives in a tick; half of it is
    /// kept free.
    pub margin_m: f64,
    /// Ticks from one velocity to the next.
    pub ticks: u32,
    /// How far ahead a velocity is judged, in s; at least the time to stop from the fastest.
    pub horizon_s: f64,
    /// How far ahead on the route it aims, in m.
    pub lookahead_m: f64,
    /// Clearance beyond the radius that costs nothing, in m.
    pub clearance_m: f64,
    /// What a metre less costs, in m; below 1.
    pub clearance_weight: f64,
    /// What it costs to look away from where it aims, as a share of the distance to there.
    pub heading_weight: f64,
    /// The same as `clearance_m`, from moving obstacles.
    pub berth_m: f64,
    /// What a metre less of that costs, in m.
    pub berth_weight: f64,
    /// So near to the route's end it has arrived, in m.
    pub tolerance_m: f64,
    /// After so long without getting nearer it is stuck, in s.
    pub patience_s: f64,
}

impl Default for Dwa {
    /// The paper's robot, asking at 10 Hz.
    fn default() -> Self {
        Self {
            chassis: Chassis::PAPER,
            radius_m: 0.18,
            margin_m: 0.02,
            ticks: 10,
            horizon_s: 1.0,
            lookahead_m: 1.2,
            clearance_m: 0.2,
            clearance_weight: 0.5,
            heading_weight: 0.2,
            berth_m: 0.4,
            berth_weight: 2.0,
            tolerance_m: 0.03,
            patience_s: 5.0,
        }
    }
}

/// A disc that moves, such as another robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moving {
    /// Its middle.
    pub at: Point,
    /// To the right and up, in m/s.
    pub velocity_mps: (f64, f64),
    /// Its radius, in m.
    pub radius_m: f64,
}

impl Moving {
    fn at_time(&self, seconds: f64) -> Point {
        let (x, y) = self.velocity_mps;
        Point { x_m: self.at.x_m + x * seconds, y_m: self.at.y_m + y * seconds }
    }
}

/// How far a robot has come. Starts as the default.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Where on the route it aims, in m.
    carrot_m: f64,
    /// The least that was left to go, in m.
    left_m: f64,
    /// For how long it has not become less, in s.
    waiting_s: f64,
}

impl Default for Progress {
    fn default() -> Self {
        Self { carrot_m: 0.0, left_m: f64::INFINITY, waiting_s: 0.0 }
    }
}

/// What a robot shall do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// Take up this velocity, which is within the ramp's reach.
    Drive(Velocity),
    /// It is at the route's end. It stands, or is to.
    Arrived,
    /// It cannot get on: stop, and plan another route.
    Stuck,
}

impl Command {
    /// The velocity to take up.
    #[must_use]
    pub const fn velocity(self) -> Velocity {
        match self {
            Self::Drive(velocity) => velocity,
            Self::Arrived | Self::Stuck => Velocity::REST,
        }
    }
}

/// The window is taken so much smaller than the ramp's reach, as the board counts in single precision.
const WITHIN: f64 = 0.9999;
/// Into so many parts the window is divided from its middle to each corner.
const PARTS: i32 = 3;
/// Getting nearer by less than that is none, in m.
const NEARER_M: f64 = 0.01;
/// So many places of the lookahead are tried as carrot.
const CARROTS: u32 = 32;
/// So many times within the horizon moving obstacles are looked at.
const LOOKS: u32 = 10;

/// A robot's place and velocity, and what is around it.
struct Situation<'a> {
    obstacles: &'a Obstacles<'a>,
    moving: &'a [Moving],
    pose: Pose,
    velocity: Velocity,
}

impl Dwa {
    /// What a robot shall do that is at `pose` with `velocity`, and how far it has come. To be asked again
    /// after [`Self::ticks`].
    #[must_use]
    pub fn step(
        &self,
        route: &Route,
        obstacles: &Obstacles<'_>,
        moving: &[Moving],
        (pose, velocity): (Pose, Velocity),
        progress: Progress,
    ) -> (Command, Progress) {
        let goal_m = pose.at.distance_m(route.goal());
        if goal_m <= self.tolerance_m {
            let stands =
                self.chassis.wheel_change_mps(velocity, Velocity::REST) <= self.chassis.increment_mps;
            return (if stands { Command::Arrived } else { Command::Drive(self.braked(velocity)) }, progress);
        }
        let carrot_m = self.carrot_m(route, obstacles, pose.at, progress.carrot_m);
        let progress = self.progressed(route, pose.at, carrot_m, progress);
        if progress.waiting_s >= self.patience_s {
            return (Command::Stuck, progress);
        }
        let situation = Situation { obstacles, moving, pose, velocity };
        let best = carrot_m.and_then(|carrot_m| self.best(&situation, route.at(carrot_m)));
        (Command::Drive(best.unwrap_or_else(|| self.braked(velocity))), progress)
    }

    /// A period, in s.
    fn period_s(&self) -> f64 {
        f64::from(self.ticks) * self.chassis.tick_s
    }

    /// The farthest place of the route that can be reached straight on, up to the lookahead beyond the last.
    fn carrot_m(&self, route: &Route, obstacles: &Obstacles<'_>, at: Point, last_m: f64) -> Option<f64> {
        let farthest_m = (last_m + self.lookahead_m).min(route.length_m());
        let step_m = self.lookahead_m / f64::from(CARROTS);
        // Where it has less room than it wants it goes on with what it has.
        let wanted_m = self.radius_m + self.margin_m;
        let radius_m = obstacles.clearance_m(at, wanted_m);
        let reachable = |&along_m: &f64| {
            let place = route.at(along_m);
            at.distance_m(place) <= self.lookahead_m && obstacles.is_clear(at, place, radius_m)
        };
        // Back to the lookahead before the last: a robot that gave way may be behind where it was.
        let back = (0..=3 * CARROTS).map(|step| farthest_m - f64::from(step) * step_m);
        back.take_while(|&along_m| along_m > -step_m).map(|along_m| along_m.max(0.0)).find(reachable)
    }

    fn progressed(&self, route: &Route, at: Point, carrot_m: Option<f64>, before: Progress) -> Progress {
        let waiting = Progress { waiting_s: before.waiting_s + self.period_s(), ..before };
        let Some(carrot_m) = carrot_m else { return waiting };
        let left_m = route.length_m() - carrot_m + at.distance_m(route.at(carrot_m));
        if left_m < before.left_m - NEARER_M {
            Progress { carrot_m, left_m, waiting_s: 0.0 }
        } else {
            Progress { carrot_m, ..waiting }
        }
    }

    /// Towards `wanted` as far as limits and the window allow.
    fn within_window(&self, velocity: Velocity, wanted: Velocity) -> Velocity {
        let wanted = self.chassis.limited(wanted);
        let change = self.chassis.wheel_change_mps(velocity, wanted);
        let reach = WITHIN * f64::from(self.ticks) * self.chassis.increment_mps;
        if change <= reach { wanted } else { velocity.towards(wanted, reach / change) }
    }

    fn braked(&self, velocity: Velocity) -> Velocity {
        self.within_window(velocity, Velocity::REST)
    }

    /// The admissible velocity that costs least; `None` if none is admissible.
    fn best(&self, situation: &Situation<'_>, carrot: Point) -> Option<Velocity> {
        let mut best = None;
        for velocity in self.window(situation, carrot) {
            if let Some(cost) = self.cost(situation, velocity, carrot)
                && best.is_none_or(|(least, _)| cost < least)
            {
                best = Some((cost, velocity));
            }
        }
        best.map(|(_, velocity)| velocity)
    }

    /// The window's velocities: straight for the carrot, with and without turning to it, and turning alone;
    /// braking; and a lattice over the octahedron.
    fn window(&self, situation: &Situation<'_>, carrot: Point) -> impl Iterator<Item = Velocity> {
        let now = situation.velocity;
        let (forward_m, left_m) = situation.pose.way_to(carrot);
        let seconds = self.horizon_s + self.period_s();
        let turn_radps = libm::atan2(left_m, forward_m) / seconds;
        let (forward_mps, left_mps) = (forward_m / seconds, left_m / seconds);
        let straight = Velocity { forward_mps, left_mps, turn_radps: 0.0 };
        let aimed = [
            straight,
            Velocity { turn_radps, ..straight },
            Velocity { turn_radps, ..Velocity::REST },
            Velocity::REST,
        ];
        let aimed = aimed.map(|wanted| self.within_window(now, wanted));
        let part = WITHIN * f64::from(self.ticks) * self.chassis.increment_mps / f64::from(PARTS);
        let chassis = self.chassis;
        let span = -PARTS..=PARTS;
        let lattice = span.clone().flat_map(move |x| {
            let span = span.clone();
            span.clone().flat_map(move |y| span.clone().map(move |turn| (x, y, turn)))
        });
        let lattice = lattice.filter(|(x, y, turn)| x.abs() + y.abs() + turn.abs() <= PARTS).map(
            move |(x, y, turn)| Velocity {
                forward_mps: now.forward_mps + f64::from(x) * part,
                left_mps: now.left_mps + f64::from(y) * part,
                turn_radps: now.turn_radps + f64::from(turn) * part / chassis.arm_m,
            },
        );
        aimed.into_iter().chain(lattice).filter(move |&velocity| chassis.can(velocity))
    }

    /// What it costs to take up `velocity`, in m; `None` if that is not admissible.
    fn cost(&self, situation: &Situation<'_>, velocity: Velocity, carrot: Point) -> Option<f64> {
        let (then, clearance_m) = self.way_to_rest(situation, velocity)?;
        let later = then.moved(velocity, self.horizon_s);
        let off_m = later.at.distance_m(carrot);
        let pose = situation.pose;
        let bearing_rad = libm::atan2(carrot.y_m - pose.at.y_m, carrot.x_m - pose.at.x_m);
        let (sine, cosine) = libm::sincos(later.heading_rad - bearing_rad);
        let away = libm::atan2(sine, cosine).abs() / std::f64::consts::PI;
        let berth_m = self.berth_m(situation.moving, then, velocity);
        Some(
            off_m
                + self.clearance_weight * (self.clearance_m - clearance_m)
                + self.heading_weight * away * pose.at.distance_m(carrot)
                + self.berth_weight * (self.berth_m - berth_m),
        )
    }

    /// Takes up `velocity` within a period, then stops, as the ramp does it: the pose after the period and the
    /// least room beside the robot, in m, at most [`Self::clearance_m`]. `None` if it touches something.
    fn way_to_rest(&self, situation: &Situation<'_>, velocity: Velocity) -> Option<(Pose, f64)> {
        let Situation { obstacles, moving, mut pose, velocity: mut now } = *situation;
        let chassis = &self.chassis;
        // Between two ticks it may come nearer by half of what it drives in one: the margin's other half.
        let keep_m = self.radius_m + 0.5 * self.margin_m;
        let room_m = |at| obstacles.clearance_m(at, keep_m + self.clearance_m) - keep_m;
        let mut least_m = room_m(pose.at);
        let mut then = pose;
        // How far it may go without another look.
        let mut free_m = least_m;
        for tick in 0.. {
            if tick == self.ticks {
                then = pose;
            }
            let target = if tick < self.ticks { velocity } else { Velocity::REST };
            if tick >= self.ticks && now == Velocity::REST {
                break;
            }
            now = chassis.ramped(now, target);
            pose = pose.moved(now, chassis.tick_s);
            free_m -= now.speed_mps() * chassis.tick_s;
            // What is no number has no room.
            if free_m < 0.0 || free_m.is_nan() {
                free_m = room_m(pose.at);
                least_m = least_m.min(free_m);
                if free_m < 0.0 {
                    return None;
                }
            }
            let seconds = f64::from(tick + 1) * chassis.tick_s;
            let touches =
                |other: &Moving| pose.at.distance_m(other.at_time(seconds)) < self.radius_m + other.radius_m;
            if moving.iter().any(touches) {
                return None;
            }
        }
        Some((then, least_m.min(room_m(pose.at))))
    }

    /// How near moving obstacles would come within the horizon, in m, at most [`Self::berth_m`].
    fn berth_m(&self, moving: &[Moving], then: Pose, velocity: Velocity) -> f64 {
        let looks = (0..=LOOKS).map(|look| self.horizon_s * f64::from(look) / f64::from(LOOKS));
        let gaps = looks.flat_map(|seconds| {
            let at = then.moved(velocity, seconds).at;
            moving.iter().map(move |other| {
                at.distance_m(other.at_time(self.period_s() + seconds)) - self.radius_m - other.radius_m
            })
        });
        gaps.fold(self.berth_m, f64::min)
    }
}
