//! What breaks is noticed, stops the robot where it must, and is told.

use firmware_chassis::{Motors, Velocity, monitor::WHEELS};
use protocol::*;

use crate::bench::{Bench, refused};

const AHEAD: Velocity = Velocity::new(0.5, 0.0, 0.0);

/// Breaks something in a driving robot. Answers the seconds until it brakes.
fn braked_after(bench: &mut Bench, velocity: Velocity, break_it: impl FnOnce(&mut Bench)) -> f32 {
    bench.keep_driving(velocity, 1.5, |_| {});
    break_it(bench);
    for tick in 1..500_u16 {
        if tick % 10 == 0 {
            // Refused once it has stopped.
            let _ = bench.drive(velocity, limits::DRIVE_TTL);
        }
        bench.tick();
        if bench.motors == Motors::Brake {
            return f32::from(tick) / 100.0;
        }
    }
    panic!("it drives on");
}

#[test]
fn every_encoder_that_sticks_is_named_and_stops_the_robot() {
    for (index, wheel) in WHEELS.into_iter().enumerate() {
        for velocity in [AHEAD, Velocity::new(-0.1, 0.0, 0.0), Velocity::new(0.0, 0.3, 0.5)] {
            let mut bench = Bench::new();
            let seconds = braked_after(&mut bench, velocity, |bench| bench.plant.encoder_stuck[index] = true);
            println!("encoder {wheel:?} at {velocity:?}: {seconds} s");
            assert!(seconds < 0.75, "{seconds}");
            bench.wait(0.01);
            assert_eq!(bench.told(), (ChassisMode::Braked, Some(StopReason::EncoderStuck)));
            assert!(bench.state().faults.contains(&ChassisFault::EncoderStuck { wheel }));
        }
    }
}

#[test]
fn at_a_crawl_a_stuck_encoder_is_found_once_the_control_pushes() {
    let mut bench = Bench::new();
    let crawl = Velocity::new(0.02, 0.0, 0.0);
    let seconds = braked_after(&mut bench, crawl, |bench| bench.plant.encoder_stuck[0] = true);
    // From a duty of 0.06 + 0.02 / 1.34 + 0.6 x 0.02 to 0.26 at 5 x 0.02 a second, and 0.25 s.
    println!("crawl: {seconds} s");
    assert!((seconds - (0.173 / 0.1 + 0.25)).abs() < 0.2, "{seconds}");
    assert_eq!(bench.chassis.motion().held(), Some(StopReason::EncoderStuck));
}

#[test]
fn every_wheel_that_is_held_fast_is_named_and_stops_the_robot() {
    for (index, wheel) in WHEELS.into_iter().enumerate() {
        let mut bench = Bench::new();
        let seconds = braked_after(&mut bench, AHEAD, |bench| bench.plant.blocked[index] = true);
        println!("stall {wheel:?}: {seconds} s");
        assert!(seconds < 0.5, "{seconds}");
        bench.wait(0.01);
        assert_eq!(bench.told(), (ChassisMode::Braked, Some(StopReason::WheelStalled)));
        assert!(bench.state().faults.contains(&ChassisFault::Stalled { wheel }));
        // Free again, it drives on after a release.
        bench.plant.blocked[index] = false;
        bench.wait(1.0);
        assert_eq!(bench.release(), Ok(()));
        bench.keep_driving(AHEAD, 1.0, |_| {});
        assert!((bench.plant.velocity().x - 0.5).abs() < 0.01);
        assert_eq!(bench.state().faults, []);
    }
}

#[test]
fn a_driver_s_fault_brakes_in_the_same_tick_and_is_held_while_it_is_there() {
    let mut bench = Bench::new();
    let seconds = braked_after(&mut bench, AHEAD, |bench| bench.plant.driver_faults[2] = true);
    assert_eq!(seconds, 0.01);
    bench.wait(1.0);
    assert_eq!(bench.told(), (ChassisMode::Braked, Some(StopReason::DriverFault)));
    assert_eq!(bench.state().faults, [ChassisFault::Driver { wheel: Wheel::FrontRight }]);
    assert_eq!(bench.release(), refused(ChassisRefusal::NotCleared));
    bench.plant.driver_faults[2] = false;
    bench.wait(0.01);
    assert_eq!(bench.release(), Ok(()));
}

#[test]
fn a_slip_is_told_and_does_not_stop_the_robot() {
    let mut bench = Bench::new();
    bench.keep_driving(AHEAD, 1.0, |_| {});
    assert_eq!(bench.state().faults, []);
    bench.plant.grip[0] = 0.5;
    bench.keep_driving(AHEAD, 0.3, |_| {});
    assert_eq!(bench.state().faults, [ChassisFault::Slipping]);
    assert_eq!(bench.told(), (ChassisMode::Driving, None));
    bench.plant.grip[0] = 1.0;
    bench.keep_driving(AHEAD, 1.0, |_| {});
    assert_eq!(bench.state().faults, []);
}

#[test]
fn a_robot_drives_without_gyroscope_and_battery_meter_and_says_so() {
    let mut bench = Bench::new();
    bench.plant.gyro_bias_radps = None;
    bench.keep_driving(Velocity::new(0.0, 0.0, 1.0), 2.0, |_| {});
    assert_eq!(bench.state().faults, [ChassisFault::GyroSilent]);
    assert!((bench.chassis.velocity().z - 1.0).abs() < 0.02);
}

#[test]
fn no_step_of_a_healthy_robot_is_taken_for_a_fault() {
    let mut bench = Bench::new();
    for (x, y, z) in [
        (0.8, 0.0, 0.0),
        (-0.8, 0.0, 0.0),
        (0.0, 0.8, 0.0),
        (0.0, 0.0, -4.0),
        (0.02, 0.0, 0.0),
        (0.0, 0.0, 0.05),
    ] {
        bench.keep_driving(Velocity::new(x, y, z), 3.0, |bench| {
            assert_eq!(bench.state().faults, []);
            assert_eq!(bench.chassis.motion().stop(), None);
        });
    }
}
