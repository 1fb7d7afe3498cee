//! Every stop has its way and its name.

use firmware_chassis::{Chassis, Input, Motors, Parameters, Start, Velocity};
use protocol::*;

use crate::bench::{Bench, ROBOT, refused};

const AHEAD: Velocity = Velocity::new(0.5, 0.0, 0.0);

fn driving() -> Bench {
    let mut bench = Bench::new();
    bench.keep_driving(AHEAD, 1.0, |_| {});
    assert_eq!(bench.told(), (ChassisMode::Driving, None));
    bench
}

/// How far the robot goes until it stands.
fn stopping_way_m(bench: &mut Bench) -> f32 {
    let from = bench.plant.pose();
    bench.wait(2.0);
    assert_eq!(bench.plant.velocity().norm(), 0.0);
    let to = bench.plant.pose();
    (to.x - from.x).hypot(to.y - from.y)
}

#[test]
fn a_start_and_a_watchdog_s_restart_are_told_apart() {
    for (start, reason) in [(Start::PowerOn, StopReason::Started), (Start::Watchdog, StopReason::Watchdog)] {
        let mut bench = Bench::with(Parameters { start, ..ROBOT });
        assert_eq!(bench.told(), (ChassisMode::Braked, Some(reason)));
        bench.keep_driving(AHEAD, 0.1, |_| {});
        assert_eq!(bench.told(), (ChassisMode::Driving, None));
    }
}

#[test]
fn a_command_that_outlives_its_time_ramps_to_a_stop() {
    let mut bench = driving();
    // The last command was 90 ms ago; the ramp down is 0.5 s long and takes 0.125 m.
    let way = stopping_way_m(&mut bench);
    assert!((way - (0.11 * 0.5 + 0.125)).abs() < 0.01, "{way}");
    assert_eq!(bench.told(), (ChassisMode::Braked, Some(StopReason::LinkSilent)));
}

#[test]
fn a_link_that_only_brings_damage_is_called_so() {
    let mut bench = driving();
    for _ in 0..50 {
        bench.step(Input::Discarded(FrameError::Crc));
        bench.tick();
    }
    assert_eq!(bench.told().1, Some(StopReason::LinkCorrupted));
    // Damage between good frames is weather.
    let mut bench = driving();
    bench.step(Input::Discarded(FrameError::Crc));
    bench.keep_driving(AHEAD, 1.0, |_| {});
    assert_eq!(bench.told(), (ChassisMode::Driving, None));
    bench.wait(0.5);
    assert_eq!(bench.told().1, Some(StopReason::LinkSilent));
}

#[test]
fn a_stop_ramps_and_an_emergency_stop_brakes_at_once() {
    let mut bench = driving();
    assert_eq!(bench.stop(false), Ok(()));
    let ramped = stopping_way_m(&mut bench);
    assert_eq!(bench.told(), (ChassisMode::Braked, Some(StopReason::Commanded)));

    let mut bench = driving();
    assert_eq!(bench.stop(true), Ok(()));
    assert_eq!(bench.motors, Motors::Brake, "in the same step");
    let braked = stopping_way_m(&mut bench);
    assert_eq!(bench.told(), (ChassisMode::Braked, Some(StopReason::Emergency)));

    // 0.5 s of ramp; against a shorted motor's time constant of 0.08 s with friction of 0.08 m/s,
    // v(t) = 0.58 exp(-t / tau) - 0.08 until t = 0.158 s: 0.08 x 0.5 - 0.08 x 0.158 = 0.027 m.
    println!("ramped {ramped} m, braked {braked} m");
    assert!((ramped - 0.125).abs() < 0.006, "{ramped}");
    assert!((braked - 0.027).abs() < 0.003, "{braked}");
}

#[test]
fn an_emergency_stop_is_held_until_released_at_rest() {
    let mut bench = driving();
    assert_eq!(bench.stop(true), Ok(()));
    assert_eq!(bench.release(), refused(ChassisRefusal::Moving));
    bench.wait(1.0);
    let by = StopReason::Emergency;
    assert_eq!(bench.drive(AHEAD, limits::DRIVE_TTL), refused(ChassisRefusal::Stopped { by }));
    assert_eq!(bench.stop(false), Ok(()));
    assert_eq!(bench.drive(AHEAD, limits::DRIVE_TTL), refused(ChassisRefusal::Stopped { by }));
    assert_eq!(bench.release(), Ok(()));
    bench.wait(0.5);
    assert_eq!(bench.plant.velocity().norm(), 0.0, "a release moves nothing");
    bench.keep_driving(AHEAD, 1.0, |_| {});
    assert!((bench.plant.velocity().x - 0.5).abs() < 0.01);
}

#[test]
fn a_link_lost_in_the_middle_of_a_ramp_turns_the_ramp_round() {
    let mut bench = Bench::new();
    assert_eq!(bench.drive(AHEAD, limits::DRIVE_TTL), Ok(()));
    let mut fastest = 0.0f32;
    for _ in 0..100 {
        bench.tick();
        fastest = fastest.max(bench.plant.velocity().x);
    }
    // 200 ms at 1 m/s².
    assert!((fastest - 0.2).abs() < 0.015, "{fastest}");
    assert_eq!(bench.plant.velocity().norm(), 0.0);
    assert_eq!(bench.told(), (ChassisMode::Braked, Some(StopReason::LinkSilent)));
}

#[test]
fn parameters_that_cannot_work_make_no_chassis() {
    let mut wrong = ROBOT;
    wrong.motor.free_speed_mps = 0.0;
    let error = Chassis::new(wrong).unwrap_err();
    assert!(error.to_string().starts_with("parameter motor.free_speed_mps must be"), "{error}");
}
