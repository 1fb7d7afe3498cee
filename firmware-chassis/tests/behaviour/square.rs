//! A square of 2 m, driven by what the chassis says of its own place: the closing error is how far
//! from its start the robot really ends.
//!
//! **Without slip** the wheels' way is exact but for the encoder's quantum, and what is left is the
//! gyroscope: its bias is the mean of n samples at rest with a noise of 0.003 rad/s, n = 180 after
//! the bench's 2 s, so that it is wrong by 0.00022 rad/s: 0.0072 rad in the t = 32 s that a square
//! takes. Its noise adds 0.003 x sqrt(0.01 t) = 0.0017 rad. One deviation is 0.0074 rad. An error e that
//! grows evenly turns the sides by e/8, 3e/8, 5e/8 and 7e/8, so that the square is open by e/2 of a
//! side each way: 2 m x 0.0074 / sqrt(2) = 10 mm. Two deviations and the 5 mm and 0.005 rad at which a
//! corner counts as reached are 25 mm and 0.020 rad.
//!
//! **With slip** on one side (a slip on all four cancels): a wheel that loses a fifth of its speed
//! takes a twentieth from the way along and adds a twentieth across. And it turns the robot by
//! 0.2 x 0.5 / (4 x 0.2) = 0.125 rad/s at 0.5 m/s, in the 4 s of a side 0.5 rad. With the gyroscope the
//! turn is known, and the computer turns the robot back as fast, by its gain of 2/s from an offset of
//! 0.063 rad: that wheel rolls 0.5 + 0.031 (crabwise) + 0.025 (turning) m/s, 11 % more. Of 2 m are lost
//! 0.111 m each way, 0.157 m in all. With wheels alone the other sides are turned by half a radian, and
//! the first by half of that in the mean: the square ends 2 m x 0.25 = 0.5 m off, less the slip's 0.1 m,
//! and half a radian askew.

use firmware_chassis::Velocity;
use protocol::limits::DRIVE_TTL;

use crate::bench::Bench;

/// Drives to a place by what the chassis says, as a robot's computer would.
fn go_to(bench: &mut Bench, x: f32, y: f32, yaw: f32) {
    for _ in 0..300 {
        let told = bench.odometry().pose;
        let (ahead, aside) = (x - told.x.get(), y - told.y.get());
        let turn = (yaw - told.yaw.get() + 3.0 * core::f32::consts::PI).rem_euclid(core::f32::consts::TAU)
            - core::f32::consts::PI;
        let distance = ahead.hypot(aside);
        if distance < 0.005 && turn.abs() < 0.005 {
            return;
        }
        // Slow enough at the end for the ramp to follow.
        let speed = (1.5 * distance).min(0.5) / distance.max(1e-6);
        let (sin, cos) = told.yaw.get().sin_cos();
        let velocity = Velocity::new(
            speed * (cos * ahead + sin * aside),
            speed * (cos * aside - sin * ahead),
            (2.0 * turn).clamp(-1.5, 1.5),
        );
        assert_eq!(bench.drive(velocity, DRIVE_TTL), Ok(()));
        bench.wait(0.05);
    }
    panic!("the robot never believed to be at {x}, {y}, {yaw}");
}

/// Four sides forward with a turn at each corner; the left front wheel has this grip on the first.
/// Answers how far from its start the robot really is, in m, and by how much it is turned, in rad.
fn closing_error(bench: &mut Bench, grip: f32) -> (f32, f32) {
    use core::f32::consts::{FRAC_PI_2, PI};
    let corners = [(2.0, 0.0, FRAC_PI_2), (2.0, 2.0, PI), (0.0, 2.0, -FRAC_PI_2), (0.0, 0.0, 0.0)];
    let mut heading = 0.0;
    bench.plant.grip[1] = grip;
    for (x, y, next) in corners {
        go_to(bench, x, y, heading);
        bench.plant.grip[1] = 1.0;
        go_to(bench, x, y, next);
        heading = next;
    }
    bench.wait(1.0);
    let real = bench.plant.pose();
    (real.x.hypot(real.y), real.yaw.abs())
}

#[test]
fn without_slip_the_square_closes() {
    let (place_m, yaw_rad) = closing_error(&mut Bench::new(), 1.0);
    println!("without slip: {place_m} m, {yaw_rad} rad");
    assert!(place_m < 0.025, "{place_m}");
    assert!(yaw_rad < 0.020, "{yaw_rad}");
}

#[test]
fn after_a_slip_the_gyroscope_has_kept_the_heading() {
    let mut bench = Bench::new();
    let (place_m, yaw_rad) = closing_error(&mut bench, 0.8);
    println!("slip, with gyroscope: {place_m} m, {yaw_rad} rad");
    assert!((place_m - 0.157).abs() < 0.025, "{place_m}");
    assert!(yaw_rad < 0.020, "{yaw_rad}");

    let mut blind = Bench::new();
    blind.plant.gyro_bias_radps = None;
    let (place_m, yaw_rad) = closing_error(&mut blind, 0.8);
    println!("slip, wheels only: {place_m} m, {yaw_rad} rad");
    assert!((0.3..0.6).contains(&place_m), "{place_m}");
    assert!((yaw_rad - 0.5).abs() < 0.1, "{yaw_rad}");
}

#[test]
fn the_real_place_is_within_three_deviations_of_the_told_one() {
    for grip in [1.0, 0.8] {
        let mut bench = Bench::new();
        closing_error(&mut bench, grip);
        let (told, real) = (bench.chassis.pose(), bench.plant.pose());
        let covariance = bench.odometry().pose_covariance;
        let deviation_m = (covariance.xx.get() + covariance.yy.get()).sqrt();
        let error_m = (told.x - real.x).hypot(told.y - real.y);
        println!("grip {grip}: off by {error_m} m, deviation {deviation_m} m");
        assert!(error_m < 3.0 * deviation_m);
        assert!((told.yaw - real.yaw).abs() < 3.0 * covariance.yawyaw.get().sqrt() + 0.005);
    }
}
