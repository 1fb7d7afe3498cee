//! Every row of the hazard table (`docs/hazards.md`) on the ARM core: the test bench of the image
//! breaks something, and the test sees what the pile commands, says and does afterwards.

use std::time::Duration;

use protocol::{Availability, EndReason, FaultCode, FaultState, Message, NackReason, Revoke};
use tests::pile_bench::{EPOCH, PileBench, ROBOT};

/// How the contactor opens.
#[derive(Clone, Copy)]
enum Opening {
    /// In the tick of the sample that shows why, whatever flows.
    AtOnce,
    /// When the current is gone.
    WithoutCurrent,
}

/// A pile that charges a robot, and then this is ordered.
fn charging_until(order: &str) -> PileBench {
    let mut pile = PileBench::new();
    pile.charge();
    pile.test.order(order).unwrap();
    pile
}

/// The order ends the charge with this fault, so many samples later at the most.
fn stops(order: &str, code: FaultCode, opening: Opening, most_ticks: u32) -> PileBench {
    let mut pile = charging_until(order);
    pile.reports(code, true);
    let off = pile.until("an open contactor", |power| !power.told_closed && !power.found_closed);
    assert_eq!(off.limit_a, 0.0);
    let reaction = pile.reaction().expect("the contactor was told to open");
    println!("{code:?}, {order:?}: {reaction:?}");
    assert!(reaction.ticks <= most_ticks, "{reaction:?}");
    match opening {
        Opening::AtOnce => assert!(reaction.current_a > 10.0, "it waited: {reaction:?}"),
        Opening::WithoutCurrent => assert!(reaction.current_a < 0.5, "opened under load: {reaction:?}"),
    }
    let state = pile.state_where("that it has a fault", |state| state.ended.is_some());
    assert_eq!(state.ended.map(|ended| ended.reason), Some(EndReason::Fault));
    assert_eq!(state.row.availability, Availability::Fault);
    pile
}

/// The fault outlives its cause, until it is cleared. It does not before if its `cause` lasts.
fn is_latched(mut pile: PileBench, code: FaultCode, cause: Cause, mend: &str) {
    if cause == Cause::Lasts {
        assert_eq!(pile.clear(code), Err(NackReason::NotCleared));
    }
    pile.test.order(mend).unwrap();
    // A fault is over when its cause has been gone for a second.
    pile.hears_for(Duration::from_millis(1_500));
    assert_eq!(pile.state().row.availability, Availability::Fault);
    assert_eq!(pile.clear(code), Ok(()));
    pile.state_where("that it is well", |state| state.row.availability != Availability::Fault);
    pile.reports(code, false);
    assert_eq!(pile.faults, [(code, true), (code, false)]);
    assert_eq!(pile.closings(), 1, "a new charge began without a new lease");
}

/// Whether the cause of a fault can still be seen when the contactor is open.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Cause {
    Lasts,
    Ends,
}

/// The fault goes with its cause, and nothing begins by itself.
fn heals(mut pile: PileBench, code: FaultCode, mend: &str) {
    pile.test.order(mend).unwrap();
    pile.state_where("that it is well", |state| state.row.availability != Availability::Fault);
    pile.hears_for(Duration::from_millis(1_500));
    assert_eq!(pile.faults, [(code, true), (code, false)]);
    assert_eq!(pile.closings(), 1, "a new charge began without a new lease");
}

#[test]
fn an_over_current_opens_at_once() {
    let pile = stops("current about 30", FaultCode::OverCurrent, Opening::AtOnce, 0);
    is_latched(pile, FaultCode::OverCurrent, Cause::Lasts, "current truth");
}

#[test]
fn a_short_circuit_beyond_the_sensors_range_opens_at_once() {
    let mut pile = stops("current about inf", FaultCode::OverCurrent, Opening::AtOnce, 0);
    pile.reports(FaultCode::CurrentSensor, true);
}

#[test]
fn a_power_stage_that_exceeds_its_limit_is_cut_off() {
    // Less than an over-current, more than it was told to give.
    let pile = stops("runaway 25", FaultCode::OverCurrent, Opening::AtOnce, 20);
    is_latched(pile, FaultCode::OverCurrent, Cause::Ends, "runaway 0");
}

#[test]
fn an_over_voltage_stops_the_charge() {
    let pile = stops("voltage about 31", FaultCode::OverVoltage, Opening::WithoutCurrent, 30);
    is_latched(pile, FaultCode::OverVoltage, Cause::Lasts, "voltage truth");
}

