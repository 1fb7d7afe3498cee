//! How often robots meet obstacles at doors (LMPP eqs. 10 and 11).

use std::collections::{BTreeMap, BTreeSet};

use crate::rooms::DoorId;

/// Counts of people and things that passed each door in each period of the day.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Congestion {
    passes: BTreeMap<u16, BTreeMap<DoorId, u64>>,
}

impl Congestion {
    /// Counts one more at `door` in `period` (eq. 10).
    pub fn count(&mut self, door: DoorId, period: u16) {
        let passes = self.passes.entry(period).or_default().entry(door).or_default();
        *passes = passes.saturating_add(1);
    }

    /// The door's share of all passes in `period`, 0 to 1 (eq. 11); 0 before anything was counted.
    #[must_use]
    pub fn share(&self, door: DoorId, period: u16) -> f64 {
        let Some(passes) = self.passes.get(&period) else { return 0.0 };
        let all: u128 = passes.values().map(|&passes| u128::from(passes)).sum();
        passes.get(&door).map_or(0.0, |&passes| passes as f64 / all.max(1) as f64)
    }
}

/// The doors to avoid: those whose congestion rho exceeds the threshold `theta`. From 1 on,
/// `theta` avoids none.
#[must_use]
pub fn avoided(congestion: impl IntoIterator<Item = (DoorId, f64)>, theta: f64) -> BTreeSet<DoorId> {
    congestion.into_iter().filter(|&(_, rho)| theta < 1.0 && rho > theta).map(|(door, _)| door).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_of_a_period_sum_to_one_and_periods_are_apart() {
        let mut congestion = Congestion::default();
        for (door, period, times) in [(1, 0, 3), (2, 0, 1), (1, 5, 7)] {
            (0..times).for_each(|_| congestion.count(DoorId(door), period));
        }
        assert_eq!(congestion.share(DoorId(1), 0), 0.75);
        assert_eq!(congestion.share(DoorId(2), 0), 0.25);
        assert_eq!(congestion.share(DoorId(1), 5), 1.0);
        assert_eq!(congestion.share(DoorId(1), 9), 0.0);
    }

    #[test]
    fn a_threshold_of_one_or_more_avoids_no_door() {
        let rho = [(DoorId(1), 0.45), (DoorId(2), 0.12), (DoorId(4), 0.77)];
        assert_eq!(avoided(rho, 0.3), BTreeSet::from([DoorId(1), DoorId(4)]));
        assert!(avoided(rho, 1.0).is_empty());
        assert!(avoided([(DoorId(1), 1.0)], 1.5).is_empty());
    }
}
