//! What becomes of a lease that runs out.

use protocol::*;

use crate::bench::{Bench, ack, tag};

/// A charge of five minutes under a lease of one, ten seconds old.
fn long_charge() -> (Bench, Grant) {
    let mut bench = Bench::new();
    let grant = bench.grant(1, 7, 3, 30_000.0);
    bench.send(grant);
    bench.standing = Some((tag(3), -45));
    bench.wait(10_000);
    assert!(bench.live());
    (bench, grant)
}

fn reason(bench: &Bench) -> Option<EndReason> {
    bench.pile.leases().ended().map(|ended| ended.reason)
}

#[test]
fn before_the_robot_has_come_the_lease_ends_at_its_expiry() {
    let mut bench = Bench::new();
    bench.coordinator = false;
    let grant = bench.grant(1, 7, 3, 1_000.0);
    bench.send(grant);
    bench.wait(59_900);
    assert_eq!(bench.pile.availability(), Availability::Reserved);
    bench.wait(100);
    assert_eq!(bench.pile.availability(), Availability::Free);
    assert_eq!(reason(&bench), Some(EndReason::Expired));
    bench.standing = Some((tag(3), -45));
    bench.wait(1_000);
    assert!(!bench.live());
}

#[test]
fn a_coordinator_that_does_not_extend_ends_the_charge() {
    let (mut bench, _) = long_charge();
    bench.wait(50_000 - 200);
    assert!(bench.live());
    bench.wait(8_000);
    assert!(!bench.live());
    assert_eq!(reason(&bench), Some(EndReason::Expired));
}

#[test]
fn a_coordinator_that_extends_goes_on_charging() {
    let (mut bench, grant) = long_charge();
    for _ in 0..9 {
        bench.wait(30_000);
        let extension =
            Grant { head: bench.head(), expiry: bench.site_now().after(DurationMs(60_000)), ..grant };
        assert_eq!(bench.send(extension), ack(&extension));
        assert!(bench.live());
    }
    bench.wait(21_000);
    assert_eq!(reason(&bench), Some(EndReason::Completed));
}

#[test]
fn without_a_coordinator_the_charge_runs_to_its_end_and_nothing_follows() {
    let (mut bench, _) = long_charge();
    bench.coordinator = false;
    bench.wait(285_000);
    assert!(bench.live());
    bench.wait(10_000);
    assert!(!bench.live());
    assert_eq!(reason(&bench), Some(EndReason::Completed));
    bench.wait(600_000);
    assert!(!bench.live());
}

#[test]
fn a_coordinator_that_comes_back_has_time_to_take_the_lease_over() {
    let (mut bench, grant) = long_charge();
    bench.coordinator = false;
    bench.wait(120_000);
    bench.coordinator = true;
    bench.wait(4_000);
    assert!(bench.live());
    let taken_over = Grant {
        head: bench.head(),
        lease: LeaseRef { epoch: Epoch(2), ..grant.lease },
        expiry: bench.site_now().after(DurationMs(60_000)),
        ..grant
    };
    assert_eq!(bench.send(taken_over), ack(&taken_over));
    bench.wait(50_000);
    assert!(bench.live());
}

#[test]
fn extensions_in_the_wrong_order_do_not_shorten_a_lease() {
    let (mut bench, grant) = long_charge();
    let expiry = |bench: &Bench, seconds: u32| bench.site_now().after(DurationMs(seconds * 1_000));
    let first = Grant { head: bench.head(), expiry: expiry(&bench, 100), ..grant };
    let second = Grant { head: bench.head(), expiry: expiry(&bench, 200), ..grant };
    bench.send(second);
    bench.send(first);
    assert_eq!(bench.pile.leases().current().unwrap().expiry, second.expiry);
}

#[test]
fn a_coordinator_that_is_lost_a_second_time_leaves_the_charge_running_again() {
    let (mut bench, grant) = long_charge();
    bench.wait(51_000);
    assert!(bench.live(), "the grace is not over");
    let extension = Grant { head: bench.head(), expiry: bench.site_now().after(DurationMs(60_000)), ..grant };
    bench.send(extension);
    bench.coordinator = false;
    bench.wait(300_000);
    assert_eq!(reason(&bench), Some(EndReason::Completed));
}