#[test]
fn warm_contacts_get_less_current_and_hot_ones_none() {
    let mut pile = charging_until("temperature about 75");
    let power = pile.until("a quarter of the current", |power| power.current_a < 5.1);
    assert!(power.told_closed && power.current_a > 4.9, "{power:?}");
    assert_eq!(pile.faults, []);
    let pile = stops("temperature about 85", FaultCode::OverTemperature, Opening::WithoutCurrent, 30);
    is_latched(pile, FaultCode::OverTemperature, Cause::Lasts, "temperature truth");
}

#[test]
fn a_robot_with_reversed_poles_is_not_connected() {
    let mut pile = PileBench::new();
    pile.test.order("reversed 1").unwrap();
    pile.reports(FaultCode::ReversedPolarity, true);
    pile.state_where("that it has a fault", |state| state.row.availability == Availability::Fault);
    pile.test.order("reversed 0").unwrap();
    pile.state_where("that it is well", |state| state.row.availability == Availability::Free);
    assert_eq!(pile.closings(), 0);
}

#[test]
fn a_robot_whose_battery_is_of_another_kind_or_missing_is_not_connected() {
    let mut pile = PileBench::new();
    pile.test.order("voltage about 12").unwrap();
    let lease = pile.granted();
    pile.reader.dock(ROBOT);
    pile.state_where("that the robot has come", |state| state.row.availability == Availability::Charging);
    assert_eq!(pile.stays_dead_for(3).holder, Some(lease));
    pile.test.order("voltage truth").unwrap();
    pile.until("that it charges", |power| power.current_a > 1.0);
}

#[test]
fn a_robot_that_pulls_off_its_contacts_is_disconnected() {
    let mut pile = charging_until("robot 0");
    pile.until("an open contactor", |power| !power.told_closed);
    let reaction = pile.reaction().unwrap();
    assert!(reaction.ticks <= 30, "{reaction:?}");
    assert_eq!(pile.faults, []);
    pile.reader.clear();
    let state = pile.state_where("that the lease is over", |state| state.ended.is_some());
    assert_eq!(state.ended.map(|ended| ended.reason), Some(EndReason::RobotLeft));
}

#[test]
fn a_welded_contactor_is_found_when_it_should_open() {
    let mut pile = PileBench::new();
    let lease = pile.charge();
    pile.test.order("welded 1").unwrap();
    let command = pile.next_command();
    let head = pile.grant(command, EPOCH).head;
    pile.say(Message::Revoke(Revoke { head, lease }));
    assert_eq!(pile.answer(command), Ok(()));
    pile.reports(FaultCode::ContactorWelded, true);
    let power = pile.power();
    assert!(!power.told_closed && power.found_closed && power.current_a < 0.5, "{power:?}");
    is_latched(pile, FaultCode::ContactorWelded, Cause::Lasts, "welded 0");
}

#[test]
fn a_contactor_that_will_not_close_is_found_and_gets_no_current() {
    let mut pile = PileBench::new();
    pile.test.order("jammed 1").unwrap();
    pile.granted();
    pile.reader.dock(ROBOT);
    pile.reports(FaultCode::ContactorStuckOpen, true);
    let power = pile.until("a contactor told to be open", |power| !power.told_closed);
    assert_eq!(power.limit_a, 0.0);
    is_latched(pile, FaultCode::ContactorStuckOpen, Cause::Ends, "jammed 0");
}

#[test]
fn a_contactor_that_drops_out_takes_the_current_with_it() {
    let pile = stops("jammed 1", FaultCode::ContactorStuckOpen, Opening::WithoutCurrent, 60);
    is_latched(pile, FaultCode::ContactorStuckOpen, Cause::Ends, "jammed 0");
}

#[test]
fn a_current_past_the_open_contactor_is_found() {
    let mut pile = PileBench::new();
    pile.test.order("leak 2").unwrap();
    pile.reports(FaultCode::StrayCurrent, true);
    assert_eq!(pile.clear(FaultCode::StrayCurrent), Err(NackReason::NotCleared));
    pile.test.order("leak 0").unwrap();
    pile.hears_for(Duration::from_millis(1_500));
    assert_eq!(pile.clear(FaultCode::StrayCurrent), Ok(()));
    pile.state_where("that it is well", |state| state.row.availability == Availability::Free);
}

