//! What a run comes to, and what many of them come to.

use protocol::Millis;
use serde::Serialize;

use super::breach::Breach;

/// A run that was broken off because a promise of the system was broken.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure {
    /// When.
    pub at: Millis,
    /// Which promise.
    pub breach: Breach,
    /// How many faults had struck by then.
    pub struck: u64,
}

/// What a run comes to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Its seed.
    pub seed: u64,
    /// What was counted.
    pub tally: Tally,
    /// Why it was broken off, if it was.
    pub failure: Option<Failure>,
}

/// What adds up over runs, and is told as it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Counts {
    /// Times that a robot began to ask for a charge.
    pub requests: u64,
    /// Leases granted.
    pub granted: u64,
    /// Charges given in full.
    pub completed: u64,
    /// Charges that were cut short for a critical robot.
    pub preempted: u64,
    /// Charges under leases that piles made for themselves while they heard no coordinator.
    pub local_charges: u64,
    /// Broken promises about who holds a pile.
    pub double_grants: u64,
    /// Broken promises about robots that ask.
    pub lost_requests: u64,
    /// Robots that stranded although a pile was within their true reach when they asked.
    pub stranded_reachable: u64,
    /// Other robots that stranded.
    pub stranded_unreachable: u64,
    /// Steps of the coordinator's core.
    pub coordinator_steps: u64,
    /// Robots that mobile chargers gave enough to reach a pile.
    pub rescued: u64,
    /// Robots that people had to tow.
    pub towed: u64,
    /// How far robots drove on their ways to a charge, in metres.
    pub charge_distance_m: f64,
}

/// What is counted in a run, or in many.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// What is told as it is.
    pub counts: Counts,
    /// From first asking until the contacts were live, in milliseconds; at the end of the run the robots
    /// that still wait count with what they have waited so far.
    pub waits_ms: Vec<u32>,
    /// Time that robots worked, in milliseconds.
    pub worked_ms: u64,
    /// Time that there were robots, in milliseconds.
    pub robots_ms: u64,
}

impl Tally {
    /// Adds what was counted elsewhere.
    pub fn add(&mut self, other: &Self) {
        let counts = &mut self.counts;
        counts.requests += other.counts.requests;
        counts.granted += other.counts.granted;
        counts.completed += other.counts.completed;
        counts.preempted += other.counts.preempted;
        counts.local_charges += other.counts.local_charges;
        counts.double_grants += other.counts.double_grants;
        counts.lost_requests += other.counts.lost_requests;
        counts.stranded_reachable += other.counts.stranded_reachable;
        counts.stranded_unreachable += other.counts.stranded_unreachable;
        counts.coordinator_steps += other.counts.coordinator_steps;
        counts.rescued += other.counts.rescued;
        counts.towed += other.counts.towed;
        self.waits_ms.extend_from_slice(&other.waits_ms);
        self.worked_ms += other.worked_ms;
        self.robots_ms += other.robots_ms;
        counts.charge_distance_m += other.counts.charge_distance_m;
    }

    /// The figures under their names; `seed` is that of the run, or the first.
    #[must_use]
    pub fn figures(&self, seed: u64) -> Figures {
        let mut sorted = self.waits_ms.clone();
        sorted.sort_unstable();
        // The nearest rank.
        let quantile = |share: f64| {
            let rank = (share * sorted.len() as f64).ceil() as usize;
            sorted.get(rank.saturating_sub(1)).map_or(0.0, |&wait_ms| f64::from(wait_ms) / 1e3)
        };
        Figures {
            seed,
            counts: self.counts,
            wait_s: Wait { p50: quantile(0.5), p99: quantile(0.99) },
            working_share: self.worked_ms as f64 / self.robots_ms.max(1) as f64,
        }
    }
}

/// The figures of a run, or of many, as programs read them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Figures {
    /// The seed of the run, or of the first.
    pub seed: u64,
    /// What was counted.
    #[serde(flatten)]
    pub counts: Counts,
    /// See [`Tally::waits_ms`].
    pub wait_s: Wait,
    /// The share of their time that robots worked.
    pub working_share: f64,
}

/// What half of the waits, and 99 of 100, are at most, in seconds; 0 without any.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Wait {
    /// The median.
    pub p50: f64,
    /// The 99th percentile.
    pub p99: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_of_all_waits_together_and_shares_of_all_time() {
        let one = Tally {
            waits_ms: (1..=99).map(|s| s * 1_000).collect(),
            worked_ms: 30,
            robots_ms: 100,
            ..Tally::default()
        };
        let other = Tally { waits_ms: vec![500_000], worked_ms: 50, robots_ms: 100, ..Tally::default() };
        let mut sum = one;
        sum.add(&other);
        let figures = sum.figures(7);
        assert_eq!(figures.wait_s, Wait { p50: 50.0, p99: 99.0 });
        assert_eq!(figures.working_share, 0.4);
        assert_eq!(Tally::default().figures(1).wait_s, Wait { p50: 0.0, p99: 0.0 });
    }
}
