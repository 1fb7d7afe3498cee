//! What the robot must not be asked for. A velocity beyond a limit is refused, never trimmed: who
//! asked shall know. One that is within them and still too fast for a wheel, such as forward and
//! turning at once, is slowed down as a whole, so that its direction stays.

use protocol::{ChassisRefusal, Drive};

use crate::{
    kinematics::{Velocity, WheelSpeeds},
    parameters::Limits,
};

/// The velocity of a command, if it is within the limits.
///
/// # Errors
/// [`ChassisRefusal`] names the first limit that it is beyond. (A frame with a NaN in it is no
/// message: see [`protocol::units`].)
pub fn check(limits: &Limits, drive: &Drive) -> Result<Velocity, ChassisRefusal> {
    let velocity = Velocity::new(drive.twist.vx.get(), drive.twist.vy.get(), drive.twist.wz.get());
    let refusals = [
        (velocity.x.abs() <= limits.forward_mps, ChassisRefusal::ForwardSpeed),
        (velocity.y.abs() <= limits.sideways_mps, ChassisRefusal::SidewaysSpeed),
        (velocity.z.abs() <= limits.turn_radps, ChassisRefusal::TurnRate),
        (drive.ttl.0 > 0 && drive.ttl <= limits.ttl, ChassisRefusal::TimeToLive),
    ];
    match refusals.into_iter().find(|(within, _)| !within) {
        Some((_, refusal)) => Err(refusal),
        None => Ok(velocity),
    }
}

/// The same direction, but with no wheel faster than its limit.
#[must_use]
pub fn slow_down(limits: &Limits, wheels: WheelSpeeds) -> WheelSpeeds {
    let fastest = wheels.amax();
    if fastest > limits.wheel_mps { wheels * (limits.wheel_mps / fastest) } else { wheels }
}

#[cfg(test)]
mod tests {
    use protocol::{CommandId, DurationMs, RobotId, SpeedMps, TurnRateRadps, Twist};

    use super::*;
    use crate::{kinematics::Kinematics, parameters::Parameters};

    const LIMITS: Limits = Parameters::new(RobotId(1)).limits;

    fn checked(vx: f32, vy: f32, wz: f32, ttl: u32) -> Result<Velocity, ChassisRefusal> {
        let twist =
            Twist { vx: SpeedMps::clamped(vx), vy: SpeedMps::clamped(vy), wz: TurnRateRadps::clamped(wz) };
        check(&LIMITS, &Drive { command: CommandId(1), ttl: DurationMs(ttl), twist })
    }

    #[test]
    fn what_is_beyond_a_limit_is_refused_by_name_and_what_is_at_it_is_not() {
        assert_eq!(checked(0.8, -0.8, 4.0, 1_000), Ok(Velocity::new(0.8, -0.8, 4.0)));
        assert_eq!(checked(-0.81, 0.0, 0.0, 200), Err(ChassisRefusal::ForwardSpeed));
        assert_eq!(checked(0.0, 0.81, 0.0, 200), Err(ChassisRefusal::SidewaysSpeed));
        assert_eq!(checked(0.0, 0.0, -4.01, 200), Err(ChassisRefusal::TurnRate));
        assert_eq!(checked(0.0, 0.0, 0.0, 0), Err(ChassisRefusal::TimeToLive));
        assert_eq!(checked(0.0, 0.0, 0.0, 1_001), Err(ChassisRefusal::TimeToLive));
    }

    #[test]
    fn a_command_too_fast_for_a_wheel_keeps_its_direction() {
        let kinematics = Kinematics::new(0.2, 0.2);
        let asked = Velocity::new(0.8, 0.4, 2.0);
        let wheels = slow_down(&LIMITS, kinematics.wheels(&asked));
        assert!((wheels.amax() - LIMITS.wheel_mps).abs() < 1e-6);
        // The fastest wheel was to do 0.8 + 0.4 + 2.0 * 0.2 = 1.6 m/s.
        assert!((kinematics.twist(&wheels) - asked / 1.6).amax() < 1e-6);
    }
}
