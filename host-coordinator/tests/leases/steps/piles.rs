//! What piles answer, and what becomes of their leases and promises.

use super::*;

#[test]
fn a_grant_is_repeated_every_second_and_taken_back_when_it_is_not_answered() {
    let mut desk = Desk::new();
    desk.pile_says(P, Availability::Free, None);
    desk.ask(ROBOT, 1);
    let (first, lease, _) = desk.last_command(P).unwrap();
    desk.wait(9_900);
    let grants = desk.sent.iter().filter(|(_, message)| matches!(message, Message::Grant(_))).count();
    assert!((9..=11).contains(&grants), "{grants}");
    assert_eq!(desk.last_command(P).unwrap().0, first, "a repeat has the same number");
    desk.wait(300);
    let (_, revoked, is_grant) = desk.last_command(P).unwrap();
    assert!(!is_grant && revoked.lease == lease.lease);
    assert_eq!(desk.place(ROBOT), Some(Place::Waiting));
    // Until the pile answers, or the lease has run out there, nobody else gets the pile.
    desk.pile_says(P, Availability::Free, None);
    desk.ask(RobotId(2), 1);
    assert_eq!(desk.place(RobotId(2)), Some(Place::Waiting));
    desk.ack(P);
    assert_eq!(desk.ends(), [LeaseEnd::Revoked]);
    assert!(matches!(desk.place(RobotId(2)), Some(Place::Granted(P))));
}

#[test]
fn a_pile_that_refuses_is_left_alone_and_the_robot_is_sent_elsewhere() {
    let other = PileId(5);
    let held = LeaseRef { epoch: Epoch(1), lease: LeaseId(0), robot: RobotId(9) };
    for reason in [NackReason::Occupied, NackReason::Faulted, NackReason::Held { by: held }] {
        let mut desk = Desk::new();
        desk.pile_says(P, Availability::Free, None);
        desk.ask(ROBOT, 1);
        desk.pile_says(other, Availability::Free, None);
        desk.nack(P, reason);
        assert_eq!(desk.phase(P), Some(Phase::Refused), "{reason:?}");
        assert_eq!(desk.place(ROBOT), Some(Place::Granted(other)), "{reason:?}");
        desk.wait(16_000);
        assert_eq!(desk.phase(P), None, "no copy of the grant can arrive any more");
    }
}

#[test]
fn a_pile_without_a_clock_is_asked_again_under_the_same_lease() {
    for reason in [NackReason::ClockUnknown, NackReason::TooLate] {
        let mut desk = Desk::new();
        desk.pile_says(P, Availability::Free, None);
        desk.ask(ROBOT, 1);
        let (command, lease, _) = desk.last_command(P).unwrap();
        desk.nack(P, reason);
        desk.wait(1_100);
        let (again, same, is_grant) = desk.last_command(P).unwrap();
        assert!(is_grant && again != command && same == lease, "{reason:?}");
        desk.ack(P);
        assert!(matches!(desk.phase(P), Some(Phase::Held { .. })));
    }
}

#[test]
fn a_silent_pile_keeps_its_lease_until_it_must_have_run_out() {
    let (mut desk, _) = Desk::granted();
    let mut lasted = 0;
    while desk.phase(P).is_some() {
        desk.wait(1_000);
        desk.robot_is(ROBOT, Activity::Approaching, Some(1));
        lasted += 1;
        assert!(lasted < 200);
    }
    let lease = desk.events.iter().rev().find_map(|event| match event.fact {
        Fact::Ended { why: LeaseEnd::RanOut, .. } => Some(event.at),
        _ => None,
    });
    let last_expiry = desk.events.iter().filter_map(|event| match event.fact {
        Fact::Granted { expiry, .. } | Fact::Extended { expiry, .. } => Some(expiry),
        _ => None,
    });
    assert!(lease.unwrap() > last_expiry.max().unwrap());
    assert_eq!(desk.place(ROBOT), Some(Place::Waiting));
}

