//! A coordinator that is back, and what robots and piles have settled without it.

use super::*;

const Q: PileId = PileId(5);
const OTHER: RobotId = RobotId(2);

fn claimed(robot: RobotId) -> LeaseRef {
    LeaseRef { epoch: Epoch(1), lease: LeaseId::local(7), robot }
}

impl Desk {
    fn has_adopted(&self, pile: PileId) -> bool {
        self.events.iter().any(|event| matches!(event.fact, Fact::Adopted { pile: of, .. } if of == pile))
    }
}

#[test]
fn a_pile_that_was_claimed_is_adopted_and_its_robot_gets_no_other_and_is_not_called_off() {
    let mut desk = Desk::new();
    desk.robot_is(ROBOT, Activity::Waiting, None);
    desk.ask(ROBOT, 1);
    assert_eq!(desk.place(ROBOT), Some(Place::Waiting));
    // It is on its way by itself, and heard before its pile and another that is free.
    desk.sent.clear();
    let before = desk.state().next_lease;
    desk.robot_is(ROBOT, Activity::Approaching, Some(1));
    desk.pile_says(P, Availability::Reserved, Some(claimed(ROBOT)));
    desk.pile_says(Q, Availability::Free, None);
    desk.wait(2_000);
    assert!(desk.has_adopted(P));
    assert_eq!(desk.place(ROBOT), Some(Place::Granted(P)));
    let (_, extended, is_grant) = desk.last_command(P).unwrap();
    assert!(is_grant && extended.lease == LeaseId::local(7), "it is extended as any other");
    assert_eq!(desk.state().next_lease, before, "its number is of another kind");
    let told = desk.sent_to_robot(ROBOT);
    assert!(
        told.iter().all(|message| !matches!(message, Message::Unassigned(_) | Message::Assignment(_))),
        "{told:?}"
    );
    assert_eq!(desk.last_command(Q), None);
}

#[test]
fn a_robot_that_was_granted_another_pile_keeps_the_one_where_it_is_charged() {
    for (availability, keeps) in [(Availability::Charging, P), (Availability::Reserved, Q)] {
        let mut desk = Desk::new();
        desk.robot_is(ROBOT, Activity::Waiting, None);
        desk.pile_says(Q, Availability::Free, None);
        desk.ask(ROBOT, 1);
        desk.ack(Q);
        let granted = desk.last_command(Q).unwrap().1;
        desk.pile_says(Q, Availability::Reserved, Some(granted));
        desk.pile_says(P, availability, Some(claimed(ROBOT)));
        assert_eq!(desk.place(ROBOT), Some(Place::Granted(keeps)), "{availability:?}");
        let given_up = if keeps == P { Q } else { P };
        assert!(matches!(desk.phase(given_up), Some(Phase::Revoking { .. })), "{availability:?}");
        assert!(!desk.last_command(given_up).unwrap().2);
    }
}

#[test]
fn whom_the_pile_was_promised_meanwhile_is_decided_anew() {
    let mut desk = Desk::new();
    let first = LeaseRef { epoch: Epoch(1), lease: LeaseId(0), robot: RobotId(3) };
    desk.pile_reports(P, Availability::Charging, Some(first), None, 0.05);
    desk.robot_is(OTHER, Activity::Waiting, None);
    desk.ask(OTHER, 1);
    assert_eq!(desk.place(OTHER), Some(Place::Next(P)));
    // The pile was not heard; the robot on it left, and another has claimed it.
    let ended = EndedLease { lease: first, reason: EndReason::RobotLeft, charged: DurationMs(60_000) };
    desk.pile_reports(P, Availability::Charging, Some(claimed(ROBOT)), Some(ended), 0.9);
    desk.pile_reports(P, Availability::Charging, Some(claimed(ROBOT)), Some(ended), 0.9);
    assert!(desk.has_adopted(P));
    let released = |event: &Event| event.fact == Fact::NextReleased { pile: P, robot: OTHER };
    let at = desk.events.iter().position(released).expect("the promise stands as if nothing had happened");
    let again = |event: &Event| matches!(&event.fact, Fact::Decided(decision) if decision.robot == OTHER);
    assert!(desk.events[at..].iter().any(again));
    assert_ne!(desk.place(OTHER), None);
}

#[test]
fn piles_may_serve_claims_only_where_the_facility_has_no_cap_on_power() {
    for (power_cap_w, allowed) in [(None, true), (Some(1_000.0), false)] {
        let mut desk = Desk::new();
        let policy = Policy { power_cap_w, ..Policy::default() };
        let memory = desk.site.lmpp(1.0);
        desk.coordinator = Coordinator::recover(Arc::clone(&desk.site), memory, policy, &[], &[]);
        desk.hear(DeviceId::Pile(P), Message::TimeRequest(TimeRequest { asked_at: Millis(5) }));
        let rule = (DeviceId::Pile(P), Message::ClaimRule(ClaimRule { allowed }));
        assert!(desk.sent.contains(&rule), "{power_cap_w:?}");
    }
}
