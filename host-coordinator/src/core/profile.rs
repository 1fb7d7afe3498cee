//! What a robot's tasks take from its battery: learned from every run it tells of (Access eqs. 1, 2).

use protocol::EnergyJ;

/// A robot may be taken to need so many times the spread more than the mean, of a task or of a metre.
pub(super) const SPREADS: f64 = 2.0;
/// The spread of a task of which too few runs are known, as a share of the mean.
const DOUBT: f64 = 0.3;
/// From so many runs on the spread that was seen counts.
const KNOWN: u32 = 5;

/// What one task of one robot takes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TaskProfile {
    /// How many runs were heard of (eq. 2's m).
    pub runs: u32,
    /// What a run takes in the mean, in joules (eq. 2's P_E).
    pub mean_j: f64,
    /// The sum of the squared differences from it.
    squares: f64,
}

impl TaskProfile {
    /// One run more, which took `energy` (eq. 1's P_t).
    pub fn learn(&mut self, energy: EnergyJ) {
        self.runs = self.runs.saturating_add(1);
        let off_j = f64::from(energy.get()) - self.mean_j;
        self.mean_j += off_j / f64::from(self.runs);
        self.squares += off_j * (f64::from(energy.get()) - self.mean_j);
    }

    /// How much runs differ, in joules: one standard deviation.
    #[must_use]
    pub fn spread_j(&self) -> f64 {
        if self.runs < KNOWN { DOUBT * self.mean_j } else { (self.squares / f64::from(self.runs - 1)).sqrt() }
    }

    /// What the next run almost surely takes at most, in joules.
    #[must_use]
    pub fn at_most_j(&self) -> f64 {
        self.mean_j + SPREADS * self.spread_j()
    }
}

#[cfg(test)]
mod tests {
    use proptest::{collection::vec, prelude::*};

    use super::*;

    fn learned(runs: &[f32]) -> TaskProfile {
        let mut profile = TaskProfile::default();
        runs.iter().for_each(|&energy| profile.learn(EnergyJ::clamped(energy)));
        profile
    }

    #[test]
    fn a_task_of_few_runs_may_take_much_more_than_its_mean() {
        let profile = learned(&[100.0, 100.0]);
        assert_eq!((profile.mean_j, profile.at_most_j()), (100.0, 160.0));
        assert_eq!(learned(&[100.0; 5]).at_most_j(), 100.0, "five runs alike");
        assert_eq!(TaskProfile::default().at_most_j(), 0.0);
    }

    proptest! {
        #[test]
        fn mean_and_spread_are_those_of_the_runs(runs in vec(1.0f32..1e6, 5..40)) {
            let profile = learned(&runs);
            let mean = runs.iter().map(|&run| f64::from(run)).sum::<f64>() / runs.len() as f64;
            let squares: f64 = runs.iter().map(|&run| (f64::from(run) - mean).powi(2)).sum();
            let spread = (squares / (runs.len() - 1) as f64).sqrt();
            prop_assert!((profile.mean_j - mean).abs() <= 1e-9 * mean);
            prop_assert!((profile.spread_j() - spread).abs() <= 1e-6 * mean);
        }
    }
}
