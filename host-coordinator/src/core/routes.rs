//! Ways from where a robot is to the piles (LMPP Algorithm 6), around doors that are too congested
//! (eqs. 10, 11).

use std::collections::BTreeMap;

use planning::{grid::Cell, lmpp::Lmpp, rooms::DoorId};
use protocol::{PileId, Position, limits};

use crate::site::Site;

/// A robot's ways; a pile that no way leads to is not there.
pub type Ways = BTreeMap<PileId, Way>;

/// A way to a pile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Way {
    /// Its length in cells.
    pub length: f64,
    /// The congestion of all doors on it together (LMPP's rho, eq. 11).
    pub congestion: f64,
}

/// A part of a way, as many points as fit into a message.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// How many points the whole way has.
    pub total: u16,
    /// Which of them is the first here.
    pub first: u16,
    /// The points.
    pub waypoints: heapless::Vec<Position, { limits::WAYPOINTS_PER_PART }>,
}

/// The parts in which a way is told.
pub fn parts(waypoints: &[Position]) -> impl Iterator<Item = Part> + '_ {
    let number = |place: usize| u16::try_from(place).unwrap_or(u16::MAX);
    let total = number(waypoints.len());
    waypoints.chunks(limits::WAYPOINTS_PER_PART).enumerate().map(move |(part, waypoints)| Part {
        total,
        first: number(part * limits::WAYPOINTS_PER_PART),
        waypoints: waypoints.iter().copied().collect(),
    })
}

/// Plans ways, with the memory of the site's paths.
#[derive(Debug)]
pub struct Routes {
    lmpp: Lmpp,
    congestion: BTreeMap<DoorId, f64>,
    /// The lengths of the ways from every pile to every pile, in cells.
    between: BTreeMap<PileId, BTreeMap<PileId, f64>>,
}

impl Routes {
    /// Plans with the memory of `site`, without the doors whose congestion exceeds `theta`.
    #[must_use]
    pub fn new(mut memory: Lmpp, site: &Site, theta: f64) -> Self {
        memory.close(site.doors_to_avoid(theta));
        let congestion = site.congestion.iter().copied().collect();
        let mut this = Self { lmpp: memory, congestion, between: BTreeMap::new() };
        for pile in &site.piles {
            let lengths = this.ways(pile.cell).into_iter().map(|(to, way)| (to, way.length));
            this.between.insert(pile.id, lengths.collect());
        }
        this
    }

    /// Whether ways may lead through a door.
    #[must_use]
    pub fn is_open(&self, door: DoorId) -> bool {
        !self.lmpp.closed().contains(&door)
    }

    /// The ways from `from` to all piles.
    #[must_use]
    pub fn ways(&self, from: Cell) -> Ways {
        // A robot that is nowhere has no way.
        let Ok(survey) = self.lmpp.survey(from) else { return Ways::new() };
        let congestion = |door: &DoorId| self.congestion.get(door).copied().unwrap_or(0.0);
        let ways = survey.lengths().map(|(pile, length)| {
            let congestion = survey.doors_to(pile).iter().map(congestion).sum();
            (PileId(pile), Way { length: length.units(), congestion })
        });
        ways.collect()
    }

    /// How far it is from a pile to where a robot is wanted, in cells: the mean over the piles near which it
    /// is wanted, weighted by how often. None if it is wanted nowhere that a way leads to.
    #[must_use]
    pub fn expected_from(
        &self,
        pile: PileId,
        wanted: impl IntoIterator<Item = (PileId, f64)>,
    ) -> Option<f64> {
        let from = self.between.get(&pile)?;
        let ways = wanted.into_iter().filter_map(|(to, weight)| Some((*from.get(&to)?, weight)));
        let (length, weight) =
            ways.fold((0.0, 0.0), |(length, all), (way, weight)| (length + way * weight, all + weight));
        (weight > 0.0).then(|| length / weight)
    }

    /// Whether a way leads from one pile to another.
    #[must_use]
    pub fn joins(&self, from: PileId, to: PileId) -> bool {
        self.between.get(&from).is_some_and(|ways| ways.contains_key(&to))
    }

    /// How far it is from a pile to the pile farthest away, in cells: how far a robot that works anywhere may
    /// have to drive to be charged. 0 if a way leads to no other.
    #[must_use]
    pub fn farthest_from(&self, pile: PileId) -> f64 {
        self.between.get(&pile).map_or(0.0, |ways| ways.values().copied().fold(0.0, f64::max))
    }

    /// The cells where the way from `from` to a pile turns, both ends included.
    pub fn route(&self, from: Cell, pile: PileId) -> Option<Vec<Cell>> {
        let survey = self.lmpp.survey(from).ok()?;
        Some(survey.route_to(pile.0)?.path.waypoints().to_vec())
    }
}
