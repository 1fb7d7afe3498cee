//! Whole charges, as a coordinator and a robot see them.

use firmware_pile::Power;
use protocol::*;

use crate::bench::{BATTERY, Bench, Reader, ack, nack, tag};

#[test]
fn a_charge_goes_from_grant_to_the_next_robot() {
    let mut bench = Bench::new();
    assert_eq!(bench.pile.availability(), Availability::Free);

    let grant = bench.grant(1, 7, 3, 1_000.0);
    assert_eq!(bench.send(grant), ack(&grant));
    assert_eq!(bench.pile.availability(), Availability::Reserved);
    bench.wait(5_000);
    assert!(!bench.live());

    bench.standing = Some((tag(3), -45));
    bench.wait(100);
    assert!(bench.live());
    assert_eq!(bench.pile.availability(), Availability::Charging);
    assert_eq!(bench.pile.row().planned, DurationMs(10_000));
    bench.wait(5_000);
    let remaining = bench.pile.row().remaining.get();
    assert!((0.48..=0.52).contains(&remaining), "{remaining} of the charge are left after half of it");

    bench.wait(5_200);
    assert!(!bench.live());
    assert_eq!(bench.pile.availability(), Availability::Done);
    assert_eq!(bench.pile.row().remaining, Fraction::MIN);
    let ended = bench.pile.leases().ended().unwrap();
    assert_eq!((ended.lease, ended.reason), (grant.lease, EndReason::Completed));
    assert!((10_000..=10_100).contains(&ended.charged.0));

    bench.standing = None;
    bench.wait(3_000);
    assert_eq!(bench.pile.availability(), Availability::Free);
    let next = bench.grant(1, 8, 4, 1_000.0);
    assert_eq!(bench.send(next), ack(&next));
}

/// A robot that has been charged for a second of ten.
fn charging() -> Bench {
    let mut bench = Bench::new();
    let grant = bench.grant(1, 7, 3, 1_000.0);
    bench.send(grant);
    bench.standing = Some((tag(3), -45));
    bench.wait(1_000);
    assert!(bench.live());
    bench
}

fn ended(bench: &Bench) -> (EndReason, u32) {
    let ended = bench.pile.leases().ended().unwrap();
    (ended.reason, ended.charged.0)
}

#[test]
fn another_robots_tag_is_not_charged() {
    let mut bench = Bench::new();
    let grant = bench.grant(1, 7, 3, 1_000.0);
    bench.send(grant);
    bench.standing = Some((tag(4), -45));
    bench.wait(1_000);
    assert!(!bench.live());
    assert_eq!(bench.pile.availability(), Availability::Reserved);
}

#[test]
fn a_tag_that_is_far_away_is_not_charged() {
    let mut bench = Bench::new();
    let grant = bench.grant(1, 7, 3, 1_000.0);
    bench.send(grant);
    bench.standing = Some((tag(3), -65));
    bench.wait(1_000);
    assert!(!bench.live());
}

#[test]
fn no_charge_begins_while_a_stranger_stands_at_the_contacts() {
    let mut bench = Bench::new();
    let grant = bench.grant(1, 7, 3, 1_000.0);
    bench.send(grant);
    for _ in 0..30 {
        bench.standing = Some((tag(4), -45));
        bench.wait(100);
        bench.standing = Some((tag(3), -45));
        bench.wait(100);
        assert!(!bench.live());
    }
    bench.wait(2_000);
    assert!(bench.live());
    bench.standing = Some((tag(4), -45));
    bench.wait(100);
    assert!(bench.live(), "a robot that queues does not stop the charge");
}

#[test]
fn a_robot_that_leaves_early_ends_its_lease() {
    let mut bench = charging();
    bench.standing = None;
    bench.wait(200);
    assert!(!bench.live(), "nothing touches the contacts");
    bench.wait(1_700);
    assert!(bench.pile.leases().current().is_some(), "a few lost reads are no departure");
    bench.wait(200);
    assert_eq!(bench.pile.availability(), Availability::Free);
    let (reason, charged) = ended(&bench);
    assert_eq!(reason, EndReason::RobotLeft);
    assert!((900..=1_100).contains(&charged), "charged for {charged} ms");
}

#[test]
fn a_lost_read_neither_stops_nor_restarts_a_charge() {
    let mut bench = charging();
    bench.reader = Reader::Misses;
    bench.wait(1_800);
    assert!(bench.live());
    bench.reader = Reader::Sees;
    bench.standing = Some((tag(3), -62));
    bench.wait(7_300);
    assert_eq!(ended(&bench).0, EndReason::Completed);
}

#[test]
fn contacts_that_lose_touch_for_a_moment_interrupt_a_charge_and_do_not_end_it() {
    let mut bench = charging();
    bench.battery = None;
    bench.plant.battery = None;
    bench.wait(200);
    assert!(!bench.live());
    bench.battery = Some(BATTERY);
    bench.wait(1_500);
    assert!(bench.live());
    bench.wait(9_000);
    assert_eq!(ended(&bench).0, EndReason::Completed);
}

#[test]
fn a_revocation_ends_the_lease_at_once_and_ramps_the_current_down() {
    let mut bench = charging();
    let lease = bench.pile.leases().current().unwrap().name;
    let head = bench.head();
    let outputs = bench.hear(Message::Revoke(Revoke { head, lease }));
    assert_eq!(outputs.messages[0].message, Message::Ack(Ack { of: Reference::Command(head.id) }));
    assert_eq!(ended(&bench).0, EndReason::Revoked);
    bench.wait(200);
    assert!(!bench.live());
    assert_eq!(bench.pile.availability(), Availability::Done, "the robot still stands here");
}

#[test]
fn a_robot_that_needs_nothing_is_done_at_once() {
    let mut bench = Bench::new();
    let grant = bench.grant(1, 7, 3, 0.0);
    bench.send(grant);
    bench.standing = Some((tag(3), -45));
    bench.wait(100);
    assert_eq!(bench.plant.power(), Power::OFF);
    assert_eq!(ended(&bench), (EndReason::Completed, 0));
}

#[test]
fn a_done_pile_is_occupied_for_all_but_the_robot_that_stands_there() {
    let mut bench = charging();
    bench.wait(9_500);
    assert_eq!(bench.pile.availability(), Availability::Done);
    let other = bench.grant(1, 8, 4, 1_000.0);
    assert_eq!(bench.send(other), nack(&other, NackReason::Occupied));
    let same = bench.grant(1, 9, 3, 500.0);
    assert_eq!(bench.send(same), ack(&same));
    bench.wait(1_000);
    assert!(bench.live());
}

#[test]
fn a_clock_that_runs_backwards_stands_still() {
    let mut bench = charging();
    let before = bench.pile.leases().current().unwrap().charge.unwrap();
    bench.now.0 -= 900;
    bench.wait(800);
    assert!(bench.live());
    assert_eq!(bench.pile.leases().current().unwrap().charge, Some(before));
}
