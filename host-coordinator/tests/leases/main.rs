//! The coordinator's core among real pile cores, on networks of all kinds.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod bad_line;
mod board;
mod box_site;
/// The store's own tests have the flash.
#[path = "../../../firmware-pile/tests/store/flash.rs"]
#[allow(dead_code)]
mod flash;
mod random;
mod robot;
mod secrets;
mod steps;
mod torture;

use bad_line::Trouble as Line;
use box_site::{BoxSite, Trouble};

const MINUTE: u64 = 60_000;

#[test]
fn on_a_good_network_every_robot_is_charged() {
    let mut site = BoxSite::new(1, 8, 13);
    site.run(30 * MINUTE);
    let totals = site.coordinator.state().totals;
    assert!(totals.charges_completed >= 20, "{totals:?}");
    assert!(totals.charges_completed + 8 >= totals.requests, "{totals:?}");
}

#[test]
fn a_few_piles_serve_many_robots_in_turn() {
    let mut site = BoxSite::new(2, 10, 3);
    site.run(40 * MINUTE);
    let totals = site.coordinator.state().totals;
    assert!(totals.charges_completed >= 20, "{totals:?}");
}

#[test]
fn whatever_is_lost_repeated_late_or_crashes_there_are_never_two_holders() {
    for seed in 0..12 {
        let mut site = BoxSite::new(seed, 8, 5);
        site.trouble = Trouble {
            line: Line {
                lost: 20 * (seed % 4) * 5,
                repeated: 150,
                delay_ms: [50, 500, 2_000, 5_000][seed as usize % 4],
                ..Line::default()
            },
            crash: seed % 3,
            pile_restart: seed % 2,
            abandon: 1,
        };
        site.run(15 * MINUTE);
        // When the trouble is over, the site gets well.
        site.trouble = Trouble { line: Line { delay_ms: 50, ..Line::default() }, ..Trouble::default() };
        site.run(3 * MINUTE);
        assert!(site.every_asker_is_in_the_book(), "seed {seed}");
        let before = site.coordinator.state().totals;
        site.run(10 * MINUTE);
        let after = site.coordinator.state().totals;
        assert!(after.charges_completed > before.charges_completed, "seed {seed}: {before:?} {after:?}");
        site.crash();
    }
}

#[test]
fn all_piles_together_are_never_given_more_power_than_the_facility_has() {
    for seed in 0..4 {
        let mut site = BoxSite::with_power_cap(seed, 8, 5, Some(1_300.0));
        site.trouble = Trouble {
            line: Line { lost: 100, repeated: 100, delay_ms: 500, ..Line::default() },
            crash: 1,
            ..Trouble::default()
        };
        let mut most = 0;
        for _ in 0..20 * 60 {
            site.run(1_000);
            let held = site.piles.values().filter(|board| board.core.leases().current().is_some()).count();
            most = most.max(held);
        }
        // Of 500 W each.
        assert_eq!(most, 2, "seed {seed}: leases that were held at a time");
        assert!(site.coordinator.state().totals.charges_completed > 5, "seed {seed}");
    }
}
