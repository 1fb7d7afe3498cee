//! What robots ask and do, and what becomes of their requests and leases.

use super::*;

#[test]
fn a_repeated_request_does_nothing_new_and_is_answered_again() {
    let (mut desk, _) = Desk::granted();
    desk.robot_is(ROBOT, Activity::Waiting, None);
    let events = desk.events.len();
    for _ in 0..5 {
        desk.now.0 += 1_000;
        desk.sent.clear();
        desk.ask(ROBOT, 1);
        let answers = desk.sent_to_robot(ROBOT);
        assert!(matches!(answers[..], [Message::Assignment(_), ..]), "{answers:?}");
    }
    assert_eq!(desk.events.len(), events);
}

#[test]
fn an_assignment_is_repeated_until_the_robot_says_that_it_follows_it() {
    let (mut desk, _) = Desk::granted();
    desk.sent.clear();
    desk.wait(3_000);
    assert!(desk.sent_to_robot(ROBOT).is_empty(), "it follows it");
    desk.robot_is(ROBOT, Activity::Waiting, None);
    desk.wait(3_000);
    let parts = desk.sent_to_robot(ROBOT).len();
    assert!((3..=4).contains(&parts), "{parts}");
}

#[test]
fn a_robot_that_goes_back_to_work_loses_its_lease_and_its_request() {
    let (mut desk, _) = Desk::granted();
    desk.robot_is(ROBOT, Activity::Working, None);
    assert_eq!(desk.phase(P), Some(Phase::Revoking { why: RevokeReason::Abandoned }));
    assert_eq!(desk.place(ROBOT), None);
    desk.ack(P);
    assert_eq!(desk.ends(), [LeaseEnd::Revoked]);
    assert_eq!(desk.state().totals.charges_completed, 0);
}

#[test]
fn a_robot_that_never_heeds_its_assignment_loses_it() {
    let mut desk = Desk::new();
    desk.pile_says(P, Availability::Free, None);
    desk.robot_is(ROBOT, Activity::Working, None);
    desk.ask(ROBOT, 1);
    desk.ack(P);
    let lease = desk.last_command(P).unwrap().1;
    for _ in 0..32 {
        desk.wait(1_000);
        desk.pile_says(P, Availability::Reserved, Some(lease));
        desk.robot_is(ROBOT, Activity::Working, None);
    }
    assert_eq!(desk.phase(P), Some(Phase::Revoking { why: RevokeReason::Abandoned }));
}

#[test]
fn a_stranded_robot_frees_its_pile_and_keeps_its_place() {
    let (mut desk, _) = Desk::granted();
    desk.robot_is(ROBOT, Activity::Stranded, Some(1));
    assert_eq!(desk.phase(P), Some(Phase::Revoking { why: RevokeReason::Stranded }));
    assert_eq!(desk.place(ROBOT), Some(Place::Waiting));
    assert!(desk.warnings.iter().any(|warning| warning.contains("robot 1 has stranded")));
    desk.ack(P);
    desk.pile_says(P, Availability::Free, None);
    desk.wait(2_000);
    assert_eq!(desk.phase(P), None, "nothing is granted to who can't come");
    desk.robot_is(ROBOT, Activity::Waiting, None);
    desk.wait(1_100);
    assert_eq!(desk.place(ROBOT), Some(Place::Granted(P)));
}

#[test]
fn a_lease_is_extended_while_its_robot_lives_and_runs_out_when_it_is_lost() {
    let (mut desk, lease) = Desk::granted();
    let first_expiry = desk.state().lease(P).unwrap().expiry;
    for _ in 0..60 {
        desk.wait(1_000);
        desk.pile_says(P, Availability::Reserved, Some(lease));
        desk.robot_is(ROBOT, Activity::Approaching, Some(1));
        if desk.state().lease(P).unwrap().command.is_some() {
            desk.ack(P);
        }
    }
    assert!(desk.state().lease(P).unwrap().expiry > first_expiry);
    for _ in 0..59 {
        desk.wait(1_000);
        desk.pile_says(P, Availability::Reserved, Some(lease));
    }
    let ended = EndedLease { lease, reason: EndReason::Expired, charged: DurationMs(0) };
    desk.pile_reports(P, Availability::Free, None, Some(ended), 0.0);
    assert_eq!(desk.ends(), [LeaseEnd::ByPile(EndReason::Expired)]);
    assert_eq!(desk.place(ROBOT), Some(Place::Waiting), "it may turn up again");
}

