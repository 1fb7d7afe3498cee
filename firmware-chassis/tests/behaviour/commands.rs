//! Commands: obeyed once, answered always, refused by name.

use firmware_chassis::{Input, Velocity};
use protocol::*;

use crate::bench::{Bench, ROBOT, answer, refused, twist};

const AHEAD: Velocity = Velocity::new(0.5, 0.0, 0.0);

#[test]
fn beyond_a_limit_a_command_is_refused_by_name_and_the_robot_stays() {
    let mut bench = Bench::new();
    let ttl = limits::DRIVE_TTL;
    for (velocity, ttl, refusal) in [
        (Velocity::new(0.9, 0.0, 0.0), ttl, ChassisRefusal::ForwardSpeed),
        (Velocity::new(0.0, -0.9, 0.0), ttl, ChassisRefusal::SidewaysSpeed),
        (Velocity::new(0.0, 0.0, 4.5), ttl, ChassisRefusal::TurnRate),
        (AHEAD, DurationMs(0), ChassisRefusal::TimeToLive),
        (AHEAD, DurationMs(1_001), ChassisRefusal::TimeToLive),
    ] {
        assert_eq!(bench.drive(velocity, ttl), refused(refusal));
    }
    bench.wait(1.0);
    assert_eq!(bench.plant.velocity().norm(), 0.0);
}

#[test]
fn a_nan_cannot_be_said_and_if_it_is_sent_nothing_moves() {
    assert!(SpeedMps::new(f32::NAN).is_err());
    let mut bench = Bench::new();
    let header = Header::new(DeviceId::Robot(ROBOT.robot), BootEpoch(1), Sequence(0));
    let drive = Drive { command: CommandId(1), ttl: limits::DRIVE_TTL, twist: twist(AHEAD) };
    let good = Frame { header, message: Message::Drive(drive) }.encode().unwrap();
    let (from, to) = (0.5f32.to_le_bytes(), f32::NAN.to_le_bytes());

    // The packet with a NaN for 0.5 m/s, and a CRC that is right.
    let mut packet = good[1..good.len() - 1].to_vec();
    let length = cobs::decode_in_place(&mut packet).unwrap();
    packet.truncate(length - limits::CHECK);
    let at = packet.windows(4).position(|window| window == from).unwrap();
    packet[at..at + 4].copy_from_slice(&to);
    let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&packet);
    packet.extend(crc.to_le_bytes());
    let mut bytes = vec![0];
    bytes.extend(cobs::encode_vec(&packet));
    bytes.push(0);

    let mut deframer = Deframer::new();
    let mut sessions = Sessions::insecure(DeviceId::Chassis(ROBOT.robot), BootEpoch(1));
    deframer.feed(&bytes, |found| match found.and_then(|packet| sessions.open(packet)) {
        Ok(frame) => panic!("{frame:?}"),
        Err(error) => {
            assert_eq!(error, FrameError::Body);
            bench.step(Input::Discarded(error));
        }
    });
    bench.wait(1.1);
    assert_eq!(bench.plant.velocity().norm(), 0.0);
    assert_eq!(bench.state().discarded, 1);
}

#[test]
fn a_repeat_is_answered_again_and_does_not_extend_its_time() {
    let mut bench = Bench::new();
    let drive = Drive { command: CommandId(1), ttl: DurationMs(200), twist: twist(AHEAD) };
    for _ in 0..5 {
        let outputs = bench.hear(Message::Drive(drive));
        assert_eq!(answer(&outputs, CommandId(1)), Ok(()));
        bench.wait(0.1);
    }
    assert_eq!(bench.told(), (ChassisMode::Braked, Some(StopReason::LinkSilent)));
}

#[test]
fn a_command_from_before_the_newest_comes_too_late_but_not_an_emergency_stop() {
    let mut bench = Bench::new();
    let drive = |command, vx| {
        Message::Drive(Drive {
            command: CommandId(command),
            ttl: DurationMs(1_000),
            twist: twist(Velocity::new(vx, 0.0, 0.0)),
        })
    };
    bench.hear(drive(5, 0.5));
    let outputs = bench.hear(drive(4, -0.5));
    assert_eq!(answer(&outputs, CommandId(4)), Err(NackReason::TooLate));
    bench.wait(0.6);
    assert!((bench.plant.velocity().x - 0.5).abs() < 0.01);
    let outputs = bench.hear(Message::Stop(Stop { command: CommandId(3), emergency: true }));
    assert_eq!(answer(&outputs, CommandId(3)), Ok(()));
    assert_eq!(bench.chassis.motion().held(), Some(StopReason::Emergency));
    // And it does not make other late commands new again.
    bench.wait(1.0);
    let outputs = bench.hear(Message::Release(Release { command: CommandId(4) }));
    assert_eq!(answer(&outputs, CommandId(4)), Err(NackReason::TooLate));
}

#[test]
fn nobody_but_the_robot_s_own_computer_is_obeyed() {
    let mut bench = Bench::new();
    let drive = Drive { command: CommandId(1), ttl: limits::DRIVE_TTL, twist: twist(AHEAD) };
    for sender in [
        DeviceId::Coordinator,
        DeviceId::Pile(PileId(7)),
        DeviceId::Chassis(ROBOT.robot),
        DeviceId::Robot(RobotId(8)),
    ] {
        let header = Header::new(sender, BootEpoch(1), Sequence(0));
        let frame = Frame { header, message: Message::Drive(drive) };
        assert_eq!(bench.step(Input::Frame(&frame)).messages, []);
    }
    bench.wait(0.1);
    assert_eq!(bench.told(), (ChassisMode::Braked, Some(StopReason::Started)));
}

#[test]
fn a_task_takes_from_the_battery_what_the_robot_drew_for_it() {
    let mut bench = Bench::new();
    let patrol = Some(TaskId(4));
    let switch = |bench: &mut Bench, task| {
        let command = bench.command();
        let outputs = bench.hear(Message::Task(Task { command, task }));
        assert_eq!(answer(&outputs, command), Ok(()));
        outputs.messages.iter().find_map(|message| match message {
            Message::TaskEnergy(energy) => Some(*energy),
            _ => None,
        })
    };
    let mut taken = Vec::new();
    for seconds in [2.0, 4.0] {
        assert_eq!(switch(&mut bench, patrol), None);
        let before = bench.plant.drawn_j();
        bench.keep_driving(AHEAD, seconds, |_| {});
        taken.push(bench.plant.drawn_j() - before);
        let energy = switch(&mut bench, None).unwrap();
        assert_eq!((energy.task, energy.runs), (TaskId(4), taken.len() as u32));
        // Eq. 1 and eq. 2. (The battery's voltage is sampled at the end of a tick.)
        let mean = taken.iter().sum::<f32>() / taken.len() as f32;
        assert!((energy.last.get() / taken.last().unwrap() - 1.0).abs() < 0.01, "{energy:?} {taken:?}");
        assert!((energy.mean.get() / mean - 1.0).abs() < 0.01, "{energy:?} {taken:?}");
        bench.wait(1.0);
    }
}
