//! A charge is cut short for a critical robot, and only then.

use super::*;

const CRITICAL: RobotId = RobotId(2);
const HOLD: DurationMs = DurationMs(120_000);

/// Robot 1 is charged for this long, has this energy and will do task 7; then robot 2 asks with almost
/// nothing left. Whether it gets the pile.
fn makes_way(charged: DurationMs, energy_j: f32, runs_j: &[f32]) -> Desk {
    let (mut desk, lease) = Desk::granted_for(Some(TaskId(7)));
    for &energy in runs_j {
        let energy = EnergyJ::new(energy).unwrap();
        let done = TaskEnergy { task: TaskId(7), runs: 1, last: energy, mean: energy };
        desk.hear(DeviceId::Robot(ROBOT), Message::TaskEnergy(done));
    }
    desk.elapsed = charged;
    desk.pile_reports(P, Availability::Charging, Some(lease), None, 0.5);
    let position = desk.beside(P);
    let energy = EnergyJ::new(energy_j).unwrap();
    let docked = RobotState { position, energy, activity: Activity::Docked, accepted: Some(RequestId(1)) };
    desk.hear(DeviceId::Robot(ROBOT), Message::RobotState(docked));
    desk.ask_from(CRITICAL, 1, position, 500.0);
    desk
}

#[test]
fn a_critical_robot_gets_the_pile_of_one_that_has_enough() {
    let mut desk = makes_way(HOLD, 9_000.0, &[]);
    assert_eq!(desk.phase(P), Some(Phase::Revoking { why: RevokeReason::Preempted }));
    assert_eq!(
        (desk.place(CRITICAL), desk.place(ROBOT)),
        (Some(Place::Next(P)), None),
        "one goes, one comes"
    );
    assert_eq!(desk.state().totals.preempted, 1);
    let decision = desk.state().decisions.front().unwrap();
    assert_eq!((decision.stage.as_str(), decision.chosen), ("preempting", Some(P)));
    let (_, lease, is_grant) = desk.last_command(P).unwrap();
    assert!(!is_grant);
    let ended = EndedLease { lease, reason: EndReason::Revoked, charged: HOLD };
    desk.pile_reports(P, Availability::Done, None, Some(ended), 0.0);
    assert_eq!(desk.phase(P), None, "the other still stands there");
    desk.pile_reports(P, Availability::Free, None, Some(ended), 0.0);
    assert_eq!(desk.state().lease(P).unwrap().name.robot, CRITICAL);
}

#[test]
fn a_pile_that_has_to_be_told_again_preempts_once() {
    let mut desk = makes_way(HOLD, 9_000.0, &[]);
    let commands =
        |desk: &Desk| desk.events.iter().filter(|event| matches!(event.fact, Fact::Revoked { .. })).count();
    let (_, lease, _) = desk.last_command(P).unwrap();
    for _ in 0..15 {
        desk.wait(1_000);
        desk.pile_reports(P, Availability::Charging, Some(lease), None, 0.5);
        desk.robot_is(CRITICAL, Activity::Waiting, None);
    }
    assert!(commands(&desk) > 1, "its command ran out and was given anew");
    assert_eq!(desk.state().totals.preempted, 1);
}

#[test]
fn nobody_makes_way_who_has_just_come_or_could_not_do_its_task_and_return() {
    let refuses = |desk: &Desk| {
        assert!(matches!(desk.phase(P), Some(Phase::Held { .. })));
        assert_eq!(
            (desk.place(CRITICAL), desk.place(ROBOT)),
            (Some(Place::Waiting), Some(Place::Granted(P)))
        );
    };
    refuses(&makes_way(DurationMs(HOLD.0 - 1), 9_000.0, &[]));
    refuses(&makes_way(HOLD, 4_000.0, &[]));
    // A task that takes 6,000 J, one that takes little, and one that can't be relied on.
    refuses(&makes_way(HOLD, 7_500.0, &[6_000.0; 5]));
    assert_eq!(makes_way(HOLD, 7_500.0, &[500.0; 5]).place(CRITICAL), Some(Place::Next(P)));
    refuses(&makes_way(HOLD, 7_500.0, &[500.0, 4_000.0, 500.0, 4_000.0, 500.0]));
}

#[test]
fn what_was_learned_of_a_task_outlives_a_restart() {
    let desk = makes_way(HOLD, 9_000.0, &[100.0, 300.0]);
    let profile = State::fold(&desk.events).profiles[&ROBOT][&TaskId(7)];
    assert_eq!((profile.runs, profile.mean_j), (2, 200.0));
}
