//! Wheel speeds and the robot's motion, as matrices (Mecanum eqs. 1, 2).
//!
//! The paper numbers the wheels A, B, C, D. Its signs are those of REP 103 (x forward, y left,
//! turns counter-clockwise) if A is the wheel at the rear left and the others follow clockwise
//! seen from above, with rollers as on any Mecanum chassis, whose diagonals meet in the middle:
//!
//! ```text
//!            x
//!   B \      ^      / C        A rear left     B front left
//!        y <-+                 D rear right    C front right
//!   A /             \ D
//! ```
//!
//! Eq. 1 makes wheel speeds of the robot's motion. Eq. 2, the way back, lacks in V_z the division
//! by H/2 + W/2 (decision 11): only with it does the way there and back end where it began, which
//! [`Kinematics::twist`] does. [`literal_twist`] is eq. 2 as printed.
//!
//! Four wheels move a body with three degrees of freedom, so that their speeds can contradict each
//! other in one way, [`slip_speed`]: the fourth vector beside the three columns of eq. 1.
//!
//! All of this holds for speeds as well as for the distances of one tick.

use nalgebra::{SMatrix, Vector3, Vector4};

use crate::covariance::PlaneCovariance;

/// Speeds of the wheels A, B, C, D over ground, in m/s, or distances in m; forward is positive.
pub type WheelSpeeds = Vector4<f32>;
/// The robot's velocity in its own frame: forward in m/s, left in m/s, counter-clockwise in rad/s.
/// Or the motion of a tick, in m, m and rad.
pub type Velocity = Vector3<f32>;

/// The geometry of a chassis as two matrices.
#[derive(Clone, Debug, PartialEq)]
pub struct Kinematics {
    to_wheels: SMatrix<f32, 4, 3>,
    to_twist: SMatrix<f32, 3, 4>,
}

impl Kinematics {
    /// The matrices for wheels whose centres are `wheelbase_m` (H) apart from front to rear and
    /// `track_m` (W) from left to right. The sum of both must be above zero.
    #[must_use]
    pub fn new(wheelbase_m: f32, track_m: f32) -> Self {
        let arm = lever_arm_m(wheelbase_m, track_m);
        #[rustfmt::skip]
        let to_wheels = SMatrix::<f32, 4, 3>::new(
            1.0,  1.0, -arm,
            1.0, -1.0, -arm,
            1.0,  1.0,  arm,
            1.0, -1.0,  arm,
        );
        // The columns are orthogonal, so that the pseudo-inverse is the transpose with each row
        // divided by its column's square length.
        let (q, r) = (0.25, 0.25 / arm);
        #[rustfmt::skip]
        let to_twist = SMatrix::<f32, 3, 4>::new(
             q,  q, q,  q,
             q, -q, q, -q,
            -r, -r, r,  r,
        );
        Self { to_wheels, to_twist }
    }

    /// The wheel speeds that give a velocity (eq. 1).
    #[must_use]
    pub fn wheels(&self, velocity: &Velocity) -> WheelSpeeds {
        self.to_wheels * velocity
    }

    /// The velocity that wheel speeds give: the best fit if they contradict each other (eq. 2 with
    /// decision 11).
    #[must_use]
    pub fn twist(&self, wheels: &WheelSpeeds) -> Velocity {
        self.to_twist * wheels
    }

    /// The covariance of [`Self::twist`] of wheels with these variances, in m² if the wheels' are:
    /// the matrix of eq. 2 times theirs times its transpose. Its entries are equal but for their
    /// signs, so that only sums of the variances are left.
    #[must_use]
    pub fn twist_covariance(&self, wheels: &WheelSpeeds) -> PlaneCovariance {
        let [a, b, c, d] = (*wheels).into();
        let (way, turn) = (self.to_twist.m11, self.to_twist.m34);
        let all = a + b + c + d;
        PlaneCovariance {
            xx: way * way * all,
            xy: way * way * (a - b + c - d),
            xyaw: way * turn * (c + d - a - b),
            yy: way * way * all,
            yyaw: way * turn * (b + c - a - d),
            yawyaw: turn * turn * all,
        }
    }
}

/// H/2 + W/2: how far a wheel rolls for a radian of turn, in m.
#[must_use]
pub fn lever_arm_m(wheelbase_m: f32, track_m: f32) -> f32 {
    0.5 * wheelbase_m + 0.5 * track_m
}

