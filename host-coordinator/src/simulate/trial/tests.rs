//! Whole runs.

use protocol::{DurationMs, Millis};

use super::{faults::Fault, *};
use crate::{
    config::Policy,
    core::{
        Event,
        replay::{Anew, Replay},
    },
    selection::PolicyName,
};

const MINUTE: u32 = 60_000;

fn ground(robots: u16, piles: usize) -> Ground {
    ground_with(robots, piles, Policy::default())
}

fn ground_with(robots: u16, piles: usize, policy: Policy) -> Ground {
    let mut site = Site::fig7().unwrap();
    site.piles.truncate(piles);
    Ground::new(&Arc::new(site), policy, robots, 1)
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
    for power_cap_w in [None, Some(1_100.0)] {
        let ground = ground_with(20, 6, Policy { power_cap_w, ..Policy::default() });
        for seed in 0..6 {
            let outcome = trial(seed, 20, 10, Faults::ALL).run(&ground);
            assert_eq!(outcome.failure, None, "seed {seed}");
            assert!(outcome.tally.counts.granted > 0, "seed {seed}: {:?}", outcome.tally);
        }
    }
}

#[test]
fn while_the_coordinator_is_away_robots_claim_piles_and_all_promises_hold() {
    let ground = ground(20, 6);
    let mut local_charges = 0;
    for seed in 0..4 {
        let outcome = trial(seed, 20, 30, Faults::ALL.with(Fault::Outage)).run(&ground);
        assert_eq!(outcome.failure, None, "seed {seed}");
        local_charges += outcome.tally.counts.local_charges;
    }
    assert!(local_charges > 0, "nobody has claimed a pile");
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

/// What the coordinator of a run recorded.
fn log(ground: &Ground, trial: &Trial) -> Vec<Event> {
    let mut run = run::Run::new(ground, trial);
    run.run_until(Millis(trial.duration.0.into()));
    run.office.log
}

/// The decisions of a log, taken anew.
fn anew(events: &[Event], robots: u16, piles: usize, policy: Policy) -> Vec<Anew> {
    let mut replay = Replay::new(ground_with(robots, piles, policy).coordinator);
    let mut anew: Vec<_> = events.iter().flat_map(|event| replay.follow(event)).collect();
    anew.extend(replay.finish());
    anew
}

#[test]
fn a_decision_taken_anew_from_the_log_is_the_one_that_was_taken() {
    for choose in PolicyName::ALL {
        let policy = Policy { choose, ..Policy::default() };
        let events = log(&ground_with(30, 5, policy), &trial(11, 30, 25, Faults::ALL));
        let anew = anew(&events, 30, 5, policy);
        let chosen = |anew: &Anew| anew.would_be.as_ref().map(|would_be| would_be.chosen);
        let same = anew.iter().filter(|anew| chosen(anew) == Some(anew.was.chosen)).count();
        // Of robots that wait beside others the log tells only what was known when they were decided, and not that a
        // pile is free for a robot that stands there without a lease and for nobody else.
        assert!(anew.len() > 30 && same * 100 >= anew.len() * 93, "{choose}: {same} of {}", anew.len());
    }
}

#[test]
fn a_log_taken_anew_with_doors_closed_knows_the_longer_ways() {
    let policy = Policy::default();
    let events = log(&ground(30, 5), &trial(11, 30, 25, Faults::NONE));
    let anew = anew(&events, 30, 5, Policy { theta: 0.1, ..policy });
    let rows = anew.iter().flat_map(|anew| {
        let would_be = anew.would_be.as_ref().unwrap();
        anew.was.explanations.iter().zip(&would_be.explanations)
    });
    let ways: Vec<_> = rows.map(|(was, would_be)| (was.distance, would_be.distance)).collect();
    assert!(ways.iter().all(|(was, would_be)| match (was, would_be) {
        (Some(was), Some(would_be)) => would_be >= was,
        (_, would_be) => would_be.is_none(),
    }));
    let longer = ways.iter().filter(|(was, would_be)| was != would_be).count();
    assert!(longer > 0 && longer < ways.len(), "{longer} of {}", ways.len());
}

/// So many robots for so few piles that some strand.
fn overload(chargers: u16) -> Ground {
    let mut site = Site::fig7().unwrap();
    site.piles.truncate(2);
    Ground::new(&Arc::new(site), Policy::default(), 24, chargers)
}

#[test]
fn robots_that_strand_are_rescued_by_mobile_chargers_else_towed_and_none_is_forgotten() {
    let faults = Faults::ALL.without(Fault::Clock);
    for (chargers, seed) in [(0, 1), (1, 2), (2, 8)] {
        let outcome = trial(seed, 24, 90, faults).run(&overload(chargers));
        let counts = outcome.tally.counts;
        assert_eq!(outcome.failure, None, "{chargers} chargers");
        assert!(counts.stranded_reachable + counts.stranded_unreachable > 0, "{counts:?}");
        assert!(if chargers == 0 { counts.towed > 0 } else { counts.rescued > 0 }, "{counts:?}");
        assert!(chargers > 0 || counts.rescued == 0, "{counts:?}");
    }
}

#[test]
fn a_robot_that_strands_and_is_not_in_the_book_is_found() {
    let ground = overload(0);
    let trial = trial(1, 24, 90, Faults::NONE);
    let mut run = run::Run::new(&ground, &trial);
    let stranded = |run: &run::Run<'_>| run.office.coordinator.state().stranded.first().copied();
    while stranded(&run).is_none() {
        let until = run.now.after(DurationMs(MINUTE));
        run.run_until(until);
        run.now = until;
        assert!(run.now.0 < u64::from(90 * MINUTE), "nobody strands");
    }
    let robot = stranded(&run).unwrap();
    run.office.coordinator = ground.coordinator.restarted([]);
    let index = run.robot_index(robot).unwrap();
    for _ in 0..70 {
        run.now = run.now.after(DurationMs(1_000));
        run.check_helped(index);
    }
    assert_eq!(run.breach, Some(breach::Breach::Forgotten { robot }));
}
