//! Ways from where a robot is to the piles (LMPP Algorithm 6), around doors that are too congested
//! (eqs. 10, 11).

use std::collections::BTreeMap;

use planning::{grid::Cell, lmpp::Lmpp, rooms::DoorId};
use protocol::PileId;

use crate::site::Site;

/// The lengths of a robot's ways in cells; a pile that no way leads to is not there.
pub type Lengths = BTreeMap<PileId, f64>;

/// Plans ways, with the memory of the site's paths.
#[derive(Debug)]
pub struct Routes {
    lmpp: Lmpp,
}

impl Routes {
    /// Plans with the memory of `site`, without the doors whose congestion exceeds `theta`.
    #[must_use]
    pub fn new(mut memory: Lmpp, site: &Site, theta: f64) -> Self {
        memory.close(site.doors_to_avoid(theta));
        Self { lmpp: memory }
    }

    /// Whether ways may lead through a door.
    #[must_use]
    pub fn is_open(&self, door: DoorId) -> bool {
        !self.lmpp.closed().contains(&door)
    }

    /// The lengths of the ways from `from` to all piles.
    pub fn lengths(&self, from: Cell) -> Lengths {
        // A robot that is nowhere has no way.
        let Ok(survey) = self.lmpp.survey(from) else { return Lengths::new() };
        survey.lengths().map(|(pile, length)| (PileId(pile), length.units())).collect()
    }

    /// The cells where the way from `from` to a pile turns, both ends included.
    pub fn route(&self, from: Cell, pile: PileId) -> Option<Vec<Cell>> {
        let survey = self.lmpp.survey(from).ok()?;
        Some(survey.route_to(pile.0)?.path.waypoints().to_vec())
    }
}
