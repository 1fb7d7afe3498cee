//! Many runs, on all processors.

use std::{
    num::NonZero,
    sync::atomic::{AtomicU64, Ordering},
    thread,
};

use super::{
    Ground, Trial,
    outcome::{Outcome, Tally},
};

/// What becomes of the trials of `seeds` seeds from that of `first` on, in the order of the seeds. `tell`
/// hears of each as it ends.
pub fn run(ground: &Ground, first: &Trial, seeds: u64, tell: impl Fn(&Outcome) + Sync) -> Vec<Outcome> {
    let next = AtomicU64::new(0);
    let work = || {
        let mut outcomes = Vec::new();
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= seeds {
                return outcomes;
            }
            let trial = Trial { seed: first.seed.wrapping_add(number), ..first.clone() };
            let outcome = trial.run(ground);
            tell(&outcome);
            outcomes.push((number, outcome));
        }
    };
    let threads = thread::available_parallelism().map_or(1, NonZero::get);
    let mut outcomes: Vec<_> = thread::scope(|scope| {
        let workers: Vec<_> = (1..threads).map(|_| scope.spawn(work)).collect();
        let own = work();
        // A worker that panicked has said so; its runs are missing, and its panic goes on here.
        let others = workers
            .into_iter()
            .map(|worker| worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        others.flatten().chain(own).collect()
    });
    outcomes.sort_by_key(|(number, _)| *number);
    outcomes.into_iter().map(|(_, outcome)| outcome).collect()
}

/// What was counted in all runs.
#[must_use]
pub fn sum(outcomes: &[Outcome]) -> Tally {
    let mut sum = Tally::default();
    outcomes.iter().for_each(|outcome| sum.add(&outcome.tally));
    sum
}
