//! Whatever goes wrong ends in a stop with a name.

use protocol::{
    ChassisFault, ChassisMode, ChassisRefusal, ChassisState, Drive, DurationMs, Message, NackReason,
    StopReason, TagId, Twist, Wheel,
};
use tests::chassis_bench::{ChassisBench, twist};

/// A robot that drives forward at 0.5 m/s.
fn driving() -> (ChassisBench, Twist) {
    let mut bench = ChassisBench::boot().unwrap();
    let forward = twist(0.5, 0.0, 0.0).unwrap();
    let run = bench.drive_for(forward, DurationMs(1_000)).unwrap();
    let speed = run.last().unwrap().measured.vx.get();
    assert!((speed - 0.5).abs() < 0.01, "it drives at {speed} m/s");
    (bench, forward)
}

/// The stop that it comes to, and that it really stands then.
fn stops_for(bench: &mut ChassisBench, reason: StopReason) {
    bench.state_where(|state| state.mode == ChassisMode::Braked && state.stop == Some(reason)).unwrap();
    bench.watch_for(DurationMs(500)).unwrap();
    let truth = bench.truth().unwrap();
    assert!(truth.velocity.iter().all(|part| part.abs() < 1e-3), "it does not stand: {truth:?}");
}

/// A stop that is held until its cause is mended and it is released.
fn is_held(bench: &mut ChassisBench, by: StopReason, mend: &str) {
    let forward = twist(0.1, 0.0, 0.0).unwrap();
    let refused = |refusal| Err(NackReason::Chassis { refusal });
    let drive = bench.drive(forward, DurationMs(200)).unwrap();
    assert_eq!(bench.answer(drive).unwrap(), refused(ChassisRefusal::Stopped { by }));
    bench.order(mend).unwrap();
    bench.watch_for(DurationMs(500)).unwrap();
    let release = bench.release().unwrap();
    assert_eq!(bench.answer(release).unwrap(), Ok(()));
    let run = bench.drive_for(forward, DurationMs(1_000)).unwrap();
    assert!((run.last().unwrap().measured.vx.get() - 0.1).abs() < 0.01, "it does not drive again");
}

#[test]
fn a_command_that_is_not_repeated_ramps_to_a_stop() {
    let (mut bench, forward) = driving();
    let last = bench.drive(forward, DurationMs(200)).unwrap();
    assert_eq!(bench.answer(last).unwrap(), Ok(()));
    let before = bench.truth().unwrap();
    stops_for(&mut bench, StopReason::LinkSilent);
    let after = bench.truth().unwrap();
    // 0.2 s at 0.5 m/s and a ramp of 1 m/s² take 0.225 m; by the time it is asked some has gone by.
    let way = after.pose[0] - before.pose[0];
    assert!((0.0..0.25).contains(&way), "it rolled on for {way} m");
}

#[test]
fn frames_that_arrive_damaged_are_no_commands_and_end_in_a_stop_of_that_name() {
    let (mut bench, forward) = driving();
    let damaged = |bench: &mut ChassisBench| {
        let command = bench.next_command();
        let drive = Drive { command, ttl: DurationMs(1_000), twist: forward };
        let mut frame = bench.frame(Message::Drive(drive))?;
        let middle = frame.len() / 2;
        frame[middle] ^= 0x10;
        bench.transmit(&frame)
    };
    bench.keep(DurationMs(1_500), damaged).unwrap();
    stops_for(&mut bench, StopReason::LinkCorrupted);
    assert!(bench.state_where(|_| true).unwrap().discarded >= 20);
}

#[test]
fn an_emergency_stop_brakes_at_once_and_is_held() {
    let (mut bench, _) = driving();
    let stop = bench.stop(true).unwrap();
    assert_eq!(bench.answer(stop).unwrap(), Ok(()));
    stops_for(&mut bench, StopReason::Emergency);
    is_held(&mut bench, StopReason::Emergency, "gyro 1");
}

#[test]
fn a_drivers_fault_brakes_and_is_held_until_it_is_well() {
    let (mut bench, _) = driving();
    bench.order("driver 2 1").unwrap();
    stops_for(&mut bench, StopReason::DriverFault);
    let release = bench.release().unwrap();
    let not_cleared = NackReason::Chassis { refusal: ChassisRefusal::NotCleared };
    assert_eq!(bench.answer(release).unwrap(), Err(not_cleared));
    is_held(&mut bench, StopReason::DriverFault, "driver 2 0");
}

#[test]
fn a_stuck_encoder_brakes_and_is_held() {
    let (mut bench, forward) = driving();
    bench.order("encoder 1 1").unwrap();
    bench.drive_for(forward, DurationMs(1_500)).unwrap();
    stops_for(&mut bench, StopReason::EncoderStuck);
    let state = bench.state_where(|_| true).unwrap();
    assert!(state.faults.contains(&ChassisFault::EncoderStuck { wheel: Wheel::FrontLeft }), "{state:?}");
    is_held(&mut bench, StopReason::EncoderStuck, "encoder 1 0");
}

#[test]
fn a_wheel_that_cannot_turn_brakes_and_is_held() {
    let (mut bench, forward) = driving();
    bench.order("wheel 3 1").unwrap();
    bench.drive_for(forward, DurationMs(1_500)).unwrap();
    stops_for(&mut bench, StopReason::WheelStalled);
    is_held(&mut bench, StopReason::WheelStalled, "wheel 3 0");
}

#[test]
fn sensors_that_fall_silent_are_named_and_the_robot_drives_on() {
    let (mut bench, forward) = driving();
    bench.order("meter 0").unwrap();
    bench.order("gyro 0").unwrap();
    let run = bench.drive_for(forward, DurationMs(2_000)).unwrap();
    let speed = run.last().unwrap().measured.vx.get();
    assert!((speed - 0.5).abs() < 0.01, "it drives at {speed} m/s");
    let silent = [ChassisFault::GyroSilent, ChassisFault::BatterySilent];
    let state = bench.states.last().unwrap();
    assert_eq!((state.mode, &state.faults[..]), (ChassisMode::Driving, &silent[..]));

    // What a wheel draws is unknown now: one that does not count is taken for the worse.
    bench.order("encoder 1 1").unwrap();
    bench.drive_for(forward, DurationMs(1_500)).unwrap();
    stops_for(&mut bench, StopReason::WheelStalled);
    for words in ["meter 1", "gyro 1"] {
        bench.order(words).unwrap();
    }
    let healed = |state: &ChassisState| !state.faults.iter().any(|fault| silent.contains(fault));
    assert!(bench.state_where(healed).unwrap().battery.is_some());
    is_held(&mut bench, StopReason::WheelStalled, "encoder 1 0");
}

#[test]
fn a_task_that_hangs_ends_in_a_reset_that_says_so() {
    let (mut bench, _) = driving();
    bench.hang().unwrap();
    stops_for(&mut bench, StopReason::Watchdog);
}

#[test]
fn a_pile_the_robot_passes_is_counted_once() {
    let (mut bench, forward) = driving();
    let pile = TagId(*b"pile no. 012");
    bench.reader.dock(pile);
    bench.drive_for(forward, DurationMs(2_000)).unwrap();
    bench.reader.clear();
    bench.drive_for(forward, DurationMs(3_000)).unwrap();
    let passes: Vec<_> = bench.passes.iter().map(|count| (count.tag, count.passes)).collect();
    assert_eq!(passes, [(pile, 1)]);
}
