//! Robots that pass a pile (LMPP eq. 4).

use firmware_common::passes::PassRule;
use firmware_pile::{ChargingPile, Parameters};
use protocol::*;

use crate::bench::{Bench, tag};

#[test]
fn a_parked_robot_passes_once() {
    let mut bench = Bench::new();
    bench.standing = Some((tag(3), -65));
    bench.wait(100_000);
    assert_eq!(bench.passes_of(tag(3)), 1);
}

#[test]
fn the_literal_rule_counts_every_read() {
    let mut bench =
        Bench::with(Parameters { pass_rule: PassRule::PerSample, ..Parameters::new(PileId(1), 100.0) });
    bench.standing = Some((tag(3), -65));
    bench.wait(100_000);
    bench.standing = None;
    bench.wait(60_000);
    assert_eq!(bench.passes_of(tag(3)), 1_000);
}

#[test]
fn passes_of_a_lost_coordinator_are_reported_to_the_next() {
    let mut bench = Bench::new();
    bench.coordinator = false;
    for robot in 0..40 {
        bench.standing = Some((tag(robot), -65));
        bench.wait(4_000);
    }
    bench.coordinator = true;
    bench.sent.clear();
    bench.standing = None;
    bench.wait(8 * 60_000);
    for robot in 0..40 {
        assert_eq!(bench.passes_of(tag(robot)), 1, "robot {robot}");
    }
}

#[test]
fn a_pass_counts_for_the_period_of_the_sites_day() {
    let mut bench = Bench::new();
    let parameters =
        Parameters { period: DurationMs(3_600_000), periods: 24, ..Parameters::new(PileId(1), 100.0) };
    bench.pile = ChargingPile::new(parameters);
    // The site's clock shows a quarter of an hour and a bit past midnight.
    bench.wait(100);
    bench.now.0 += 3 * 3_600_000;
    bench.standing = Some((tag(3), -65));
    bench.wait(3_000);
    let reported = bench.sent.iter().find_map(|message| match message {
        Message::PassReport(report) => Some(report.passes.clone()),
        _ => None,
    });
    assert_eq!(reported.unwrap().as_slice(), [PassCount { tag: tag(3), period: 3, passes: 1 }]);
}
