//! How a Mecanum chassis moves: velocities, poses, and the ramp between two velocities.

/// A place in m. The middle of cell (x, y) is at (x, -y) times the cells' side: x to the right and y UP, as
/// robots count, so that they turn counter-clockwise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point {
    /// To the right.
    pub x_m: f64,
    /// Up.
    pub y_m: f64,
}

impl Point {
    /// How far it is to `other`, in m.
    #[must_use]
    pub fn distance_m(self, other: Self) -> f64 {
        length(other.x_m - self.x_m, other.y_m - self.y_m)
    }

    /// The place a share of the way to `other`: 0 is here, 1 is there.
    #[must_use]
    pub fn towards(self, other: Self, share: f64) -> Self {
        Self {
            x_m: self.x_m + (other.x_m - self.x_m) * share,
            y_m: self.y_m + (other.y_m - self.y_m) * share,
        }
    }
}

/// The length of a vector; unlike `hypot` the same on every machine.
pub(super) fn length(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

/// A velocity in the robot's own frame (Mecanum eq. 1).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Velocity {
    /// Forward, in m/s.
    pub forward_mps: f64,
    /// To the left, in m/s.
    pub left_mps: f64,
    /// Counter-clockwise, in rad/s.
    pub turn_radps: f64,
}

impl Velocity {
    /// Standing still.
    pub const REST: Self = Self { forward_mps: 0.0, left_mps: 0.0, turn_radps: 0.0 };

    /// This one and a share of the way to `other`.
    #[must_use]
    pub fn towards(self, other: Self, share: f64) -> Self {
        Self {
            forward_mps: self.forward_mps + (other.forward_mps - self.forward_mps) * share,
            left_mps: self.left_mps + (other.left_mps - self.left_mps) * share,
            turn_radps: self.turn_radps + (other.turn_radps - self.turn_radps) * share,
        }
    }

    /// Of the robot's middle over ground, in m/s.
    #[must_use]
    pub fn speed_mps(self) -> f64 {
        length(self.forward_mps, self.left_mps)
    }
}

/// Where a robot is and where its front points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Its middle.
    pub at: Point,
    /// Its front, counter-clockwise from x.
    pub heading_rad: f64,
}

impl Pose {
    /// After moving at `velocity` for so long: an exact arc.
    #[must_use]
    pub fn moved(self, velocity: Velocity, seconds: f64) -> Self {
        let half_turn = 0.5 * velocity.turn_radps * seconds;
        // The arc's chord points half a turn on, and is shorter than the arc.
        let (sine, cosine) = libm::sincos(self.heading_rad + half_turn);
        let chord = if half_turn.abs() < 1e-9 { 1.0 } else { libm::sin(half_turn) / half_turn };
        let (forward, left) = (velocity.forward_mps * seconds * chord, velocity.left_mps * seconds * chord);
        Self {
            at: Point {
                x_m: self.at.x_m + forward * cosine - left * sine,
                y_m: self.at.y_m + forward * sine + left * cosine,
            },
            heading_rad: self.heading_rad + 2.0 * half_turn,
        }
    }

    /// The way to `to` as the robot sees it: forward and left, in m.
    pub(super) fn way_to(self, to: Point) -> (f64, f64) {
        let (sine, cosine) = libm::sincos(self.heading_rad);
        let (dx, dy) = (to.x_m - self.at.x_m, to.y_m - self.at.y_m);
        (dx * cosine + dy * sine, dy * cosine - dx * sine)
    }
}

/// What a chassis can do. The board has the same rules; a test holds them together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chassis {
    /// How far a wheel rolls for a radian of turn (H/2 + W/2), in m.
    pub arm_m: f64,
    /// The most a wheel's speed changes in a tick, in m/s; above zero.
    pub increment_mps: f64,
    /// A control tick, in s; above zero.
    pub tick_s: f64,
    /// The fastest forward or back, in m/s.
    pub forward_mps: f64,
    /// The fastest to a side, in m/s.
    pub sideways_mps: f64,
    /// The fastest turn, in rad/s.
    pub turn_radps: f64,
    /// The fastest wheel, in m/s.
    pub wheel_mps: f64,
}

impl Chassis {
    /// The paper's robot (Mecanum III.C.2): 0.01 m/s a tick at 100 Hz. It prints no H, W and fastest
    /// speeds: those are the chassis' defaults.
    pub const PAPER: Self = Self {
        arm_m: 0.2,
        increment_mps: 0.01,
        tick_s: 0.01,
        forward_mps: 0.8,
        sideways_mps: 0.8,
        turn_radps: 4.0,
        wheel_mps: 1.0,
    };

    /// By how much the wheel that changes most changes between two velocities, in m/s. The wheels of eq. 1
    /// have every combination of signs, so that this is a sum of absolute values, and the velocities within
    /// reach are an octahedron.
    #[must_use]
    pub fn wheel_change_mps(&self, from: Velocity, to: Velocity) -> f64 {
        (to.forward_mps - from.forward_mps).abs()
            + (to.left_mps - from.left_mps).abs()
            + self.arm_m * (to.turn_radps - from.turn_radps).abs()
    }

    /// The velocity a tick later on the way to `target`: all wheels change by one share, the fastest by the
    /// increment.
    #[must_use]
    pub fn ramped(&self, velocity: Velocity, target: Velocity) -> Velocity {
        let change = self.wheel_change_mps(velocity, target);
        if change <= self.increment_mps {
            target
        } else {
            velocity.towards(target, self.increment_mps / change)
        }
    }

    /// Whether no limit is passed, rounding forgiven.
    #[must_use]
    pub fn can(&self, velocity: Velocity) -> bool {
        self.overload(velocity) <= 1.0 + 1e-9
    }

    /// The same direction, no faster than the limits.
    #[must_use]
    pub fn limited(&self, velocity: Velocity) -> Velocity {
        Velocity::REST.towards(velocity, 1.0 / self.overload(velocity).max(1.0))
    }

    /// The largest share of a limit that a velocity takes.
    fn overload(&self, velocity: Velocity) -> f64 {
        let shares = [
            velocity.forward_mps.abs() / self.forward_mps,
            velocity.left_mps.abs() / self.sideways_mps,
            velocity.turn_radps.abs() / self.turn_radps,
            self.wheel_change_mps(Velocity::REST, velocity) / self.wheel_mps,
        ];
        shares.into_iter().fold(0.0, f64::max)
    }
}