#[test]
fn an_almost_charged_pile_is_promised_to_one_robot_and_given_when_it_is_free() {
    let (mut desk, lease) = Desk::granted();
    desk.pile_reports(P, Availability::Charging, Some(lease), None, 0.05);
    desk.ask(RobotId(2), 1);
    desk.ask(RobotId(3), 1);
    assert_eq!(desk.place(RobotId(2)), Some(Place::Next(P)));
    assert_eq!(desk.place(RobotId(3)), Some(Place::Waiting), "it is promised once");
    assert!(matches!(desk.sent_to_robot(RobotId(2))[..], [.., Message::Assignment(_)]), "it may set off");
    let ended = EndedLease { lease, reason: EndReason::Completed, charged: DurationMs(1) };
    desk.pile_reports(P, Availability::Done, None, Some(ended), 0.0);
    assert_eq!(desk.phase(P), None, "the charged robot still stands there");
    desk.pile_reports(P, Availability::Free, None, Some(ended), 0.0);
    assert_eq!(desk.state().lease(P).unwrap().name.robot, RobotId(2));
    assert_eq!(desk.state().totals.charges_completed, 1);
}

#[test]
fn a_promise_ends_when_the_charged_robot_does_not_leave() {
    let (mut desk, lease) = Desk::granted();
    desk.pile_reports(P, Availability::Charging, Some(lease), None, 0.05);
    desk.ask(RobotId(2), 1);
    let ended = EndedLease { lease, reason: EndReason::Completed, charged: DurationMs(1) };
    desk.pile_reports(P, Availability::Done, None, Some(ended), 0.0);
    for second in 0..40 {
        desk.wait(1_000);
        desk.robot_is(RobotId(2), Activity::Waiting, None);
        desk.pile_reports(P, Availability::Done, None, Some(ended), 0.0);
        let kept = desk.place(RobotId(2)) == Some(Place::Next(P));
        assert_eq!(kept, second < 30, "after {second} s");
    }
}

#[test]
fn a_promise_that_cannot_be_kept_is_released() {
    let (mut desk, lease) = Desk::granted();
    desk.pile_reports(P, Availability::Charging, Some(lease), None, 0.05);
    desk.ask(RobotId(2), 1);
    let ended = EndedLease { lease, reason: EndReason::Fault, charged: DurationMs(1) };
    desk.pile_reports(P, Availability::Fault, None, Some(ended), 0.0);
    assert_eq!(desk.place(RobotId(2)), Some(Place::Waiting));
    assert_eq!(desk.place(ROBOT), Some(Place::Waiting), "its charge was cut short");
}

#[test]
fn a_pile_that_says_farewell_gets_no_robot_and_is_named() {
    let mut desk = Desk::new();
    desk.pile_says(P, Availability::Free, None);
    let state = FaultState { code: FaultCode::MainsLost, active: true, latched: false };
    let faults = [state].into_iter().collect();
    desk.hear(DeviceId::Pile(P), Message::PileFaults(PileFaults { faults }));
    assert!(desk.warnings.iter().any(|warning| warning.contains("pile 2") && warning.contains("mains_lost")));
    desk.ask(ROBOT, 1);
    assert_eq!(desk.place(ROBOT), Some(Place::Waiting));
    desk.pile_says(P, Availability::Free, None);
    desk.wait(1_000);
    assert_eq!(desk.place(ROBOT), Some(Place::Granted(P)));
}

#[test]
fn a_pile_whose_lease_ran_out_unheard_may_charge_on_and_counts_until_it_is_heard() {
    let (mut desk, _) = Desk::granted();
    let granted_w = |desk: &Desk| desk.coordinator.view(desk.now).totals.granted_w;
    desk.wait(120_000);
    assert_eq!((desk.phase(P), desk.ends()), (None, vec![LeaseEnd::RanOut]));
    assert_eq!(granted_w(&desk), 500.0, "its robot may have come meanwhile");
    let mut again = Desk { now: desk.now, ..Desk::with_log(desk.events) };
    again.wait(60_000);
    assert_eq!(granted_w(&again), 500.0, "nobody has heard the pile since");
    again.boot = BootEpoch(2);
    again.pile_says(P, Availability::Free, None);
    assert_eq!(granted_w(&again), 0.0);
}
