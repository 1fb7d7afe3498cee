//! Steps of 0.5 m/s from command to odometry, against the numbers that
//! `firmware-chassis/tests/behaviour/steps.rs` derives, and what the robot really did.

use protocol::{DurationMs, Odometry, Twist};
use tests::chassis_bench::{ChassisBench, twist};

/// H/2 + W/2 of the robot the image is built for: a turn rate as a speed of the wheels.
const ARM_M: f32 = 0.2;

type Vector = [f32; 3];

fn at_wheels(twist: &Twist) -> Vector {
    [twist.vx.get(), twist.vy.get(), twist.wz.get() * ARM_M]
}

fn norm(vector: Vector) -> f32 {
    vector.iter().map(|part| part * part).sum::<f32>().sqrt()
}

fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn mean(vectors: &[Vector]) -> Vector {
    [0, 1, 2].map(|part| vectors.iter().map(|vector| vector[part]).sum::<f32>() / vectors.len() as f32)
}

/// `ramp_s`: 50 ticks of 0.01 m/s for the wheel with the longest way, 71 on the diagonal.
fn a_step_is_there_when_the_ramp_is(command: Twist, ramp_s: f32) {
    let mut bench = ChassisBench::boot().unwrap();
    let run = bench.drive_for(command, DurationMs(3_000)).unwrap();
    let begin = run.iter().position(|odometry| odometry.commanded != Twist::default()).unwrap();
    let run: &[Odometry] = &run[begin..];
    let wanted = at_wheels(&command);
    let size = norm(wanted);
    let measured: Vec<Vector> = run.iter().map(|odometry| at_wheels(&odometry.measured)).collect();

    // Set-points: never more than 0.01 m/s a tick, none out of the direction of the command.
    for pair in run.windows(2) {
        let change = minus(at_wheels(&pair[1].ramped), at_wheels(&pair[0].ramped));
        assert!(norm(change) < 0.01001, "{pair:#?}");
    }
    // Settle time: within 2 % when the ramp is there, and from then on.
    let settled = measured.iter().rposition(|velocity| norm(minus(*velocity, wanted)) > 0.02 * size).unwrap();
    let settled_s = (settled + 1) as f32 / 100.0;
    assert!((settled_s - ramp_s).abs() <= 0.021, "settled after {settled_s} s instead of {ramp_s} s");
    // Overshoot.
    let fastest = measured.iter().map(|velocity| norm(*velocity)).fold(0.0, f32::max);
    let overshoot = (fastest - size) / size;
    assert!(overshoot < 0.01, "overshoot {overshoot}");
    // Steady error.
    let steady = norm(minus(mean(&measured[measured.len() - 100..]), wanted));
    assert!(steady < 0.001, "steady error {steady} m/s");
    // The bend of the ramp: the way off the commanded direction by the way along it.
    let way = mean(&measured[..(ramp_s * 100.0) as usize]);
    let along = (0..3).map(|part| way[part] * wanted[part] / size).sum::<f32>();
    let bend = norm(minus(way, wanted.map(|part| part / size * along))) / along;
    assert!(bend < 0.01, "bend {bend}");
    println!("settled {settled_s:.2} s, overshoot {overshoot:.4}, steady {steady:.5} m/s, bend {bend:.4}");

    // The odometry is to be believed: it says what the robot really does. Asked while it stands, so
    // that both are of the same moment.
    let stop = bench.stop(false).unwrap();
    bench.answer(stop).unwrap().unwrap();
    let last = *bench.watch_for(DurationMs(1_500)).unwrap().last().unwrap();
    let truth = bench.truth().unwrap();
    assert_eq!(truth.velocity.map(|part| (part * 1e3).round()), [0.0; 3], "it does not stand: {truth:?}");
    let off = [last.pose.x.get() - truth.pose[0], last.pose.y.get() - truth.pose[1]];
    assert!(off[0].hypot(off[1]) < 0.02, "odometry {last:#?}, but really {truth:?}");
    // Yaw is told within half a turn; the model's goes on.
    let turned = last.pose.yaw.get() - truth.pose[2];
    assert!(turned.sin().abs() < 0.02 && turned.cos() > 0.0, "odometry {last:#?}, but really {truth:?}");
}

#[test]
fn a_step_forward_is_there_when_the_ramp_is() {
    a_step_is_there_when_the_ramp_is(twist(0.5, 0.0, 0.0).unwrap(), 0.50);
}

#[test]
fn a_step_to_the_left_is_there_when_the_ramp_is() {
    a_step_is_there_when_the_ramp_is(twist(0.0, 0.5, 0.0).unwrap(), 0.50);
}

#[test]
fn a_diagonal_step_is_there_when_the_ramp_is() {
    let part = 0.5 * std::f32::consts::FRAC_1_SQRT_2;
    a_step_is_there_when_the_ramp_is(twist(part, part, 0.0).unwrap(), 0.71);
}

#[test]
fn a_step_of_turning_is_there_when_the_ramp_is() {
    a_step_is_there_when_the_ramp_is(twist(0.0, 0.0, 0.5 / ARM_M).unwrap(), 0.50);
}