#[test]
fn a_robot_whose_pile_changes_gives_up_the_old_one_first() {
    let (mut desk, lease) = Desk::granted();
    let other = PileId(5);
    desk.pile_says(other, Availability::Free, None);
    let ended = EndedLease { lease, reason: EndReason::Fault, charged: DurationMs(0) };
    desk.sent.clear();
    desk.pile_reports(P, Availability::Fault, None, Some(ended), 0.0);
    desk.ack(other);
    desk.wait(2_000);
    let told = desk.sent_to_robot(ROBOT);
    assert!(told.iter().all(|message| matches!(message, Message::Unassigned(_))) && !told.is_empty());
    desk.sent.clear();
    desk.robot_is(ROBOT, Activity::Waiting, None);
    let told = desk.sent_to_robot(ROBOT);
    assert!(matches!(told[..], [Message::Assignment(part), ..] if part.pile == other), "{told:?}");
}

#[test]
fn a_robot_in_a_wall_or_nowhere_is_told_and_reported_and_waits() {
    let metres = |x, y| Position { x: CoordinateM::new(x).unwrap(), y: CoordinateM::new(y).unwrap() };
    for position in [metres(-1e5, 1e5), metres(50.0, 68.0), metres(0.4, 99_999.0)] {
        let mut desk = Desk::new();
        desk.pile_says(P, Availability::Free, None);
        desk.ask_from(ROBOT, 1, position, 5_000.0);
        assert_eq!(desk.place(ROBOT), Some(Place::Waiting), "{position:?}");
        assert!(desk.warnings.iter().any(|warning| warning.contains("robot 1")), "{:?}", desk.warnings);
        let told = desk.sent_to_robot(ROBOT);
        let answer = Unassigned { request: RequestId(1), reason: UnassignedReason::OutOfReach };
        assert!(told.contains(&&Message::Unassigned(answer)), "{told:?}");
        // Its localisation comes back.
        desk.robot_is(ROBOT, Activity::Waiting, None);
        desk.wait(1_100);
        assert_eq!(desk.place(ROBOT), Some(Place::Granted(P)));
    }
}

#[test]
fn a_robot_with_no_energy_is_out_of_reach_and_one_too_many_finds_all_taken() {
    let mut desk = Desk::new();
    desk.pile_says(PileId(13), Availability::Free, None);
    desk.ask_from(ROBOT, 1, desk.beside(P), 0.0);
    desk.pile_says(PileId(13), Availability::Done, None);
    desk.ask_from(RobotId(2), 1, desk.beside(P), 9_000.0);
    let reason = |robot| {
        let told = desk.sent_to_robot(robot).into_iter().rev();
        let answers = told.filter_map(|message| match message {
            Message::Unassigned(answer) => Some(answer.reason),
            _ => None,
        });
        answers.clone().next()
    };
    // Robot 1 stands on pile 2, which is silent; it reaches that and nothing else.
    assert_eq!(reason(ROBOT), Some(UnassignedReason::AllTaken));
    assert_eq!(reason(RobotId(2)), Some(UnassignedReason::AllTaken));
}

/// A robot that was sent to its pile from one place, and another place on its way.
fn sent_off() -> (Desk, LeaseRef, Position) {
    let mut desk = Desk::new();
    let (far, near) = (desk.beside(PileId(5)), desk.beside(PileId(6)));
    desk.pile_says(P, Availability::Free, None);
    desk.robot_at(ROBOT, far, Activity::Waiting, None);
    desk.ask_from(ROBOT, 1, far, 5_000.0);
    desk.ack(P);
    assert_eq!(desk.led_from(ROBOT), Some(far));
    desk.robot_at(ROBOT, far, Activity::Approaching, Some(1));
    let lease = desk.last_command(P).unwrap().1;
    (desk, lease, near)
}

#[test]
fn a_robot_that_is_sent_to_its_pile_again_is_led_there_from_where_it_is_now() {
    let (mut desk, lease, near) = sent_off();
    desk.pile_says(P, Availability::Reserved, Some(lease));
    // It is called off on its way, and waits there.
    let ended = EndedLease { lease, reason: EndReason::Fault, charged: DurationMs(0) };
    desk.pile_reports(P, Availability::Fault, None, Some(ended), 0.0);
    desk.robot_at(ROBOT, near, Activity::Waiting, None);
    desk.wait(2_000);
    assert!(matches!(desk.sent_to_robot(ROBOT).last(), Some(Message::Unassigned(_))));
    desk.sent.clear();
    desk.pile_says(P, Availability::Free, None);
    desk.wait(1_000);
    desk.ack(P);
    desk.wait(1_000);
    assert_eq!(desk.led_from(ROBOT), Some(near));
}

