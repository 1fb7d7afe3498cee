//! What the chassis says, and when.

use firmware_chassis::Velocity;
use protocol::*;

use crate::bench::{Bench, twist};

fn hellos(bench: &Bench) -> usize {
    bench.sent.iter().filter(|message| matches!(message, Message::Hello(_))).count()
}

#[test]
fn hello_is_said_until_it_is_answered() {
    let mut bench = Bench::new();
    // At 0.01, 1.01 s.
    assert_eq!(hellos(&bench), 2);
    let hello = Hello { min: 1, current: 1, software: [0; 3], epoch: Epoch(0) };
    bench.hear(Message::Hello(hello));
    bench.wait(5.0);
    assert_eq!(hellos(&bench), 2);
    // The computer has started anew.
    bench.hear(Message::Hello(hello));
    assert_eq!(hellos(&bench), 3);
}

#[test]
fn odometry_goes_out_every_tick_and_the_state_at_changes_and_every_second() {
    let mut bench = Bench::new();
    bench.sent.clear();
    bench.wait(10.0);
    let count = |bench: &Bench, wanted: fn(&Message) -> bool| bench.sent.iter().filter(|m| wanted(m)).count();
    assert_eq!(count(&bench, |message| matches!(message, Message::Odometry(_))), 1_000);
    assert_eq!(count(&bench, |message| matches!(message, Message::ChassisState(_))), 10);
    assert_eq!(bench.drive(Velocity::new(0.1, 0.0, 0.0), limits::DRIVE_TTL), Ok(()));
    bench.tick();
    assert_eq!(bench.told(), (ChassisMode::Driving, None));
}

#[test]
fn commanded_ramped_and_measured_velocity_are_told_side_by_side() {
    let mut bench = Bench::new();
    let command = Velocity::new(0.4, -0.2, 1.0);
    bench.keep_driving(command, 0.2, |_| {});
    let odometry = *bench.odometry();
    let close = |a: f32, b: f32, within: f32| (a - b).abs() < within;
    assert!(close(odometry.commanded.vx.get(), 0.4, 1e-6) && close(odometry.commanded.wz.get(), 1.0, 1e-5));
    // The farthest wheel goes to 0.4 + 0.2 + 0.2 m/s: after 20 of 80 ticks a quarter.
    let quarter = twist(command / 4.0);
    for (told, slack) in [(odometry.ramped, 1e-4), (odometry.measured, 0.02)] {
        assert!(close(told.vx.get(), quarter.vx.get(), slack), "{told:?}");
        assert!(close(told.vy.get(), quarter.vy.get(), slack), "{told:?}");
        assert!(close(told.wz.get(), quarter.wz.get(), 2.0 * slack), "{told:?}");
    }
}

#[test]
fn every_message_of_a_drive_survives_the_wire() {
    let mut bench = Bench::new();
    bench.keep_driving(Velocity::new(0.4, -0.2, 1.0), 1.0, |_| {});
    let mut sessions = Sessions::insecure(DeviceId::Chassis(RobotId(7)), BootEpoch(1));
    let computer = Recipient::Device(DeviceId::Robot(RobotId(7)));
    let mut deframer = Deframer::new();
    for message in bench.sent {
        let bytes = sessions.seal(computer, &message).unwrap();
        let mut found = Vec::new();
        deframer.feed(&bytes, |packet| found.push(sessions.open(packet.unwrap()).unwrap().message));
        assert_eq!(found, [message]);
    }
}
