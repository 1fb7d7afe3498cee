//! Robots that are called to charge without having asked: by the coordinator, or by a person.

use host_coordinator::core::{
    event::Opener,
    orders::{Order, Refusal},
};

use super::*;

const CALL: RequestId = RequestId::FIRST_CALL;

/// Robot 1 works beside the pile, with so much left.
fn works(energy_j: f32) -> Desk {
    let mut desk = Desk::new();
    // Until the other piles, which are never heard, are lost.
    desk.wait(61_000);
    desk.pile_says(P, Availability::Free, None);
    work_on(&mut desk, &[ROBOT], energy_j, 6);
    desk
}

/// Robots report that they work beside the pile, for so many seconds.
fn work_on(desk: &mut Desk, robots: &[RobotId], energy_j: f32, seconds: u64) {
    let (energy, position) = (EnergyJ::new(energy_j).unwrap(), desk.beside(P));
    let state = RobotState { position, energy, activity: Activity::Working, accepted: None };
    for _ in 0..seconds {
        robots.iter().for_each(|robot| desk.hear(DeviceId::Robot(*robot), Message::RobotState(state)));
        desk.wait(1_000);
    }
}

fn opener(desk: &Desk, robot: RobotId) -> Option<Opener> {
    desk.state().requests.get(&robot).map(|request| request.opener)
}

#[test]
fn a_robot_is_called_when_its_battery_just_takes_it_to_a_pile_with_a_reserve_and_no_sooner() {
    assert_eq!(opener(&works(4_900.0), ROBOT), None);
    let mut desk = works(500.0);
    assert_eq!(opener(&desk, ROBOT), Some(Opener::Coordinator));
    desk.ack(P);
    let told = desk.sent_to_robot(ROBOT);
    assert!(matches!(told.last(), Some(Message::Assignment(part)) if part.request == CALL), "{told:?}");
    assert!(!told.iter().any(|message| matches!(message, Message::Unassigned(_))));
    // It leaves its work and comes.
    let (lease, now) = (desk.last_command(P).unwrap().1, CALL.0);
    desk.robot_is(ROBOT, Activity::Approaching, Some(now));
    desk.pile_says(P, Availability::Reserved, Some(lease));
    desk.wait(3_000);
    assert_eq!(desk.place(ROBOT), Some(Place::Granted(P)));
    assert_eq!(State::fold(&desk.events), *desk.state());
}

#[test]
fn robots_that_need_the_only_pile_about_the_same_time_are_called_sooner() {
    let alone = (1..50)
        .map(|hundreds| 100.0 * hundreds as f32)
        .rev()
        .find(|energy_j| opener(&works(*energy_j), ROBOT).is_some());
    let energy_j = alone.unwrap() + 200.0;
    let mut desk = works(energy_j);
    assert_eq!(opener(&desk, ROBOT), None);
    work_on(&mut desk, &[ROBOT, RobotId(2), RobotId(3)], energy_j, 6);
    assert!(!desk.state().requests.is_empty(), "somebody is called with {energy_j} J");
}

#[test]
fn a_robot_that_knows_of_no_calls_is_called_once() {
    let mut desk = works(500.0);
    desk.ack(P);
    let lease = desk.last_command(P).unwrap().1;
    for _ in 0..40 {
        desk.pile_says(P, Availability::Reserved, Some(lease));
        work_on(&mut desk, &[ROBOT], 500.0, 1);
    }
    assert_eq!(desk.phase(P), Some(Phase::Revoking { why: RevokeReason::Abandoned }));
    desk.ack(P);
    desk.pile_says(P, Availability::Free, None);
    work_on(&mut desk, &[ROBOT], 500.0, 20);
    assert_eq!(opener(&desk, ROBOT), None);
    // It asks by itself, and is charged.
    desk.robot_is(ROBOT, Activity::Waiting, None);
    work_on(&mut desk, &[ROBOT], 500.0, 6);
    assert_eq!(opener(&desk, ROBOT), Some(Opener::Coordinator));
}

