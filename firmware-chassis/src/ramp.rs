//! How set-points change: by at most [`INCREMENT_MPS`] a tick (Mecanum III.C.2), so that wheels
//! keep their grip and the robot its shape of motion.

use crate::kinematics::WheelSpeeds;

/// The paper's increment: the most a wheel's set-point changes in a tick, in m/s. At 100 Hz this
/// is an acceleration of 1 m/s².
pub const INCREMENT_MPS: f32 = 0.01;

/// Which wheels wait for which.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RampRule {
    /// The paper's letter: each wheel steps for itself. Wheels with a short way arrive early, and
    /// the direction of travel bends until the last has arrived.
    PerWheel,
    /// All steps are scaled by one factor, so that all wheels arrive together: between two
    /// velocities the robot passes through those on the straight line between them, and from
    /// standstill the direction of travel is the commanded one from the first tick.
    #[default]
    Together,
}

/// The set-points of all wheels on their way.
#[derive(Clone, Debug, PartialEq)]
pub struct Ramp {
    rule: RampRule,
    setpoints: WheelSpeeds,
}

impl Ramp {
    /// A ramp at standstill.
    #[must_use]
    pub fn new(rule: RampRule) -> Self {
        Self { rule, setpoints: WheelSpeeds::zeros() }
    }

    /// The set-points now, in m/s.
    #[must_use]
    pub const fn setpoints(&self) -> &WheelSpeeds {
        &self.setpoints
    }

    /// Back to standstill, as the motors brake and nothing is set.
    pub fn reset(&mut self) {
        self.setpoints = WheelSpeeds::zeros();
    }

    /// One tick towards `target`, which must be finite. Answers the step, in m/s.
    pub fn advance(&mut self, target: &WheelSpeeds) -> WheelSpeeds {
        let missing = target - self.setpoints;
        let farthest = missing.amax();
        let before = self.setpoints;
        if farthest <= INCREMENT_MPS {
            self.setpoints = *target;
        } else {
            self.setpoints += match self.rule {
                RampRule::PerWheel => missing.map(|way| way.clamp(-INCREMENT_MPS, INCREMENT_MPS)),
                RampRule::Together => missing * (INCREMENT_MPS / farthest),
            };
        }
        self.setpoints - before
    }
}

#[cfg(test)]
mod tests {
    use proptest::{collection::vec, prelude::*};

    use super::*;
    use crate::kinematics::{Kinematics, Velocity};

    /// What rounding may add to a step at up to 4 m/s.
    const ROUNDING: f32 = 4.0 * f32::EPSILON;

    fn speeds() -> impl Strategy<Value = WheelSpeeds> {
        prop::array::uniform4(-2.0f32..2.0).prop_map(WheelSpeeds::from)
    }

    fn ramp() -> impl Strategy<Value = Ramp> {
        prop_oneof![Just(RampRule::PerWheel), Just(RampRule::Together)].prop_map(Ramp::new)
    }

    #[test]
    fn the_papers_letter_bends_the_way_and_the_default_does_not() {
        // 0.3 m/s forward and 0.1 m/s to the left: wheels 0.4, 0.2, 0.4, 0.2 m/s.
        let kinematics = Kinematics::new(0.2, 0.2);
        let target = kinematics.wheels(&Velocity::new(0.3, 0.1, 0.0));
        let direction_after = |rule, ticks| {
            let mut ramp = Ramp::new(rule);
            for _ in 0..ticks {
                ramp.advance(&target);
            }
            let velocity = kinematics.twist(ramp.setpoints());
            velocity.y.atan2(velocity.x)
        };
        let wanted = 0.1f32.atan2(0.3);
        // Each for itself, all wheels run at one speed at first: straight ahead.
        assert!(direction_after(RampRule::PerWheel, 20).abs() < 1e-3);
        for ticks in 1..=40 {
            assert!((direction_after(RampRule::Together, ticks) - wanted).abs() < 1e-4, "{ticks}");
        }
        // Both take as many ticks as the wheel with the longest way.
        for rule in [RampRule::PerWheel, RampRule::Together] {
            assert!((direction_after(rule, 40) - wanted).abs() < 1e-4);
        }
    }

    proptest! {
        #[test]
        fn no_set_point_steps_by_more_than_the_increment(
            mut ramp in ramp(), targets in vec((speeds(), 0..100u8), 1..10),
        ) {
            for (target, ticks) in targets {
                for _ in 0..ticks {
                    let before = *ramp.setpoints();
                    let step = ramp.advance(&target);
                    prop_assert!(step.amax() <= INCREMENT_MPS + ROUNDING, "{step}");
                    prop_assert_eq!(ramp.setpoints() - before, step);
                }
            }
        }

        #[test]
        fn every_target_is_reached_in_the_ticks_its_farthest_wheel_needs(
            mut ramp in ramp(), from in speeds(), to in speeds(),
        ) {
            for target in [from, to] {
                let ticks = ((target - ramp.setpoints()).amax() / INCREMENT_MPS).ceil() as u32 + 1;
                for _ in 0..ticks {
                    ramp.advance(&target);
                }
                prop_assert_eq!(ramp.setpoints(), &target);
            }
        }

        #[test]
        fn together_the_wheels_stay_on_the_straight_line_to_the_target(from in speeds(), to in speeds()) {
            let mut ramp = Ramp { rule: RampRule::Together, setpoints: from };
            let way = to - from;
            for _ in 0..400 {
                ramp.advance(&to);
                let along = (ramp.setpoints() - from).dot(&way) / way.norm_squared().max(1e-9);
                prop_assert!((ramp.setpoints() - from - way * along).amax() < 1e-4);
            }
        }
    }
}
