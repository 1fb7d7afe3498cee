//! Two policies on the same seeds: how much one is better than the other, and how sure that is.
//!
//! The runs of a seed have the same robots, tasks and faults by chance under both policies, so the
//! difference is taken seed by seed: what makes a run hard makes it hard for both.

use serde::Serialize;

use super::outcome::{Figures, Outcome};

/// The two-sided 95 % quantile of the normal distribution.
const Z: f64 = 1.959_963_985;

/// A figure that is compared.
#[derive(Clone, Copy, Debug)]
pub struct Figure {
    /// Its name, with its unit.
    pub name: &'static str,
    of: fn(&Figures) -> f64,
}

/// What is compared.
pub const FIGURES: [Figure; 7] = [
    Figure { name: "working_share", of: |figures| figures.working_share },
    Figure { name: "wait_p50_s", of: |figures| figures.wait_s.p50 },
    Figure { name: "wait_p99_s", of: |figures| figures.wait_s.p99 },
    Figure { name: "charge_distance_m", of: |figures| figures.counts.charge_distance_m },
    Figure { name: "completed", of: |figures| figures.counts.completed as f64 },
    Figure { name: "preempted", of: |figures| figures.counts.preempted as f64 },
    Figure {
        name: "stranded",
        of: |figures| (figures.counts.stranded_reachable + figures.counts.stranded_unreachable) as f64,
    },
];

/// A figure under both policies, as means over the seeds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Its name, with its unit.
    pub figure: &'static str,
    /// Under the first policy.
    pub first: f64,
    /// Under the second.
    pub second: f64,
    /// The second less the first.
    pub difference: f64,
    /// The true difference is between this and `high` with a probability of 95 %.
    pub low: f64,
    /// See `low`.
    pub high: f64,
}

/// Compares the outcomes of the same seeds under two policies.
#[must_use]
pub fn rows(first: &[Outcome], second: &[Outcome]) -> Vec<Row> {
    let figures = |outcomes: &[Outcome]| -> Vec<Figures> {
        outcomes.iter().map(|outcome| outcome.tally.figures(outcome.seed)).collect()
    };
    let (first, second) = (figures(first), figures(second));
    let row = |Figure { name, of }| {
        let differences: Vec<f64> =
            first.iter().zip(&second).map(|(one, other)| of(other) - of(one)).collect();
        let (difference, half) = (mean(&differences), half_width(&differences));
        Row {
            figure: name,
            first: mean(&first.iter().map(of).collect::<Vec<_>>()),
            second: mean(&second.iter().map(of).collect::<Vec<_>>()),
            difference,
            low: difference - half,
            high: difference + half,
        }
    };
    FIGURES.into_iter().map(row).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Half of the 95 % confidence interval of the mean, by Student's distribution (its quantile by the
/// expansion of Cornish and Fisher, a thousandth off from ten values on); infinite for less than two values.
fn half_width(values: &[f64]) -> f64 {
    let Some(freedom) = values.len().checked_sub(1).filter(|freedom| *freedom > 0) else {
        return f64::INFINITY;
    };
    let (freedom, mean) = (freedom as f64, mean(values));
    let variance = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / freedom;
    let (cube, fifth) = (Z * Z * Z, Z * Z * Z * Z * Z);
    let quantile =
        Z + (cube + Z) / (4.0 * freedom) + (5.0 * fifth + 16.0 * cube + 3.0 * Z) / (96.0 * freedom * freedom);
    quantile * (variance / values.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::{super::outcome::Tally, *};

    fn outcomes(worked_ms: impl IntoIterator<Item = u64>) -> Vec<Outcome> {
        let tally = |worked_ms| Tally { worked_ms, robots_ms: 100, ..Tally::default() };
        worked_ms
            .into_iter()
            .map(|worked_ms| Outcome { tally: tally(worked_ms), ..Outcome::default() })
            .collect()
    }

    #[test]
    fn the_interval_is_students_around_the_mean_of_the_differences() {
        // Differences of 1 to 10: mean 5.5, deviation 3.0277, t(9) = 2.2622.
        let rows = rows(&outcomes((1..=10).map(|_| 50)), &outcomes((1..=10).map(|more| 50 + more)));
        let Row { figure, first, second, difference, low, high } = rows[0];
        assert_eq!((figure, first), ("working_share", 0.5));
        assert!((second - 0.555).abs() < 1e-12 && (difference - 0.055).abs() < 1e-12);
        let half = 2.2622 * 0.030_277 / 10.0_f64.sqrt();
        assert!((high - low - 2.0 * half).abs() < 2e-4, "{low} {high}");
    }

    #[test]
    fn one_seed_proves_nothing() {
        let rows = rows(&outcomes([50]), &outcomes([60]));
        assert!(rows[0].low.is_infinite() && rows[0].high.is_infinite());
    }
}