#[test]
fn a_called_robot_that_asks_by_itself_keeps_its_place_and_its_time() {
    let mut desk = works(500.0);
    let asked_at = desk.state().requests[&ROBOT].asked_at;
    desk.wait(2_000);
    desk.ask(ROBOT, 1);
    let request = desk.state().requests[&ROBOT];
    assert_eq!((request.opener, request.asked_at, request.id), (Opener::Robot, asked_at, RequestId(1)));
}

#[test]
fn a_person_may_call_a_robot_that_has_enough_and_take_that_back() {
    let mut desk = works(9_000.0);
    let order = Order::Charge { robot: ROBOT, task: Some(TaskId(4)), priority: TaskPriority::MAX };
    desk.step(Input::Order(order));
    let request = desk.state().requests[&ROBOT];
    assert_eq!((request.opener, request.id, request.task), (Opener::Person, CALL, Some(TaskId(4))));
    assert_eq!(request.place, Place::Granted(P));
    let again = Refusal::Waiting { robot: ROBOT, request: CALL };
    assert_eq!(desk.coordinator.check(&order), Err(again));
    desk.ack(P);
    desk.robot_is(ROBOT, Activity::Approaching, Some(CALL.0));

    desk.sent.clear();
    desk.step(Input::Order(Order::Withdraw { request: CALL }));
    assert_eq!(desk.phase(P), Some(Phase::Revoking { why: RevokeReason::Withdrawn }));
    assert_eq!(desk.place(ROBOT), None);
    let withdrawn = Message::Unassigned(Unassigned { request: CALL, reason: UnassignedReason::Withdrawn });
    assert!(desk.sent_to_robot(ROBOT).contains(&&withdrawn));
    // It was not heard: the robot comes on, and is told again.
    desk.sent.clear();
    desk.robot_is(ROBOT, Activity::Approaching, Some(CALL.0));
    assert!(desk.sent_to_robot(ROBOT).contains(&&withdrawn));
    let gone = Refusal::UnknownRequest(CALL);
    assert_eq!(desk.coordinator.check(&Order::Withdraw { request: CALL }), Err(gone));
    // The next request has another number, also after a restart.
    let next = RequestId(CALL.0 + 1);
    assert_eq!((desk.state().next_call(), State::fold(&desk.events).next_call()), (next, next));
}

#[test]
fn orders_that_can_t_be_done_say_why() {
    let mut desk = works(500.0);
    let charge = |robot| Order::Charge { robot, task: None, priority: TaskPriority::USUAL };
    assert_eq!(desk.coordinator.check(&charge(RobotId(77))), Err(Refusal::UnknownRobot(RobotId(77))));
    assert_eq!(desk.coordinator.check(&charge(RobotId(2))), Err(Refusal::Unheard(RobotId(2))));
    let mine = Order::Withdraw { request: CALL };
    assert_eq!(desk.coordinator.check(&mine), Err(Refusal::NotOrdered(CALL)), "the coordinator called it");
    desk.ack(P);
    let lease = desk.last_command(P).unwrap().1;
    desk.pile_says(P, Availability::Charging, Some(lease));
    assert_eq!(desk.coordinator.check(&charge(ROBOT)), Err(Refusal::Charging(ROBOT)));
    assert_eq!(desk.coordinator.check(&mine), Err(Refusal::Charging(ROBOT)));
}

#[test]
fn a_request_in_an_old_log_was_the_robots() {
    let old = r#"{"asked":{"robot":1,"boot":1,"request":3,"position":{"x":1.0,"y":2.0},"energy":5.0}}"#;
    let fact: Fact = serde_json::from_str(old).unwrap();
    assert!(matches!(fact, Fact::Asked { opener: Opener::Robot, .. }), "{fact:?}");
}
