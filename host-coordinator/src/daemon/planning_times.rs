//! How long decisions take.

use std::time::Duration;

/// The newest times that are kept.
const KEPT: usize = 65_536;

/// Real times of the steps that decided, for a report.
#[derive(Clone, Debug, Default)]
pub struct PlanningTimes {
    micros: Vec<u32>,
    next: usize,
}

impl PlanningTimes {
    /// Notes a time.
    pub fn add(&mut self, time: Duration) {
        let micros = u32::try_from(time.as_micros()).unwrap_or(u32::MAX);
        match self.micros.get_mut(self.next) {
            Some(oldest) => *oldest = micros,
            None => self.micros.push(micros),
        }
        self.next = (self.next + 1) % KEPT;
    }

    /// The time in microseconds that a `share` of the steps did not exceed, such as 0.5 for the
    /// median; 0 before the first.
    #[must_use]
    pub fn quantile(&self, share: f64) -> u32 {
        let mut sorted = self.micros.clone();
        sorted.sort_unstable();
        let rank = (share.clamp(0.0, 1.0) * sorted.len() as f64).ceil() as usize;
        sorted.get(rank.saturating_sub(1)).copied().unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_by_nearest_rank() {
        let mut times = PlanningTimes::default();
        assert_eq!(times.quantile(0.5), 0);
        (1..=100).rev().for_each(|micros| times.add(Duration::from_micros(micros)));
        assert_eq!((times.quantile(0.5), times.quantile(0.99), times.quantile(1.0)), (50, 99, 100));
    }

    #[test]
    fn only_the_newest_times_count() {
        let mut times = PlanningTimes::default();
        (0..KEPT).for_each(|_| times.add(Duration::from_secs(1)));
        (0..KEPT).for_each(|_| times.add(Duration::from_micros(5)));
        assert_eq!(times.quantile(1.0), 5);
    }
}
