//! Where the robot is, and how sure that is.
//!
//! Within a tick the velocity is taken as constant, and the pose moved along the arc which that
//! gives (the exponential of SE(2)), so that a turn on a circle is exact for any tick. The turn of
//! a tick is the mean of what the wheels and the gyroscope say, each weighted by how sure it is.
//!
//! Covariance: a wheel's way has a variance in proportion to its length
//! ([`Noise::rolling_m`](crate::parameters::Noise)) and that of the encoder's quantum; they are
//! carried to the robot's frame by the matrix of eq. 2, and from tick to tick by the derivative of
//! the pose.

use nalgebra::Vector3;

use crate::{
    covariance::PlaneCovariance,
    kinematics::{Kinematics, Velocity, WheelSpeeds},
    parameters::Noise,
    trig::sin_cos,
};

/// Beyond this the map ends, in m.
const FARTHEST_M: f32 = protocol::CoordinateM::MAX.get();
/// Beyond this a covariance says nothing.
const LARGEST: f32 = protocol::Covariance::MAX.get();

/// Where the robot is and where it looks, in the frame in which it started: m, m, rad from -pi
/// to pi.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Forward of the start, in m.
    pub x: f32,
    /// Left of the start, in m.
    pub y: f32,
    /// Counter-clockwise from the start, in rad.
    pub yaw: f32,
}

impl Pose {
    /// The pose after a motion with constant velocity that is given in the frame of this one:
    /// m, m, rad.
    #[must_use]
    pub fn moved(self, motion: &Velocity) -> Self {
        let way = turned(chord(motion), sin_cos(self.yaw));
        self.shifted(way, motion.z)
    }

    /// The pose after a way in the map's frame and a turn.
    fn shifted(self, (x, y): (f32, f32), turn: f32) -> Self {
        Self {
            x: (self.x + x).clamp(-FARTHEST_M, FARTHEST_M),
            y: (self.y + y).clamp(-FARTHEST_M, FARTHEST_M),
            yaw: wrapped(self.yaw + turn),
        }
    }
}

/// A way in a frame that is turned by an angle with this sine and cosine.
fn turned((forward, left): (f32, f32), (sin, cos): (f32, f32)) -> (f32, f32) {
    (cos * forward - sin * left, sin * forward + cos * left)
}

/// Where an arc ends, in the frame of its start. With a small angle, sin(a)/a and (1 - cos(a))/a
/// are their series; the terms left out are below the precision of an f32.
fn chord(motion: &Velocity) -> (f32, f32) {
    let angle = motion.z;
    let (along, across) = if angle.abs() < 0.05 {
        (1.0 - angle * angle / 6.0, 0.5 * angle * (1.0 - angle * angle / 12.0))
    } else {
        let (sin, cos) = sin_cos(angle);
        (sin / angle, (1.0 - cos) / angle)
    };
    (along * motion.x - across * motion.y, across * motion.x + along * motion.y)
}

/// The same angle from -pi to pi.
fn wrapped(angle: f32) -> f32 {
    use core::f32::consts::{PI, TAU};
    if angle.abs() <= PI { angle } else { angle - TAU * libm::roundf(angle / TAU) }
}

/// What one tick has measured.
#[derive(Clone, Copy, Debug)]
pub struct Rolled {
    /// How far each wheel has rolled, in m.
    pub wheels_m: WheelSpeeds,
    /// The turn by the gyroscope, its bias taken out, in rad.
    pub gyro_rad: Option<f32>,
    /// The tick's length, in s.
    pub elapsed_s: f32,
    /// Whether a wheel slips.
    pub slipping: bool,
}

/// The pose and its covariance.
#[derive(Clone, Debug, PartialEq)]
pub struct Odometer {
    noise: Noise,
    /// The variance of a way for being counted in whole counts, in m².
    quantum_m2: f32,
    pose: Pose,
    covariance: PlaneCovariance,
}

impl Odometer {
    /// An odometer at its start.
    #[must_use]
    pub fn new(noise: Noise, metres_per_count: f32) -> Self {
        let quantum_m2 = metres_per_count * metres_per_count / 12.0;
        Self { noise, quantum_m2, pose: Pose::default(), covariance: PlaneCovariance::default() }
    }

    /// Where the robot is.
    #[must_use]
    pub const fn pose(&self) -> Pose {
        self.pose
    }