/// Eq. 2 as printed: its third component is a speed and no turn rate.
#[must_use]
pub fn literal_twist(wheels: &WheelSpeeds) -> Velocity {
    let [a, b, c, d] = (*wheels).into();
    Velocity::new((a + b + c + d) / 4.0, (a - b + c - d) / 4.0, (-a - b + c + d) / 4.0)
}

/// By how much the wheels contradict each other, in m/s: zero as long as all four roll.
#[must_use]
pub fn slip_speed(wheels: &WheelSpeeds) -> f32 {
    let [a, b, c, d] = (*wheels).into();
    (a - b - c + d) / 4.0
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn velocity() -> impl Strategy<Value = Velocity> {
        (-2.0f32..2.0, -2.0f32..2.0, -10.0f32..10.0).prop_map(|(x, y, z)| Velocity::new(x, y, z))
    }

    #[test]
    fn a_robot_moves_as_the_arrows_of_a_mecanum_chassis_say() {
        let kinematics = Kinematics::new(0.3, 0.1);
        let wheels = |x, y, z| <[f32; 4]>::from(kinematics.wheels(&Velocity::new(x, y, z)));
        assert_eq!(wheels(1.0, 0.0, 0.0), [1.0, 1.0, 1.0, 1.0]);
        // To the left: rear left and front right push forward, the others back.
        assert_eq!(wheels(0.0, 1.0, 0.0), [1.0, -1.0, 1.0, -1.0]);
        // Counter-clockwise: the left side goes back.
        assert_eq!(wheels(0.0, 0.0, 1.0), [-0.2, -0.2, 0.2, 0.2]);
    }

    #[test]
    fn eq_2_as_printed_gives_a_speed_instead_of_a_turn_rate() {
        let kinematics = Kinematics::new(0.3, 0.1);
        let velocity = Velocity::new(0.5, -0.25, 2.0);
        let literal = literal_twist(&kinematics.wheels(&velocity));
        assert!((literal - Velocity::new(0.5, -0.25, 2.0 * 0.2)).amax() < 1e-6);
    }

    proptest! {
        #[test]
        fn wheel_speeds_of_a_velocity_give_that_velocity_again(
            wheelbase in 0.05f32..2.0, track in 0.05f32..2.0, velocity in velocity(),
        ) {
            let kinematics = Kinematics::new(wheelbase, track);
            let wheels = kinematics.wheels(&velocity);
            prop_assert!((kinematics.twist(&wheels) - velocity).amax() < 1e-4);
            prop_assert!(slip_speed(&wheels).abs() < 1e-4);
        }

        #[test]
        fn a_twists_covariance_is_what_the_matrix_makes_of_the_wheels_variances(
            wheelbase in 0.05f32..2.0, track in 0.05f32..2.0, variances in prop::array::uniform4(0.0f32..1.0),
        ) {
            let kinematics = Kinematics::new(wheelbase, track);
            let wheels = WheelSpeeds::from(variances);
            let expected =
                kinematics.to_twist * SMatrix::from_diagonal(&wheels) * kinematics.to_twist.transpose();
            let covariance = nalgebra::Matrix3::from(kinematics.twist_covariance(&wheels));
            prop_assert!((covariance - expected).amax() <= 1e-5 * expected.amax());
        }

        #[test]
        fn what_a_slipping_wheel_adds_is_seen_as_slip(velocity in velocity(), slip in -1.0f32..1.0) {
            let kinematics = Kinematics::new(0.2, 0.2);
            let mut wheels = kinematics.wheels(&velocity);
            wheels[1] += slip;
            prop_assert!((slip_speed(&wheels) + slip / 4.0).abs() < 1e-4);
        }

        #[test]
        fn the_literal_and_the_corrected_way_back_differ_by_the_lever_arm_only(
            wheelbase in 0.05f32..2.0, track in 0.05f32..2.0, wheels: [i8; 4],
        ) {
            let wheels = WheelSpeeds::from(wheels.map(|wheel| f32::from(wheel) / 64.0));
            let (literal, twist) = (literal_twist(&wheels), Kinematics::new(wheelbase, track).twist(&wheels));
            prop_assert!((literal.xy() - twist.xy()).amax() < 1e-5);
            prop_assert!((literal.z - twist.z * lever_arm_m(wheelbase, track)).abs() < 1e-4);
        }
    }
}
