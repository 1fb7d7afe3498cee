use protocol::{AngleRad, BootEpoch, ChassisRefusal, Header, Nack, Pose, Sequence, SpeedMps, TimeRequest};

use super::*;

const ROBOT: RobotId = RobotId(7);

fn frame(message: Message) -> Input {
    let header = Header::new(DeviceId::Chassis(ROBOT), BootEpoch(0), Sequence(0));
    Input::Frame(Frame { header, message })
}

fn odometry() -> Odometry {
    Odometry {
        stamp: Millis(0),
        pose: Pose::default(),
        pose_covariance: protocol::PoseCovariance::default(),
        measured: Twist::default(),
        measured_variance: protocol::TwistVariance::default(),
        ramped: Twist::default(),
        commanded: Twist::default(),
    }
}

fn report() -> Input {
    frame(Message::Odometry(odometry()))
}

fn driving() -> Session {
    let twist = Twist { vx: SpeedMps::clamped(0.5), ..Twist::default() };
    Session::new(Goal::Drive { twist, duration: None }, SiteMillis(1_000_000))
}

fn drives(outputs: &Outputs) -> impl Iterator<Item = &Drive> {
    outputs
        .send
        .iter()
        .filter_map(|message| if let Message::Drive(drive) = message { Some(drive) } else { None })
}

#[test]
fn drives_grow_in_number_come_well_within_their_time_and_end_when_the_chassis_is_not_heard() {
    let mut session = driving();
    let mut sent = Vec::new();
    for ms in (0..1_500).step_by(5) {
        let heard = if ms < 1_000 { report() } else { Input::Tick };
        let outputs = session.step(Millis(ms), heard).unwrap();
        for drive in drives(&outputs) {
            sent.push((ms, drive.command));
            let ack = Ack { of: Reference::Command(drive.command) };
            if ms < 1_000 {
                session.step(Millis(ms), frame(Message::Ack(ack))).unwrap();
            }
        }
    }
    assert!(sent.windows(2).all(|pair| pair[0].1 < pair[1].1 && pair[1].0 - pair[0].0 <= 50), "{sent:?}");
    let (last, _) = *sent.last().unwrap();
    assert!((1_100..=1_000 + u64::from(limits::DRIVE_TTL.0)).contains(&last), "{last}");
}

#[test]
fn what_a_chassis_asks_is_answered() {
    let mut session = Session::new(Goal::Listen, SiteMillis(1_000_000));
    session.step(Millis(10), report()).unwrap();
    let ask = TimeRequest { asked_at: Millis(77) };
    let answer = session.step(Millis(500), frame(Message::TimeRequest(ask))).unwrap();
    let sync = TimeSync { asked_at: Millis(77), site_now: SiteMillis(1_000_500) };
    assert_eq!(answer.send, [Message::TimeSync(sync)]);
    let report = protocol::ReportId { boot: BootEpoch(1), number: 3 };
    let passes = protocol::PassReport { report, passes: heapless::Vec::new() };
    let answer = session.step(Millis(600), frame(Message::PassReport(passes))).unwrap();
    assert_eq!(answer.send, [Message::Ack(Ack { of: Reference::Report(report) })]);
}

#[test]
fn a_chassis_that_reports_and_never_answers_is_given_up() {
    let mut session = driving();
    let mut steps = (0..5_000).step_by(10).map(|ms| session.step(Millis(ms), report()).map(drop));
    assert_eq!(steps.find(Result::is_err), Some(Err(SessionError::Unanswered { robot: ROBOT })));
}

#[test]
fn a_stop_is_repeated_under_one_number_and_over_when_the_chassis_is_braked() {
    let mut session = driving();
    session.step(Millis(0), report()).unwrap();
    let stops: Vec<_> = (0..50)
        .flat_map(|tick| {
            let input = if tick == 0 { Input::Interrupt } else { report() };
            session.step(Millis(10 + tick * 10), input).unwrap().send
        })
        .filter_map(|message| if let Message::Stop(stop) = message { Some(stop.command) } else { None })
        .collect();
    assert_eq!(stops, [CommandId(2); 5]);
    // The refusal of the drive that crossed it says nothing of the stop.
    let reason = NackReason::Chassis { refusal: ChassisRefusal::ForwardSpeed };
    let late = Nack { of: Reference::Command(CommandId(1)), reason };
    session.step(Millis(510), frame(Message::Nack(late))).unwrap();
    session.step(Millis(520), frame(Message::Ack(Ack { of: Reference::Command(CommandId(2)) }))).unwrap();
    for (mode, done) in [(ChassisMode::Stopping, false), (ChassisMode::Braked, true)] {
        let state =
            ChassisState { mode, stop: None, faults: heapless::Vec::new(), battery: None, discarded: 0 };
        session.step(Millis(530), frame(Message::ChassisState(state))).unwrap();
        assert_eq!(session.is_done(), done);
    }
}

#[test]
fn an_emergency_stop_is_the_first_thing_that_is_said_and_is_repeated_as_one() {
    let mut session = Session::new(Goal::Stop { emergency: true }, SiteMillis(1_000_000));
    let stops: Vec<_> = (0..50)
        .flat_map(|tick| session.step(Millis(tick * 10), report()).unwrap().send)
        .filter_map(|message| if let Message::Stop(stop) = message { Some(stop) } else { None })
        .collect();
    assert_eq!(stops, [Stop { command: CommandId(1), emergency: true }; 5]);
}

#[test]
fn a_session_counts_on_from_one_that_began_earlier_in_the_same_second() {
    let first_command = |wall| {
        let mut session = Session::new(Goal::Release, SiteMillis(wall));
        match session.step(Millis(0), report()).unwrap().send[..] {
            [Message::Release(release), ..] | [_, Message::Release(release), ..] => release.command,
            ref other => panic!("{other:?}"),
        }
    };
    // A drive of almost a second sends 20 commands, and repeats none.
    assert!(first_command(1_000_001).0 > first_command(1_000_000).0 + 20);
    assert!(first_command(1_000_999) > first_command(1_000_001));
}

#[test]
fn a_way_is_told_in_the_axes_of_its_start() {
    let mut first = odometry();
    first.pose.yaw = AngleRad::clamped(std::f32::consts::FRAC_PI_2);
    let mut last = first;
    last.pose.y = protocol::CoordinateM::clamped(2.0);
    last.pose.yaw = AngleRad::clamped(-3.0);
    let moved = Moved::between(&first, &last);
    assert!((moved.x_m - 2.0).abs() < 1e-6 && moved.y_m.abs() < 1e-6);
    assert!((moved.yaw_rad - (std::f32::consts::TAU - 3.0 - std::f32::consts::FRAC_PI_2)).abs() < 1e-5);
}
