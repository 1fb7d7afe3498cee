//! What a robot knows of the site: its map, where the piles are (LMPP Table 1), where to work.

use std::sync::Arc;

use planning::{
    grid::Cell,
    search::{AStar, Dijkstra, Planner, Workspace},
};
use protocol::DurationMs;

use super::{
    ground::{KEEP_CLEAR_M, Point, Route},
    random::Random,
};
use crate::site::Site;

/// How long a robot works at a place, in seconds: from, to.
const AT_WORK_S: (f64, f64) = (5.0, 30.0);

/// Finds a robot's ways.
#[derive(Debug)]
pub struct Navigator {
    site: Arc<Site>,
    places: Arc<[Cell]>,
    piles: Arc<[Point]>,
    random: Random,
    workspace: Workspace,
}

impl Navigator {
    /// A navigator on `site` that works at one of `places` after the other, by chance.
    #[must_use]
    pub fn new(site: Arc<Site>, places: Arc<[Cell]>, random: Random) -> Self {
        let piles = site.piles.iter().map(|pile| site.position(pile.cell).into()).collect();
        Self { site, places, piles, random, workspace: Workspace::default() }
    }

    /// A place to work at.
    pub fn place(&mut self) -> Option<Point> {
        let place = *self.random.choose(&self.places)?;
        Some(self.site.position(place).into())
    }

    /// A shortest way to a place to work at.
    pub fn route_to_work(&mut self, from: Point) -> Option<Route> {
        let place = self.place()?;
        self.route(from, place)
    }

    /// How long to work at the next place.
    pub fn time_at_work(&mut self) -> DurationMs {
        DurationMs::from_seconds(self.random.between(AT_WORK_S.0, AT_WORK_S.1) as f32)
    }

    /// A shortest way between two points; `None` if there is none.
    pub fn route(&mut self, from: Point, to: Point) -> Option<Route> {
        let start = self.site.cell_of(from.into())?;
        let goal = self.site.cell_of(to.into())?;
        let search = AStar::new(&self.site.grid, self.site.moves);
        let found = search.plan(start, goal, &mut self.workspace).ok()?;
        Some(found.path.waypoints().iter().map(|&cell| self.site.position(cell).into()).collect())
    }

    /// Whether a pile is within `distance_m` of `position`.
    #[must_use]
    pub fn near_a_pile(&self, position: Point, distance_m: f64) -> bool {
        self.piles.iter().any(|pile| pile.distance_m(position) < distance_m)
    }
}

/// Where robots may work on `site`: on every free cell that is not close to a pile and can be
/// reached from its first one.
#[must_use]
pub fn places_of_work(site: &Site) -> Vec<Cell> {
    let piles: Vec<Point> = site.piles.iter().map(|pile| site.position(pile.cell).into()).collect();
    let mut workspace = Workspace::default();
    let Some(Ok(ways)) = site
        .piles
        .first()
        .map(|pile| Dijkstra::new(&site.grid, site.moves).ways(pile.cell, &[], &mut workspace))
    else {
        return Vec::new();
    };
    let clear = |cell: &Cell| {
        let point = Point::from(site.position(*cell));
        piles.iter().all(|pile| pile.distance_m(point) >= KEEP_CLEAR_M)
    };
    site.grid.free_cells().filter(clear).filter(|&cell| ways.length_to(cell).is_some()).collect()
}