    /// How sure that is.
    #[must_use]
    pub const fn covariance(&self) -> &PlaneCovariance {
        &self.covariance
    }

    /// Moves on by what a tick has measured. Answers the fused motion of the tick, in the robot's
    /// frame before it: m, m, rad.
    pub fn advance(&mut self, kinematics: &Kinematics, rolled: &Rolled) -> Velocity {
        let mut motion = kinematics.twist(&rolled.wheels_m);
        let mut variance = self.motion_variance(kinematics, rolled);
        if let Some(gyro_rad) = rolled.gyro_rad {
            let deviation = self.noise.gyro_radps * rolled.elapsed_s;
            let gyro = deviation * deviation;
            let weight = variance.yawyaw / (variance.yawyaw + gyro);
            motion.z += weight * (gyro_rad - motion.z);
            // The errors of place and turn of the wheels go together; those of the gyroscope and
            // the wheels do not.
            let left = 1.0 - weight;
            variance.xyaw *= left;
            variance.yyaw *= left;
            variance.yawyaw = weight * gyro;
        }
        let yaw = sin_cos(self.pose.yaw);
        let way = turned(chord(&motion), yaw);
        // To first order in the small turn of a tick.
        self.covariance = (self.covariance.carried(way) + variance.turned(yaw)).clamped(LARGEST);
        self.pose = self.pose.shifted(way, motion.z);
        motion
    }

    /// The covariance of the wheels' word on a tick's motion.
    fn motion_variance(&self, kinematics: &Kinematics, rolled: &Rolled) -> PlaneCovariance {
        let rolling = self.noise.rolling_m * if rolled.slipping { self.noise.slipping } else { 1.0 };
        kinematics.twist_covariance(&rolled.wheels_m.map(|way| rolling * way.abs() + self.quantum_m2))
    }

    /// The variances of the velocity that wheel speeds with variance `speed` and the gyroscope give,
    /// if it is heard: m²/s², m²/s², rad²/s².
    #[must_use]
    pub fn velocity_variance(&self, kinematics: &Kinematics, speed: f32, gyro: bool) -> Vector3<f32> {
        let PlaneCovariance { xx, yy, yawyaw, .. } = kinematics.twist_covariance(&WheelSpeeds::repeat(speed));
        let mut variance = Vector3::new(xx, yy, yawyaw);
        if gyro {
            variance.z = variance.z.min(self.noise.gyro_radps * self.noise.gyro_radps);
        }
        variance
    }
}

#[cfg(test)]
mod tests {
    use core::f32::consts::{FRAC_PI_2, PI};

    use nalgebra::Matrix3;
    use proptest::prelude::*;
    use protocol::RobotId;

    use super::*;
    use crate::{TICK_S, parameters::Parameters};

    const ROBOT: Parameters = Parameters::new(RobotId(1));

    fn odometer() -> (Odometer, Kinematics) {
        (Odometer::new(ROBOT.noise, ROBOT.geometry.metres_per_count()), Kinematics::new(0.2, 0.2))
    }

    fn rolled(wheels_m: WheelSpeeds, gyro_rad: Option<f32>) -> Rolled {
        Rolled { wheels_m, gyro_rad, elapsed_s: TICK_S, slipping: false }
    }

    #[test]
    fn a_quarter_circle_in_one_tick_ends_where_it_should() {
        // Radius 1 m, forward all the way.
        let pose = Pose::default().moved(&Velocity::new(FRAC_PI_2, 0.0, FRAC_PI_2));
        assert!((pose.x - 1.0).abs() < 1e-6 && (pose.y - 1.0).abs() < 1e-6);
        assert!((pose.yaw - FRAC_PI_2).abs() < 1e-6);
    }

    #[test]
    fn a_gyroscope_that_contradicts_slipping_wheels_is_believed() {
        let (mut odometer, kinematics) = odometer();
        let turning = kinematics.wheels(&Velocity::new(0.0, 0.0, 0.025));
        let motion = odometer.advance(&kinematics, &Rolled { slipping: true, ..rolled(turning, Some(0.0)) });
        assert!(motion.z.abs() < 0.025 * 1e-3, "{}", motion.z);
    }

