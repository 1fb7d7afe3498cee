//! A square of 2 m by what the chassis says of its own place: the closing error is how far from its
//! start the robot really ends.
//!
//! The numbers follow those of `firmware-chassis/tests/behaviour/square.rs`, with this computer's
//! gains and times.
//!
//! **Without slip** what is left is the gyroscope. Its bias is the mean of n = 380 samples at rest with
//! a noise of 0.003 rad/s (4 s, less 0.2 s until they count): wrong by 0.00015 rad/s, which is
//! 0.0052 rad in the t = 35 s of the square; its noise adds 0.003 x sqrt(0.01 t) = 0.0018 rad. One deviation is
//! 0.0055 rad. An error e that grows evenly turns the sides by e/8, 3e/8, 5e/8 and 7e/8, so that the
//! square is open by e/2 of a side each way: 2 m x 0.0055 / sqrt(2) = 8 mm. Three deviations and the 5 mm
//! and 0.005 rad at which a corner counts as reached are 28 mm and 0.022 rad.
//!
//! **With slip** the front left wheel loses a fifth of its speed on the first side: a twentieth of
//! it along and a twentieth across. To hold the heading against the turn of 0.125 rad/s the computer
//! turns the robot back as fast, by its gain of 3/s from an offset of 0.042 rad: at 0.5 m/s that wheel rolls
//! 0.5 + 0.021 (crabwise) + 0.025 (turning) m/s, 9 % more. Of 2 m are lost 0.109 m each way, 0.154 m
//! in all. **Wheels alone** do not see the turn of 0.2 x 2 m / (4 x 0.2 m) = 0.5 rad: the first
//! side is turned by half of it in the mean, which leaves it 2 m x 0.25 = 0.5 m off, less the slip's
//! 0.1 m.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use protocol::DurationMs;
use tests::chassis_bench::{ChassisBench, twist};

/// A corner is reached this near, in m and in rad.
const NEAR: f32 = 0.005;
/// Between two looks at the odometry.
const LOOK: DurationMs = DurationMs(50);
/// Of a drive command.
const TTL: DurationMs = DurationMs(500);
/// Looks until a corner must be reached: 15 s.
const LOOKS: usize = 300;

/// Drives to a place by what the chassis says, as a robot's computer would.
fn go_to(bench: &mut ChassisBench, x: f32, y: f32, yaw: f32) {
    for _ in 0..LOOKS {
        let told = bench.watch_for(LOOK).unwrap().last().unwrap().pose;
        let (ahead, aside) = (x - told.x.get(), y - told.y.get());
        let turn = (yaw - told.yaw.get() + PI).rem_euclid(TAU) - PI;
        let distance = ahead.hypot(aside);
        if distance < NEAR && turn.abs() < NEAR {
            return;
        }
        // As fast as the ramp of 1 m/s² can stop it: 2/s of 0.5 m/s, 3/s of 1.5 rad/s at 0.2 m.
        let speed = (2.0 * distance).min(0.5) / distance.max(1e-6);
        let (sin, cos) = told.yaw.get().sin_cos();
        let forward = speed * (cos * ahead + sin * aside);
        let left = speed * (cos * aside - sin * ahead);
        bench.drive(twist(forward, left, (3.0 * turn).clamp(-1.5, 1.5)).unwrap(), TTL).unwrap();
    }
    panic!("the robot never believed to be at {x}, {y}, {yaw}");
}

/// Four sides forward with a turn at each corner; the left front wheel has this grip on the first.
/// Answers how far from its start the robot really is, in m, and by how much it is turned, in rad.
fn closing_error(bench: &mut ChassisBench, grip: f32) -> (f32, f32) {
    bench.watch_for(DurationMs(3_000)).unwrap();
    bench.order(&format!("grip 1 {grip}")).unwrap();
    let corners = [(2.0, 0.0, FRAC_PI_2), (2.0, 2.0, PI), (0.0, 2.0, -FRAC_PI_2), (0.0, 0.0, 0.0)];
    let mut heading = 0.0;
    for (x, y, next) in corners {
        go_to(bench, x, y, heading);
        bench.order("grip 1 1").unwrap();
        go_to(bench, x, y, next);
        heading = next;
    }
    let stop = bench.stop(false).unwrap();
    bench.answer(stop).unwrap().unwrap();
    bench.watch_for(DurationMs(500)).unwrap();
    let [x, y, yaw] = bench.truth().unwrap().pose;
    // The model's yaw goes on where the chassis' begins anew.
    let turned = (yaw + PI).rem_euclid(TAU) - PI;
    (x.hypot(y), turned.abs())
}

#[test]
fn without_slip_the_square_closes() {
    let (place_m, yaw_rad) = closing_error(&mut ChassisBench::boot().unwrap(), 1.0);
    println!("square without slip: {place_m} m, {yaw_rad} rad");
    assert!(place_m < 0.028, "{place_m}");
    assert!(yaw_rad < 0.022, "{yaw_rad}");
}

#[test]
fn after_a_slip_the_gyroscope_has_kept_the_heading() {
    let (place_m, yaw_rad) = closing_error(&mut ChassisBench::boot().unwrap(), 0.8);
    println!("square with slip, with gyroscope: {place_m} m, {yaw_rad} rad");
    assert!((place_m - 0.154).abs() < 0.028, "{place_m}");
    assert!(yaw_rad < 0.022, "{yaw_rad}");
}

#[test]
fn after_a_slip_wheels_alone_have_lost_the_heading() {
    let mut bench = ChassisBench::boot().unwrap();
    bench.order("gyro 0").unwrap();
    let (place_m, yaw_rad) = closing_error(&mut bench, 0.8);
    println!("square with slip, wheels alone: {place_m} m, {yaw_rad} rad");
    assert!((0.3..0.6).contains(&place_m), "{place_m}");
    assert!((yaw_rad - 0.5).abs() < 0.1, "{yaw_rad}");
}
