//! When a charge has to begin at the latest: Access's alert threshold (eq. 3) for a whole fleet.
//!
//! Alone, a robot may work until its battery just takes it to a pile with a reserve. When many robots come to
//! that point together, those that wait for the others' charges must have begun sooner. So the charges are
//! laid onto the piles backwards, from the latest deadline to the earliest, each as late as its own deadline
//! and the charges after it allow. Where that leads to, the robot's charge has to begin: a margin that
//! shrinks as the battery does, and sooner the more others need a pile about the same time.

/// A charge that has to be given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Need {
    /// When the charge has to begin for the robot's own sake, in seconds from now.
    pub deadline_s: f64,
    /// How long it takes, until the next robot can be charged, in seconds.
    pub charge_s: f64,
}

/// When each charge has to begin at the latest, in seconds from now, so that `piles` piles can give them all:
/// never after its deadline. Less than 0 where that is impossible, and infinitely long ago without a pile.
#[must_use]
pub fn latest_starts(needs: &[Need], piles: usize) -> Vec<f64> {
    let mut order: Vec<_> = (0..needs.len()).collect();
    order.sort_by(|&one, &other| needs[other].deadline_s.total_cmp(&needs[one].deadline_s));
    // From when on each pile is taken by the charges laid so far.
    let mut taken_s = vec![f64::INFINITY; piles];
    let mut starts = vec![f64::NEG_INFINITY; needs.len()];
    for place in order {
        let Need { deadline_s, charge_s } = needs[place];
        let Some(latest_s) = taken_s.iter_mut().max_by(|one, other| one.total_cmp(other)) else { break };
        *latest_s = deadline_s.min(*latest_s - charge_s);
        starts[place] = *latest_s;
    }
    starts
}

#[cfg(test)]
mod tests {
    use proptest::{collection::vec, prelude::*};

    use super::*;

    fn needs(deadlines_s: &[f64]) -> Vec<Need> {
        deadlines_s.iter().map(|&deadline_s| Need { deadline_s, charge_s: 200.0 }).collect()
    }

    #[test]
    fn a_robot_alone_works_until_its_own_deadline() {
        assert_eq!(latest_starts(&needs(&[900.0]), 1), [900.0]);
        assert_eq!(latest_starts(&needs(&[900.0, 900.0]), 2), [900.0, 900.0]);
        assert_eq!(latest_starts(&needs(&[900.0, 100.0]), 1), [900.0, 100.0]);
    }

    #[test]
    fn robots_that_need_one_pile_at_a_time_are_called_one_after_the_other() {
        let starts = latest_starts(&needs(&[900.0, 1_000.0, 850.0]), 1);
        assert_eq!(starts, [600.0 + 200.0, 1_000.0, 600.0]);
    }

    #[test]
    fn without_a_pile_it_is_too_late() {
        assert_eq!(latest_starts(&needs(&[900.0]), 0), [f64::NEG_INFINITY]);
    }

    proptest! {
        #[test]
        fn charges_that_begin_then_never_overlap_on_more_piles_than_there_are(
            needs in vec((-500.0..2_000.0, 1.0..300.0), 0..30), piles in 1usize..6,
        ) {
            let needs: Vec<_> =
                needs.into_iter().map(|(deadline_s, charge_s)| Need { deadline_s, charge_s }).collect();
            let starts = latest_starts(&needs, piles);
            for (need, &start) in needs.iter().zip(&starts) {
                prop_assert!(start <= need.deadline_s);
                // Sums are rounded.
                let runs = |(other, begun): &(&Need, &f64)| {
                    **begun <= start && start < **begun + other.charge_s - 1e-6
                };
                let running = needs.iter().zip(&starts).filter(runs);
                prop_assert!(running.count() <= piles);
            }
        }
    }
}
