//! What holds over restarts, lost logs, and frames that are old or come again.

use super::*;

#[test]
fn a_coordinator_goes_beyond_every_epoch_it_hears_of() {
    let mut desk = Desk::new();
    assert_eq!(desk.state().epoch, Epoch(1));
    let hello = Hello { min: 1, current: 1, software: [0; 3], epoch: Epoch(7) };
    desk.hear(DeviceId::Pile(P), Message::Hello(hello));
    assert_eq!(desk.state().epoch, Epoch(8));
    desk.pile_says(P, Availability::Free, None);
    desk.ask(ROBOT, 1);
    desk.nack(P, NackReason::StaleEpoch { highest: Epoch(20) });
    assert_eq!(desk.state().epoch, Epoch(21));
    desk.wait(1_100);
    let (_, lease, is_grant) = desk.last_command(P).unwrap();
    assert!(is_grant && lease.epoch == Epoch(21));
}

#[test]
fn after_a_lost_log_no_lease_number_comes_again_and_a_charge_goes_on() {
    let mut desk = Desk::new();
    let old = LeaseRef { epoch: Epoch(1), lease: LeaseId(40), robot: RobotId(3) };
    desk.pile_says(P, Availability::Charging, Some(old));
    desk.robot_is(RobotId(3), Activity::Docked, Some(9));
    desk.wait(1_000);
    let (_, lease, is_grant) = desk.last_command(P).unwrap();
    assert!(is_grant && lease.lease == LeaseId(40) && lease.epoch > Epoch(1), "it is extended: {lease:?}");
    // A mere reservation is taken back, since nobody knows whether its robot comes.
    let other = PileId(5);
    let old = LeaseRef { epoch: Epoch(1), lease: LeaseId(41), robot: RobotId(2) };
    desk.pile_says(other, Availability::Reserved, Some(old));
    assert!(!desk.last_command(other).unwrap().2);
    desk.pile_says(PileId(6), Availability::Free, None);
    desk.ask_from(ROBOT, 1, desk.beside(PileId(6)), 5_000.0);
    assert_eq!(desk.last_command(PileId(6)).unwrap().1.lease, LeaseId(42));
}

#[test]
fn old_frames_and_frames_of_earlier_starts_are_not_heard() {
    let (mut desk, lease) = Desk::granted();
    let frame = |boot, sequence| {
        let row = PileRow {
            pile: P,
            boot: BootEpoch(boot),
            version: 0,
            stamp: None,
            availability: Availability::Free,
            remaining: Fraction::MIN,
            planned: DurationMs(0),
        };
        let state = PileState {
            row,
            elapsed: DurationMs(0),
            holder: None,
            energised: false,
            ended: None,
            standing: None,
            current: None,
        };
        let header = Header::new(DeviceId::Pile(P), BootEpoch(boot), Sequence(sequence));
        Input::Frame(Frame { header, message: Message::PileState(state) })
    };
    for old in [frame(1, 1), frame(1, desk.sequence - 1), frame(0, 99)] {
        desk.step(old);
        assert_eq!(desk.state().lease(P).map(|held| held.name), Some(lease));
    }
    desk.step(frame(2, 0));
    assert_eq!(desk.ends(), [LeaseEnd::Lost], "a pile that started anew has no lease");
}

#[test]
fn reports_count_once_however_often_they_come() {
    let mut desk = Desk::new();
    let report = |boot, number, passes| {
        let tag = TagId([1; 12]);
        let count = PassCount { tag, period: 3, passes };
        let stranger = PassCount { tag: TagId([99; 12]), period: 3, passes: 50 };
        let absurd = PassCount { tag, period: 60_000, passes: 50 };
        let passes = [count, stranger, absurd].into_iter().collect();
        Message::PassReport(PassReport { report: ReportId { boot: BootEpoch(boot), number }, passes })
    };
    for (number, passes) in [(1, 4), (1, 4), (2, 1), (1, 4)] {
        desk.sent.clear();
        desk.hear(DeviceId::Pile(P), report(1, number, passes));
        let ack = Message::Ack(Ack { of: Reference::Report(ReportId { boot: BootEpoch(1), number }) });
        assert!(desk.sent.iter().any(|(_, message)| *message == ack), "a repeat is answered again");
    }
    desk.hear(DeviceId::Pile(PileId(5)), report(1, 1, 15));
    assert_eq!(desk.state().pass_frequency(ROBOT, 3, P), 0.25);
    assert_eq!(desk.state().pass_frequency(ROBOT, 4, P), 0.0);
    assert_eq!(desk.state().passes.len(), 1);
    desk.boot = BootEpoch(2);
    desk.hear(DeviceId::Pile(P), report(1, 2, 1));
    assert_eq!(desk.state().pass_frequency(ROBOT, 3, P), 0.25, "an old report after a new start");
    desk.hear(DeviceId::Pile(P), report(2, 1, 10));
    assert_eq!(desk.state().pass_frequency(ROBOT, 3, P), 0.5, "a new start numbers anew");
}