    #[test]
    fn without_a_gyroscope_the_wheels_are() {
        let (mut odometer, kinematics) = odometer();
        let turning = kinematics.wheels(&Velocity::new(0.0, 0.0, 0.025));
        let motion = odometer.advance(&kinematics, &rolled(turning, None));
        assert!((motion.z - 0.025).abs() < 1e-6);
    }

    #[test]
    fn after_ten_metres_straight_on_the_variances_are_those_of_a_random_walk() {
        let (mut odometer, kinematics) = odometer();
        let ahead = WheelSpeeds::repeat(0.005);
        for _ in 0..2_000 {
            odometer.advance(&kinematics, &rolled(ahead, None));
        }
        // Forward: a mean of four wheels, each 10 m at 1e-4 m²/m: 1e-3 / 4.
        let covariance = odometer.covariance();
        assert!((covariance.xx / 2.5e-4 - 1.0).abs() < 0.01, "{covariance:?}");
        // Yaw: four times (0.25 / 0.2)² times the same.
        assert!((covariance.yawyaw / 6.25e-3 - 1.0).abs() < 0.01, "{covariance:?}");
        // To the side: as forward, and the integral of the yaw's over the way, v L³ / 3.
        let aside = 2.5e-4 + 6.25e-4 * 10.0f32.powi(3) / 3.0;
        assert!((covariance.yy / aside - 1.0).abs() < 0.01, "{covariance:?}");
    }

    #[test]
    fn with_a_gyroscope_the_heading_is_as_sure_as_its_noise_allows() {
        let (mut odometer, kinematics) = odometer();
        for _ in 0..2_000 {
            odometer.advance(&kinematics, &rolled(WheelSpeeds::repeat(0.005), Some(0.0)));
        }
        // 2000 ticks of (0.003 rad/s x 0.01 s)².
        let covariance = odometer.covariance();
        assert!((covariance.yawyaw / 1.8e-6 - 1.0).abs() < 0.01, "{covariance:?}");
    }

    proptest! {
        #[test]
        fn two_halves_of_a_constant_twist_make_the_whole(
            x in -1.0f32..1.0, y in -1.0f32..1.0, yaw in -3.0f32..3.0, turn in -3.0f32..3.0,
        ) {
            let start = Pose { x: 0.3, y: -0.7, yaw };
            let whole = start.moved(&Velocity::new(x, y, turn));
            let half = Velocity::new(x, y, turn) / 2.0;
            let halves = start.moved(&half).moved(&half);
            prop_assert!((whole.x - halves.x).abs() < 1e-5 && (whole.y - halves.y).abs() < 1e-5);
            prop_assert!(wrapped(whole.yaw - halves.yaw).abs() < 1e-5);
        }

        #[test]
        fn a_yaw_stays_within_half_a_turn(yaw in -3.0f32..3.0, turn in -1e4f32..1e4) {
            let pose = Pose { yaw, ..Pose::default() }.moved(&Velocity::new(0.0, 0.0, turn));
            prop_assert!(pose.yaw.abs() <= PI + 1e-3);
        }

        #[test]
        fn the_covariance_stays_a_covariance(
            ticks in prop::collection::vec((prop::array::uniform4(-0.02f32..0.02), prop::option::of(-0.1f32..0.1)), 1..300),
        ) {
            let (mut odometer, kinematics) = odometer();
            for (wheels, gyro) in ticks {
                odometer.advance(&kinematics, &rolled(WheelSpeeds::from(wheels), gyro));
                let covariance = Matrix3::from(*odometer.covariance());
                let least = covariance.symmetric_eigenvalues().min();
                prop_assert!(least >= -1e-5 * covariance.amax(), "{covariance}");
            }
        }

        #[test]
        fn no_motion_makes_a_pose_or_covariance_that_is_no_number(
            ticks in prop::collection::vec((prop::array::uniform4(-20.0f32..20.0), prop::option::of(-35.0f32..35.0)), 1..300),
        ) {
            let (mut odometer, kinematics) = odometer();
            for (wheels, gyro) in ticks {
                let motion = odometer.advance(&kinematics, &rolled(WheelSpeeds::from(wheels), gyro));
                let Pose { x, y, yaw } = odometer.pose();
                prop_assert!([x, y, yaw].into_iter().all(f32::is_finite));
                let covariance = Matrix3::from(*odometer.covariance());
                prop_assert!(covariance.iter().chain(motion.iter()).all(|value| value.is_finite()));
            }
        }
    }
}
