//! What differs from robot to robot.

use firmware_common::{
    passes::{self, PassRule},
    presence::RssiBand,
};
use protocol::{BootEpoch, DurationMs, RobotId};

use crate::{kinematics, passing::PassParameters, ramp::RampRule};

/// Why the chassis has just started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// It was switched on, reset or flashed.
    PowerOn,
    /// Its watchdog has restarted it.
    Watchdog,
}

/// Where the wheels are and how their encoders count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry {
    /// From the front wheels' centres to the rear ones' (H), in m.
    pub wheelbase_m: f32,
    /// From the left wheels' centres to the right ones' (W), in m.
    pub track_m: f32,
    /// Of the wheels, in m.
    pub wheel_diameter_m: f32,
    /// Encoder counts a turn of the shaft it sits on, all four edges counted.
    pub counts_per_turn: f32,
    /// Turns of that shaft a turn of the wheel.
    pub turns_per_wheel_turn: f32,
}

impl Geometry {
    /// The paper's robot (Mecanum III.C.2): wheels of 7 cm, 400 counts a turn, gear 1:30. It
    /// prints no H and W; 20 cm each are ours. Its encoder sits on the motor's shaft, as it does in
    /// the MG513P30 that it names: only so is the increment of 0.01 m/s above the resolution of a
    /// count a tick (1.8 mm/s), which the paper asks of it.
    pub const PAPER: Self = Self {
        wheelbase_m: 0.20,
        track_m: 0.20,
        wheel_diameter_m: 0.07,
        counts_per_turn: 400.0,
        turns_per_wheel_turn: 30.0,
    };

    /// The same robot by the letter of the text: 400 counts a turn of the wheel, so that a count
    /// a tick is 55 mm/s.
    pub const PAPER_LITERAL: Self = Self { turns_per_wheel_turn: 1.0, ..Self::PAPER };

    /// How far a wheel rolls for a count, in m.
    #[must_use]
    pub const fn metres_per_count(&self) -> f32 {
        core::f32::consts::PI * self.wheel_diameter_m / (self.counts_per_turn * self.turns_per_wheel_turn)
    }

    /// H/2 + W/2, in m.
    #[must_use]
    pub fn lever_arm_m(&self) -> f32 {
        kinematics::lever_arm_m(self.wheelbase_m, self.track_m)
    }
}

/// A wheel's motor with its gear, driver and load, as a first-order system.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motor {
    /// Rim speed at full duty and nominal voltage, nothing rubbing, in m/s.
    pub free_speed_mps: f32,
    /// How long it takes to 63 % of a new speed, in s.
    pub time_constant_s: f32,
    /// The duty that friction eats.
    pub friction_duty: f32,
    /// Of the battery, in V, for which this holds.
    pub nominal_v: f32,
    /// What it draws at full duty when it cannot turn, in A.
    pub stall_current_a: f32,
}

/// Gains of the speed control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    /// Duty for each m/s of error.
    pub proportional: f32,
    /// Duty a second for each m/s of error.
    pub integral: f32,
}

/// What no command can exceed. The limit of acceleration is [`crate::ramp::INCREMENT_MPS`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Forward or backward, in m/s; more is refused.
    pub forward_mps: f32,
    /// To a side, in m/s; more is refused.
    pub sideways_mps: f32,
    /// Turn rate, in rad/s; more is refused.
    pub turn_radps: f32,
    /// Of every wheel, in m/s; a command that needs more is slowed down as a whole.
    pub wheel_mps: f32,
    /// Time to live of a drive command; more is refused.
    pub ttl: DurationMs,
}

/// How far measurements are trusted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Variance of a wheel's way for each metre of it, in m.
    pub rolling_m: f32,
    /// By this factor that grows while a wheel slips.
    pub slipping: f32,
    /// Standard deviation of the gyroscope's rate, bias taken out, in rad/s.
    pub gyro_radps: f32,
}

/// The battery's size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pack {
    /// What it holds when full, in J (g_full).
    pub full_j: f32,
    /// Its open-circuit voltage when full, in V.
    pub full_v: f32,
    /// Its open-circuit voltage when empty, in V.
    pub empty_v: f32,
    /// Its inner resistance, in ohm.
    pub resistance_ohm: f32,
    /// What the robot draws beside its motors, in A.
    pub idle_a: f32,
}

/// A chassis' parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// The robot it carries.
    pub robot: RobotId,
    /// Counts its starts.
    pub boot: BootEpoch,
    /// Why it has just started.
    pub start: Start,
    /// Wheels and encoders.
    pub geometry: Geometry,
    /// The motors.
    pub motor: Motor,
    /// The speed control.
    pub gains: Gains,
    /// What no command can exceed.
    pub limits: Limits,
    /// How set-points change.
    pub ramp: RampRule,
    /// How far measurements are trusted.
    pub noise: Noise,
    /// The battery.
    pub pack: Pack,
    /// How passes of piles are counted.
    pub passes: PassParameters,
}

