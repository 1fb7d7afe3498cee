//! The convergence factor a: how far wolves still roam.

/// How the convergence factor falls from 2 to 0 over the iterations.
///
/// IGWO compares four (eqs. 10 to 13), which are missing from the text at hand. Rebuilt: the linear
/// one of the traditional optimiser and three that are not, by powers, which are the same on every
/// machine. That a4 falls soonest is chosen because IGWO finds it needs the fewest iterations. t is the iteration, T how many there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Convergence {
    /// a1 = 2 (1 - t/T), as in the traditional optimiser.
    Linear,
    /// a2 = 2 (1 - (t/T)^2): roams long.
    Late,
    /// a3 = 2 (1 - t/T)^2: closes in soon.
    Early,
    /// a4 = 2 (1 - t/T)^3: closes in soonest.
    Earliest,
}

impl Convergence {
    /// a1 to a4.
    pub const ALL: [Self; 4] = [Self::Linear, Self::Late, Self::Early, Self::Earliest];

    /// The factor where `progress` = t/T, from 0 to 1, of the iterations are done: from 2 to 0.
    #[must_use]
    pub fn factor(self, progress: f64) -> f64 {
        let left = 1.0 - progress;
        match self {
            Self::Linear => 2.0 * left,
            Self::Late => 2.0 * (1.0 - progress * progress),
            Self::Early => 2.0 * left * left,
            Self::Earliest => 2.0 * left * left * left,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_factor_falls_from_2_to_0() {
        for convergence in Convergence::ALL {
            let factors: Vec<_> = (0..=100).map(|t| convergence.factor(f64::from(t) / 100.0)).collect();
            assert_eq!((factors[0], factors[100]), (2.0, 0.0), "{convergence:?}");
            assert!(factors.is_sorted_by(|before, after| before > after), "{convergence:?}");
        }
    }

    #[test]
    fn no_two_factors_are_the_same() {
        let mut halfway = Convergence::ALL.map(|convergence| convergence.factor(0.5));
        halfway.sort_by(f64::total_cmp);
        assert_eq!(halfway, [0.25, 0.5, 1.0, 1.5]);
    }
}
