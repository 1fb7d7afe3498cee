//! Whole charges, as a coordinator and a robot see them.

use crate::bench::{Bench, ack, tag};
use protocol::*;

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

    bench.wait(5_000);
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