#[test]
fn a_robot_that_started_anew_and_asks_under_the_same_number_is_led_from_where_it_is_now() {
    let (mut desk, _, near) = sent_off();
    desk.sent.clear();
    desk.boot = BootEpoch(2);
    desk.robot_at(ROBOT, near, Activity::Waiting, None);
    desk.ask_from(ROBOT, 1, near, 5_000.0);
    assert_eq!(desk.led_from(ROBOT), Some(near));
}

#[test]
fn a_robot_that_started_anew_is_led_nowhere_before_it_asks_anew() {
    let (mut desk, _, near) = sent_off();
    desk.sent.clear();
    desk.boot = BootEpoch(2);
    desk.robot_at(ROBOT, near, Activity::Waiting, None);
    desk.wait(2_000);
    // Its next request may have the number of the one before.
    assert_eq!(desk.led_from(ROBOT), None);
}

/// Robot 1 is charged at a pile that is promised to robot 2, which is on its way.
fn promised() -> (Desk, LeaseRef) {
    let (mut desk, lease) = Desk::granted();
    desk.pile_reports(P, Availability::Charging, Some(lease), None, 0.01);
    desk.robot_is(NEXT, Activity::Waiting, None);
    desk.ask(NEXT, 1);
    assert_eq!(desk.place(NEXT), Some(Place::Next(P)));
    (desk, lease)
}

const NEXT: RobotId = RobotId(2);

/// Who gets a pile that was promised to a robot which has then been silent for so long.
fn heir(silent_s: u64) -> Option<RobotId> {
    let (mut desk, lease) = promised();
    desk.wait(silent_s * 1_000);
    let ended = EndedLease { lease, reason: EndReason::Completed, charged: DurationMs(1_000) };
    desk.pile_reports(P, Availability::Free, None, Some(ended), 0.0);
    desk.state().lease(P).map(|lease| lease.name.robot)
}

#[test]
fn a_robot_that_is_cut_off_gets_the_pile_that_it_was_promised_and_a_lost_one_does_not() {
    assert_eq!(heir(5), Some(NEXT));
    assert_eq!(heir(55), Some(NEXT), "it may stand there already");
    assert_eq!(heir(65), None);
}

#[test]
fn a_robot_keeps_its_promise_while_the_pile_is_cut_off_and_waits_for_another_when_that_is_lost() {
    let (mut desk, _) = promised();
    let mut kept_s = 0;
    while desk.place(NEXT) == Some(Place::Next(P)) && kept_s < 100 {
        desk.wait(1_000);
        desk.robot_is(NEXT, Activity::Approaching, Some(1));
        kept_s += 1;
    }
    assert!((60..70).contains(&kept_s), "{kept_s}");
    assert_eq!(desk.place(NEXT), Some(Place::Waiting));
}

#[test]
fn a_robot_that_no_way_leads_to_its_pile_any_more_gives_it_up() {
    let mut desk = Desk::new();
    desk.pile_says(P, Availability::Free, None);
    desk.robot_is(ROBOT, Activity::Waiting, None);
    desk.ask(ROBOT, 1);
    assert_eq!(desk.place(ROBOT), Some(Place::Granted(P)));
    // From beside pile 7 a way leads to no other.
    let position = desk.beside(PileId(7));
    desk.robot_at(ROBOT, position, Activity::Waiting, None);
    desk.ack(P);
    assert_eq!(desk.phase(P), Some(Phase::Revoking { why: RevokeReason::NoWay }));
    assert_eq!((desk.place(ROBOT), desk.led_from(ROBOT)), (Some(Place::Waiting), None));
}

#[test]
fn a_robot_hears_that_it_was_heard_while_its_pile_does_not_answer() {
    let mut desk = Desk::new();
    desk.pile_says(P, Availability::Free, None);
    desk.robot_is(ROBOT, Activity::Waiting, None);
    desk.ask(ROBOT, 1);
    assert!(matches!(desk.phase(P), Some(Phase::Offered)));
    let heard = Unassigned { request: RequestId(1), reason: UnassignedReason::AllTaken };
    assert!(desk.sent_to_robot(ROBOT).contains(&&Message::Unassigned(heard)));
    desk.ack(P);
    assert_eq!(desk.led_from(ROBOT), Some(desk.beside(P)), "and is sent as soon as it does");
}