#[test]
fn a_voltage_where_nothing_touches_the_contacts_is_found() {
    let mut pile = PileBench::new();
    pile.test.order("robot 0").unwrap();
    pile.test.order("voltage about 25").unwrap();
    pile.reports(FaultCode::VoltageSensor, true);
    pile.state_where("that it has a fault", |state| state.row.availability == Availability::Fault);
}

#[test]
fn a_voltage_sensor_that_is_no_number_railed_or_stuck_is_a_fault() {
    for (order, most_ticks) in [("about nan", 30), ("about 60.1", 30), ("exactly 25.5", 230)] {
        let order = format!("voltage {order}");
        let pile = stops(&order, FaultCode::VoltageSensor, Opening::WithoutCurrent, most_ticks);
        is_latched(pile, FaultCode::VoltageSensor, Cause::Lasts, "voltage truth");
    }
}

#[test]
fn a_battery_whose_voltage_vanishes_under_charge_is_a_fault() {
    let pile = stops("voltage about 3", FaultCode::VoltageSensor, Opening::WithoutCurrent, 130);
    is_latched(pile, FaultCode::VoltageSensor, Cause::Ends, "voltage truth");
}

#[test]
fn a_current_sensor_that_is_no_number_or_stuck_is_a_fault() {
    for (order, most_ticks) in [("about nan", 32), ("exactly 19.0", 250)] {
        let order = format!("current {order}");
        let pile = stops(&order, FaultCode::CurrentSensor, Opening::WithoutCurrent, most_ticks);
        drop(pile);
    }
}

#[test]
fn a_current_sensor_that_shows_nothing_while_current_flows_is_a_fault() {
    let pile = stops("current about 0", FaultCode::CurrentSensor, Opening::WithoutCurrent, 330);
    is_latched(pile, FaultCode::CurrentSensor, Cause::Ends, "current truth");
}

#[test]
fn a_temperature_sensor_that_is_no_number_off_its_wire_or_stuck_is_a_fault() {
    for (order, most_ticks) in
        [("about nan", 30), ("about -40", 30), ("about 130", 30), ("exactly 30.0", 230)]
    {
        let order = format!("temperature {order}");
        let pile = stops(&order, FaultCode::TemperatureSensor, Opening::WithoutCurrent, most_ticks);
        is_latched(pile, FaultCode::TemperatureSensor, Cause::Lasts, "temperature truth");
    }
}

#[test]
fn an_emergency_stop_opens_at_once_and_its_release_starts_nothing() {
    let pile = stops("stop 1", FaultCode::EmergencyStop, Opening::AtOnce, 0);
    heals(pile, FaultCode::EmergencyStop, "stop 0");
}

#[test]
fn lost_mains_are_told_in_one_last_frame() {
    let mut pile = charging_until("mains 0");
    let told = pile.expect("its last word", |message| match message {
        Message::PileFaults(told) => Some(told.clone()),
        _ => None,
    });
    assert_eq!(
        told.faults.as_slice(),
        [FaultState { code: FaultCode::MainsLost, active: true, latched: false }]
    );
    pile.until("an open contactor", |power| !power.told_closed);
    let reaction = pile.reaction().unwrap();
    assert!(reaction.ticks <= 30 && reaction.current_a < 0.5, "{reaction:?}");
    assert_eq!(pile.hears_for(Duration::from_secs(3)), [], "it was not its last word");
    heals(pile, FaultCode::MainsLost, "mains 1");
}

#[test]
fn a_reader_that_falls_silent_ends_the_charge() {
    let mut pile = PileBench::new();
    pile.charge();
    pile.reader.fall_silent();
    pile.until("an open contactor", |power| !power.told_closed && power.current_a < 0.5);
    pile.reports(FaultCode::ReaderSilent, true);
    let state = pile.state_where("that it has a fault", |state| state.ended.is_some());
    assert_eq!(state.ended.map(|ended| ended.reason), Some(EndReason::Fault));
}

#[test]
fn a_task_that_hangs_ends_in_a_reset_with_an_open_contactor() {
    let mut pile = PileBench::new();
    pile.charge();
    pile.resets = true;
    pile.test.hang().unwrap();
    pile.expect("its Hello after a reset", |message| match message {
        Message::Hello(hello) => Some(*hello),
        _ => None,
    });
    let state = pile.state_where("its state after the reset", |state| !state.energised);
    assert_eq!(state.holder, None);
    assert!(!pile.power().told_closed);
}
