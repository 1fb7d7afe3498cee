//! The duty that makes a wheel follow its set-point: what the motor needs for it by its model
//! (feed-forward), and a PI control of what is left, with anti-windup.
//!
//! By the model of [`Motor`], tau v' + v = v_free (duty - friction), a duty held for a tick T takes
//! a wheel from speed a to b if v_free (duty - friction) = a + (b - a) / (1 - exp(-T / tau)). That is
//! the feed-forward: alone, it follows a ramp without lag. What the model gets wrong decays by
//! tau s² + (1 + v_free kp) s + v_free ki = 0: with the default gains s = -4.7/s and -17.8/s, both
//! real, so that nothing rings.

use crate::{
    TICK_S,
    parameters::{Gains, Motor},
};

/// Slower than this a wheel whose set-point is zero is left alone, so that no duty hums in a wheel
/// at rest, in m/s.
const REST_MPS: f32 = 0.005;

/// One wheel's control: what its model was found to get wrong, as a duty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WheelControl {
    integral: f32,
}

/// What a wheel shall do and does.
#[derive(Clone, Copy, Debug)]
pub struct WheelState {
    /// The speed to reach by the end of the tick that begins, in m/s.
    pub setpoint_mps: f32,
    /// By how much that is more than the last, in m/s.
    pub step_mps: f32,
    /// The measured speed at the tick's beginning, in m/s.
    pub speed_mps: f32,
}

/// The law that all wheels follow.
#[derive(Clone, Debug, PartialEq)]
pub struct ControlLaw {
    motor: Motor,
    gains: Gains,
    /// 1 / (1 - exp(-T / tau)): how much farther than the tick's step the motor has to aim.
    aim: f32,
}

impl ControlLaw {
    /// The law for these motors.
    #[must_use]
    pub fn new(motor: Motor, gains: Gains) -> Self {
        Self { motor, gains, aim: 1.0 / (1.0 - libm::expf(-TICK_S / motor.time_constant_s)) }
    }
}

impl WheelControl {
    /// Nothing to correct yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { integral: 0.0 }
    }

    /// Forgets what it had to correct.
    pub fn reset(&mut self) {
        self.integral = 0.0;
    }

    /// The duty for this tick, -1 to 1. `boost` is the nominal over the present supply voltage.
    pub fn duty(&mut self, law: &ControlLaw, wheel: WheelState, boost: f32) -> f32 {
        let ControlLaw { motor, gains, aim } = law;
        let WheelState { setpoint_mps, step_mps, speed_mps } = wheel;
        if setpoint_mps == 0.0 && speed_mps.abs() < REST_MPS {
            self.reset();
            return 0.0;
        }
        let friction = if setpoint_mps == 0.0 { 0.0 } else { motor.friction_duty.copysign(setpoint_mps) };
        let due_mps = setpoint_mps - step_mps;
        let error = due_mps - speed_mps;
        let forward = (due_mps + aim * step_mps) / motor.free_speed_mps + friction;
        let wanted = boost * (forward + gains.proportional * error + self.integral);
        let duty = wanted.clamp(-1.0, 1.0);
        // Anti-windup: at the limit, only what leads back from it is summed up.
        if wanted == duty || (wanted - duty) * error < 0.0 {
            self.integral = (self.integral + gains.integral * error * TICK_S).clamp(-1.0, 1.0);
        }
        duty
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use protocol::RobotId;

    use super::*;
    use crate::parameters::Parameters;

    const ROBOT: Parameters = Parameters::new(RobotId(1));

    fn law() -> ControlLaw {
        ControlLaw::new(ROBOT.motor, ROBOT.gains)
    }

    fn duty(control: &mut WheelControl, setpoint_mps: f32, speed_mps: f32) -> f32 {
        control.duty(&law(), WheelState { setpoint_mps, step_mps: 0.0, speed_mps }, 1.0)
    }

    #[test]
    fn a_wheel_that_follows_gets_what_its_model_says() {
        let mut control = WheelControl::new();
        assert!((duty(&mut control, 0.67, 0.67) - (0.5 + 0.06)).abs() < 1e-6);
        assert!((duty(&mut control, -0.67, -0.67) + (0.5 + 0.06)).abs() < 1e-6);
    }

    #[test]
    fn on_a_ramp_the_model_s_motor_reaches_every_set_point_at_the_end_of_its_tick() {
        let (mut control, mut speed) = (WheelControl::new(), 0.0f32);
        for tick in 1..=50_u8 {
            let setpoint_mps = 0.01 * f32::from(tick);
            let wheel = WheelState { setpoint_mps, step_mps: 0.01, speed_mps: speed };
            let duty = control.duty(&law(), wheel, 1.0) - ROBOT.motor.friction_duty;
            let end = ROBOT.motor.free_speed_mps * duty;
            speed = end + (speed - end) * (-TICK_S / ROBOT.motor.time_constant_s).exp();
            assert!((speed - setpoint_mps).abs() < 1e-5, "tick {tick}: {speed}");
        }
    }

    #[test]
    fn a_lower_supply_gets_a_higher_duty() {
        let wheel = WheelState { setpoint_mps: 0.67, step_mps: 0.0, speed_mps: 0.67 };
        let low = WheelControl::new().duty(&law(), wheel, 12.0 / 10.0);
        assert!((low - 0.56 * 1.2).abs() < 1e-6);
    }

    #[test]
    fn a_wheel_held_fast_for_a_minute_is_not_wound_up() {
        let mut control = WheelControl::new();
        for _ in 0..6_000 {
            assert!(duty(&mut control, 0.5, 0.0) <= 1.0);
        }
        // Free again and as fast as it shall be: the duty comes off its limit at once.
        assert!(duty(&mut control, 0.5, 0.5) < 1.0);
        let settled = (0..100).map(|_| duty(&mut control, 0.5, 0.6)).last().unwrap();
        assert!(settled < 0.5);
    }

    #[test]
    fn a_wheel_at_rest_gets_nothing() {
        let mut control = WheelControl::new();
        duty(&mut control, 0.0, 0.3);
        assert_eq!(duty(&mut control, 0.0, 0.001), 0.0);
        assert_eq!(control, WheelControl::new());
    }

    proptest! {
        #[test]
        fn every_duty_is_a_share_of_the_supply(
            wheels in prop::collection::vec((-2.0f32..2.0, -0.01f32..0.01, -1e5f32..1e5), 1..100),
            boost in 0.5f32..2.0,
        ) {
            let mut control = WheelControl::new();
            for (setpoint_mps, step_mps, speed_mps) in wheels {
                let wheel = WheelState { setpoint_mps, step_mps, speed_mps };
                let duty = control.duty(&law(), wheel, boost);
                prop_assert!((-1.0..=1.0).contains(&duty));
            }
        }
    }
}