#[test]
fn a_charge_is_noted_once_and_acknowledged_as_often_as_it_is_reported() {
    let mut desk = Desk::new();
    let id = |boot, number| ReportId { boot: BootEpoch(boot), number };
    let report = |report, energy_j| {
        Message::ChargeReport(ChargeReport {
            report,
            lease: LeaseRef { epoch: Epoch(1), lease: LeaseId(4), robot: ROBOT },
            tag: TagId([1; 12]),
            reason: EndReason::Completed,
            began: SiteMillis(1_000),
            ended: Some(SiteMillis(61_000)),
            charged: DurationMs(60_000),
            energy: EnergyJ::new(energy_j).unwrap(),
        })
    };
    for (of, energy_j) in [(id(1, 1), 500.0), (id(1, 1), 500.0), (id(1, 3), 20.0), (id(1, 1), 500.0)] {
        desk.sent.clear();
        desk.hear(DeviceId::Pile(P), report(of, energy_j));
        let ack = Message::Ack(Ack { of: Reference::Report(of) });
        assert!(desk.sent.iter().any(|(_, message)| *message == ack), "a repeat is answered again");
    }
    // After a restart of the pile what it has in its journal comes first, and some of it again.
    desk.boot = BootEpoch(2);
    for (of, energy_j) in [(id(1, 3), 20.0), (id(1, 4), 3.0), (id(2, 1), 1.0)] {
        desk.hear(DeviceId::Pile(P), report(of, energy_j));
    }
    let energies: Vec<f32> = desk.state().charges.iter().map(|charge| charge.energy.get()).collect();
    assert_eq!(energies, [1.0, 3.0, 20.0, 500.0], "newest first");
    assert_eq!(desk.state().totals.energy_j, 524.0);
    // Nor does a restart of the coordinator count one twice.
    let mut desk = Desk::with_log(desk.events);
    desk.boot = BootEpoch(2);
    desk.hear(DeviceId::Pile(P), report(id(2, 1), 1.0));
    assert_eq!(desk.state().charges.len(), 4);
}

#[test]
fn a_restart_keeps_leases_and_extends_them_under_the_new_epoch() {
    let (desk, lease) = Desk::granted();
    let before = *desk.state().lease(P).unwrap();
    let mut desk = Desk::with_log(desk.events);
    let after = desk.state().lease(P).unwrap();
    assert_eq!((after.name, after.phase), (before.name, before.phase));
    desk.pile_says(P, Availability::Reserved, Some(lease));
    desk.robot_is(ROBOT, Activity::Approaching, Some(1));
    let (_, extended, is_grant) = desk.last_command(P).unwrap();
    assert!(is_grant);
    assert_eq!(extended, LeaseRef { epoch: Epoch(lease.epoch.0 + 1), ..lease });
    assert!(!desk.sent.iter().any(|(_, message)| matches!(message, Message::Assignment(_))));
}

#[test]
fn after_a_restart_a_report_that_may_be_older_than_the_lease_does_not_end_it() {
    let (granted, lease) = Desk::granted();
    let restarted = || {
        let mut desk = Desk::with_log(granted.events.clone());
        desk.robot_is(ROBOT, Activity::Approaching, Some(1));
        desk.pile_says(P, Availability::Free, None);
        assert!(matches!(desk.phase(P), Some(Phase::Held { .. })));
        assert_eq!(desk.last_command(P).unwrap().1.lease, lease.lease, "the pile is asked");
        desk
    };
    let mut desk = restarted();
    desk.ack(P);
    assert!(matches!(desk.phase(P), Some(Phase::Held { .. })));
    let mut desk = restarted();
    desk.nack(P, NackReason::Ended);
    assert_ne!(desk.state().lease(P).unwrap().name.lease, lease.lease, "the free pile is granted anew");
}

#[test]
fn a_first_time_and_a_device_of_no_site_are_answered_and_refused() {
    let mut desk = Desk::new();
    let asked = Message::TimeRequest(TimeRequest { asked_at: Millis(55) });
    desk.hear(DeviceId::Pile(P), asked.clone());
    let sync = Message::TimeSync(TimeSync { asked_at: Millis(55), site_now: desk.now });
    assert!(desk.sent.contains(&(DeviceId::Pile(P), sync)));
    desk.sent.clear();
    for stranger in [DeviceId::Pile(PileId(77)), DeviceId::Robot(RobotId(77)), DeviceId::Coordinator] {
        desk.hear(stranger, asked.clone());
    }
    assert!(desk.sent.is_empty());
    assert_eq!(desk.warnings.len(), 3);
}

#[test]
fn after_a_restart_a_robot_is_led_from_where_it_is_and_not_from_where_it_asked() {
    let (before, lease) = Desk::granted();
    let mut desk = Desk::with_log(before.events);
    desk.pile_says(P, Availability::Reserved, Some(lease));
    // It is heard, but where it is it has not said yet.
    desk.hear(DeviceId::Robot(ROBOT), Message::Hello(Hello::new(Epoch(0))));
    desk.wait(1_000);
    assert_eq!(desk.led_from(ROBOT), None);
    let elsewhere = desk.beside(PileId(6));
    desk.robot_at(ROBOT, elsewhere, Activity::Waiting, None);
    desk.wait(1_000);
    assert_eq!(desk.led_from(ROBOT), Some(elsewhere));
}

#[test]
fn after_a_restart_nothing_is_chosen_for_a_robot_before_it_says_where_it_is() {
    let mut before = Desk::new();
    before.robot_is(ROBOT, Activity::Waiting, None);
    before.ask(ROBOT, 1);
    let mut desk = Desk::with_log(before.events);
    desk.pile_says(P, Availability::Free, None);
    desk.wait(2_000);
    assert_eq!(desk.place(ROBOT), Some(Place::Waiting));
    desk.robot_is(ROBOT, Activity::Waiting, None);
    desk.wait(1_000);
    assert_eq!(desk.place(ROBOT), Some(Place::Granted(P)));
}
