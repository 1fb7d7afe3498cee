//! A robot's own choice while no coordinator is heard: LMPP's rule (eq. 9) on the table that piles gossip
//! (LMPP Figs. 1 to 3).
//!
//! For a robot's own computer: it needs nothing but what that hears and plans. Only free piles count, because
//! nobody there can promise an occupied one. How near the robot's later work is to a pile is the coordinator's
//! to know, so equal scores go to the nearer pile.

use protocol::{Availability, PileId, PileRow};

use super::multistage::{Candidate, Rule, choose};

/// A pile as a robot knows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known {
    /// The newest row that was heard of it, and not too long ago.
    pub row: PileRow,
    /// The length of the robot's way to it in cells; none if there is no way.
    pub distance: Option<f64>,
}

/// The pile to claim for a robot that gets `reach` cells far, if there is one.
#[must_use]
pub fn choose_alone(piles: &[Known], reach: f64) -> Option<PileId> {
    let free = piles.iter().filter(|known| known.row.availability == Availability::Free);
    let candidates: Vec<_> = free
        .map(|known| Candidate {
            pile: known.row.pile,
            availability: Some(Availability::Free),
            remaining: 0.0,
            distance: known.distance,
            probability: 0.0,
        })
        .collect();
    // No pile is occupied, so the threshold says nothing.
    choose(&candidates, reach, 1.0, Rule::Corrected).chosen
}

#[cfg(test)]
mod tests {
    use protocol::{BootEpoch, DurationMs, Fraction};

    use super::*;

    fn known(pile: u16, availability: Availability, distance: Option<f64>) -> Known {
        let row = PileRow {
            pile: PileId(pile),
            boot: BootEpoch(1),
            version: 1,
            stamp: None,
            availability,
            remaining: Fraction::MIN,
            planned: DurationMs(0),
        };
        Known { row, distance }
    }

    #[test]
    fn the_nearest_free_pile_in_reach_is_claimed_whether_all_are_in_reach_or_some() {
        let piles = [
            known(1, Availability::Charging, Some(1.0)),
            known(2, Availability::Done, Some(2.0)),
            known(3, Availability::Free, None),
            known(4, Availability::Free, Some(30.0)),
            known(5, Availability::Free, Some(20.0)),
        ];
        assert_eq!(choose_alone(&piles, 100.0), Some(PileId(5)));
        assert_eq!(choose_alone(&piles, 25.0), Some(PileId(5)));
        assert_eq!(choose_alone(&piles, 19.0), None);
        assert_eq!(choose_alone(&piles[..3], 100.0), None);
        assert_eq!(choose_alone(&[], 100.0), None);
    }
}
