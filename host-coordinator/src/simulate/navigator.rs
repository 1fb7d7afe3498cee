//! What a robot's own computer knows of the site: its map, where the piles are (LMPP Table 1), and
//! where its next task takes it.

use std::{collections::BTreeMap, sync::Arc};

use planning::{
    path::Path,
    search::{AStar, Planner, Workspace},
};
use protocol::{DurationMs, PileId};

use super::{
    ground::{Point, Route},
    random::Random,
    tasks::Task,
    terrain::Terrain,
};

/// Finds a robot's ways and tasks.
#[derive(Debug)]
pub struct Navigator {
    terrain: Arc<Terrain>,
    random: Random,
    path: Path,
    workspace: Workspace,
}

impl Navigator {
    /// A navigator on `terrain` that has one task after the other, by chance.
    #[must_use]
    pub fn new(terrain: Arc<Terrain>, random: Random) -> Self {
        Self { terrain, random, path: Path::default(), workspace: Workspace::default() }
    }

    /// A place to work at; `None` if the site has none.
    pub fn place(&mut self) -> Option<Point> {
        self.random.choose(self.terrain.places()).copied()
    }

    /// The next task.
    pub fn task(&mut self) -> Task {
        Task::draw(&mut self.random)
    }

    /// A shortest way to a place to work at.
    pub fn route_to_work(&mut self, from: Point) -> Option<Route> {
        let places = self.terrain.places().len();
        let place = self.random.between(0.0, places as f64) as usize;
        self.terrain.route_to_place(from, place, &mut self.path)
    }

    /// The lengths of the shortest ways to the piles that can be reached, in cells.
    #[must_use]
    pub fn ways_to_piles(&self, from: Point) -> BTreeMap<PileId, f64> {
        self.terrain.ways_to_piles(from)
    }

    /// A shortest way to a pile's contacts.
    pub fn route_to_pile(&mut self, from: Point, pile: PileId) -> Option<Route> {
        self.terrain.route_to_pile(from, pile, &mut self.path)
    }

    /// How long a cell is.
    #[must_use]
    pub fn metres_per_cell(&self) -> f64 {
        self.terrain.site().resolution_m
    }

    /// How long to work at the place of a task.
    pub fn time_at_work(&mut self, task: Task) -> DurationMs {
        task.time_at_work(&mut self.random)
    }

    /// A shortest way between any two points; `None` if there is none.
    pub fn route(&mut self, from: Point, to: Point) -> Option<Route> {
        let site = self.terrain.site();
        let start = site.cell_of(from.into())?;
        let goal = site.cell_of(to.into())?;
        if start == goal {
            return Some(Route::from([to]));
        }
        let search = AStar::new(&site.grid, site.moves);
        let found = search.plan(start, goal, &mut self.workspace).ok()?;
        Some(found.path.waypoints().iter().map(|&cell| site.position(cell).into()).collect())
    }

    /// Whether a pile is within `distance_m` of `position`.
    #[must_use]
    pub fn near_a_pile(&self, position: Point, distance_m: f64) -> bool {
        self.terrain.piles().iter().any(|pile| pile.distance_m(position) < distance_m)
    }
}