impl Parameters {
    /// The paper's robot with motors of 366 rpm at 12 V and three lithium cells of 5.2 Ah.
    #[must_use]
    pub const fn new(robot: RobotId) -> Self {
        Self {
            robot,
            boot: BootEpoch(0),
            start: Start::PowerOn,
            geometry: Geometry::PAPER,
            motor: Motor {
                free_speed_mps: 1.34,
                time_constant_s: 0.08,
                friction_duty: 0.06,
                nominal_v: 12.0,
                stall_current_a: 3.2,
            },
            gains: Gains { proportional: 0.6, integral: 5.0 },
            limits: Limits {
                forward_mps: 0.8,
                sideways_mps: 0.8,
                turn_radps: 4.0,
                wheel_mps: 1.0,
                ttl: DurationMs(1_000),
            },
            ramp: RampRule::Together,
            noise: Noise { rolling_m: 1e-4, slipping: 100.0, gyro_radps: 0.003 },
            pack: Pack { full_j: 208_000.0, full_v: 12.6, empty_v: 9.6, resistance_ohm: 0.1, idle_a: 0.5 },
            passes: PassParameters {
                rule: PassRule::PerApproach {
                    band: RssiBand { enter_dbm: -70, leave_dbm: -76 },
                    dwell: passes::DWELL,
                    gap: DurationMs(3_000),
                },
                period: DurationMs(2 * 3_600_000),
                periods: 12,
            },
        }
    }

    /// Whether a chassis can be made of these.
    ///
    /// # Errors
    /// The first that is not in its range.
    pub fn check(&self) -> Result<(), ParameterError> {
        let Self { geometry, motor, gains, limits, noise, pack, .. } = self;
        for (name, value, min, max) in [
            ("geometry.wheelbase_m", geometry.wheelbase_m, 0.01, 10.0),
            ("geometry.track_m", geometry.track_m, 0.01, 10.0),
            ("geometry.wheel_diameter_m", geometry.wheel_diameter_m, 0.01, 1.0),
            ("geometry.counts_per_turn", geometry.counts_per_turn, 1.0, 1e5),
            ("geometry.turns_per_wheel_turn", geometry.turns_per_wheel_turn, 0.1, 1e3),
            ("motor.free_speed_mps", motor.free_speed_mps, 0.01, 10.0),
            ("motor.time_constant_s", motor.time_constant_s, 0.001, 10.0),
            ("motor.friction_duty", motor.friction_duty, 0.0, 0.5),
            ("motor.nominal_v", motor.nominal_v, 1.0, 100.0),
            ("motor.stall_current_a", motor.stall_current_a, 0.01, 100.0),
            ("gains.proportional", gains.proportional, 0.0, 100.0),
            ("gains.integral", gains.integral, 0.0, 1e3),
            ("limits.forward_mps", limits.forward_mps, 0.0, 10.0),
            ("limits.sideways_mps", limits.sideways_mps, 0.0, 10.0),
            ("limits.turn_radps", limits.turn_radps, 0.0, 100.0),
            ("limits.wheel_mps", limits.wheel_mps, 0.01, 10.0),
            ("noise.rolling_m", noise.rolling_m, 0.0, 1.0),
            ("noise.slipping", noise.slipping, 1.0, 1e6),
            ("noise.gyro_radps", noise.gyro_radps, 1e-6, 1.0),
            ("pack.full_j", pack.full_j, 1.0, 1e9),
            ("pack.full_v", pack.full_v, 1.0, 100.0),
            ("pack.empty_v", pack.empty_v, 0.0, pack.full_v - 0.1),
            ("pack.resistance_ohm", pack.resistance_ohm, 0.0, 10.0),
            ("pack.idle_a", pack.idle_a, 0.0, 100.0),
        ] {
            if !(min..=max).contains(&value) {
                return Err(ParameterError { name, value, min, max });
            }
        }
        Ok(())
    }
}

/// A parameter is no number in its range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("parameter {name} must be a number from {min} to {max}, not {value}: correct it and flash again")]
pub struct ParameterError {
    /// Which.
    pub name: &'static str,
    /// What it is.
    pub value: f32,
    /// The least it may be.
    pub min: f32,
    /// The most it may be.
    pub max: f32,
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROBOT: Parameters = Parameters::new(RobotId(1));

    #[test]
    fn the_papers_encoder_resolves_the_increment_on_the_motor_and_not_on_the_wheel() {
        let count_a_tick = |geometry: Geometry| geometry.metres_per_count() / crate::TICK_S;
        assert!((count_a_tick(Geometry::PAPER) - 0.001_833).abs() < 1e-6);
        assert!((count_a_tick(Geometry::PAPER_LITERAL) - 0.054_98).abs() < 1e-5);
    }

    #[test]
    fn a_parameter_that_would_divide_by_zero_or_is_no_number_is_named() {
        assert_eq!(ROBOT.check(), Ok(()));
        let wrong = Parameters { geometry: Geometry { track_m: 0.0, ..Geometry::PAPER }, ..ROBOT };
        assert_eq!(wrong.check().map_err(|error| error.name), Err("geometry.track_m"));
        let wrong = Parameters { gains: Gains { integral: f32::NAN, ..ROBOT.gains }, ..ROBOT };
        assert_eq!(wrong.check().map_err(|error| error.name), Err("gains.integral"));
    }
}
