//! Whole runs.

use protocol::DurationMs;

use super::*;
use crate::config::Policy;

const MINUTE: u32 = 60_000;

fn ground(robots: u16, piles: usize) -> Ground {
    let mut site = Site::fig7().unwrap();
    site.piles.truncate(piles);
    Ground::new(&Arc::new(site), Policy::default(), robots)
}

fn trial(seed: u64, robots: u16, minutes: u32, faults: Faults) -> Trial {
    Trial { seed, robots, duration: DurationMs(minutes * MINUTE), faults, only: 0..u64::MAX }
}

#[test]
fn a_seed_gives_the_same_run_every_time_and_another_seed_another() {
    let ground = ground(20, 5);
    let run = |seed| trial(seed, 20, 8, Faults::ALL).run(&ground);
    let (one, again, other) = (run(1), run(1), run(2));
    assert_eq!(one, again);
    assert_ne!(one.tally, other.tally);
}

#[test]
fn without_faults_everybody_who_asks_is_charged_and_nobody_strands() {
    let outcome = trial(3, 20, 40, Faults::NONE).run(&ground(20, 13));
    let tally = &outcome.tally;
    assert_eq!(outcome.failure, None);
    assert!(tally.counts.requests > 15 && tally.counts.completed > 12, "{tally:?}");
    assert_eq!((tally.counts.stranded_reachable, tally.counts.stranded_unreachable), (0, 0));
    assert!(tally.waits_ms.iter().all(|wait_ms| *wait_ms < 300_000), "{:?}", tally.waits_ms);
}

#[test]
fn no_promise_is_broken_whatever_goes_wrong() {
    let ground = ground(20, 6);
    for seed in 0..6 {
        let outcome = trial(seed, 20, 10, Faults::ALL).run(&ground);
        assert_eq!(outcome.failure, None, "seed {seed}");
        assert!(outcome.tally.counts.granted > 0, "seed {seed}: {:?}", outcome.tally);
    }
}

#[test]
fn faults_that_are_not_to_happen_do_not() {
    let ground = ground(20, 6);
    let clean = trial(4, 20, 8, Faults::NONE).run(&ground);
    let none = Trial { only: 0..0, ..trial(4, 20, 8, Faults::ALL) }.run(&ground);
    assert_eq!(none.tally, clean.tally);
    assert_ne!(trial(4, 20, 8, Faults::ALL).run(&ground).tally, clean.tally);
}

#[test]
fn many_runs_on_all_processors_are_the_same_as_one_after_the_other() {
    let ground = ground(10, 4);
    let first = trial(7, 10, 5, Faults::ALL);
    let together = campaign::run(&ground, &first, 5, |_| {});
    let apart: Vec<_> = (7..12).map(|seed| Trial { seed, ..first.clone() }.run(&ground)).collect();
    assert_eq!(together, apart);
}
