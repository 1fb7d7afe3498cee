//! The planners that are measured: ours, and those of other crates.

use grid_pathfinding::PathingGrid;
use grid_util::{grid::ValueGrid, point::Point};
use planning::{
    grid::{Cell, Grid},
    indexed::Index,
    moves::{self, Length, MoveSet},
    search::{AStar, Dijkstra, Plan, Planner, jps::Jps},
};

/// Anything that plans, ready for queries.
pub trait Contestant {
    /// Plans; `None` if there is no path.
    fn plan(&mut self, from: Cell, to: Cell) -> Option<Answer>;

    /// Plans and looks whether the path leads from start to goal by allowed moves; of peers that is believed.
    fn plan_and_walk(&mut self, _grid: &Grid, from: Cell, to: Cell) -> Option<(Answer, bool)> {
        Some((self.plan(from, to)?, true))
    }

    /// What it keeps of the map, in bytes, as far as it tells.
    fn bytes(&self) -> Option<usize> {
        None
    }
}

/// What a planner found.
pub struct Answer {
    /// In cells.
    pub length: f64,
    /// Nodes expanded, as far as the planner tells.
    pub expanded: Option<u32>,
}

/// A planner to be made for a map.
pub struct Entry {
    pub name: &'static str,
    /// Its moves.
    pub moves: MoveSet,
    /// Whether it finds optimal lengths under our corner rule.
    pub is_optimal: bool,
    /// Whether it is asked some queries only, so that a run takes minutes.
    pub is_sampled: bool,
    pub make: Make,
}

/// Our planners.
pub const OURS: [Entry; 8] = [
    entry("JPS", MoveSet::Eight, |grid| jps(grid, MoveSet::Eight)),
    entry("indexed", MoveSet::Eight, |grid| indexed(grid, MoveSet::Eight)),
    sampled("A*", MoveSet::Eight, |grid| ours(AStar::new(grid, MoveSet::Eight), MoveSet::Eight, 0)),
    sampled("Dijkstra", MoveSet::Eight, |grid| ours(Dijkstra::new(grid, MoveSet::Eight), MoveSet::Eight, 0)),
    entry("JPS, 16 neighbours", MoveSet::Sixteen, |grid| jps(grid, MoveSet::Sixteen)),
    entry("indexed, 16 neighbours", MoveSet::Sixteen, |grid| indexed(grid, MoveSet::Sixteen)),
    sampled("A*, 16 neighbours", MoveSet::Sixteen, |grid| {
        ours(AStar::new(grid, MoveSet::Sixteen), MoveSet::Sixteen, 0)
    }),
    sampled("Dijkstra, 16 neighbours", MoveSet::Sixteen, |grid| {
        ours(Dijkstra::new(grid, MoveSet::Sixteen), MoveSet::Sixteen, 0)
    }),
];

type Make = for<'g> fn(&'g Grid) -> Box<dyn Contestant + 'g>;

const fn entry(name: &'static str, moves: MoveSet, make: Make) -> Entry {
    Entry { name, moves, is_optimal: true, is_sampled: false, make }
}

const fn sampled(name: &'static str, moves: MoveSet, make: Make) -> Entry {
    Entry { is_sampled: true, ..entry(name, moves, make) }
}

fn jps(grid: &Grid, moves: MoveSet) -> Box<dyn Contestant + '_> {
    let planner = Jps::new(grid.clone(), moves);
    let bytes = planner.bytes();
    ours(planner, moves, bytes)
}

fn indexed(grid: &Grid, moves: MoveSet) -> Box<dyn Contestant + '_> {
    let index = Index::build(grid.clone(), moves);
    let bytes = index.bytes();
    ours(index, moves, bytes)
}

fn ours<'g, P: Planner + 'g>(planner: P, moves: MoveSet, bytes: usize) -> Box<dyn Contestant + 'g> {
    Box::new(Ours { planner, moves, workspace: P::Workspace::default(), bytes })
}

/// `pathfinding`, with our moves.
pub const PATHFINDING: Entry = Entry {
    name: "pathfinding 4.16 astar",
    moves: MoveSet::Eight,
    is_optimal: true,
    is_sampled: true,
    make: |grid| Box::new(Pathfinding { grid }),
};

/// `grid_pathfinding`. Its version 0.3.0 has no option against cutting corners, and squeezes between
/// two blocked cells that touch: its paths are shorter and its problem another one. Its pruning of turns on
/// diagonals, which it has on at first, makes it slower on every map here, up to three times: it is off.
pub const GRID_PATHFINDING: Entry = Entry {
    name: "grid_pathfinding 0.3.0 (cuts corners)",
    moves: MoveSet::Eight,
    is_optimal: false,
    is_sampled: true,
    make: |grid| Box::new(GridPathfinding::new(grid)),
};

struct Ours<P: Planner> {
    planner: P,
    moves: MoveSet,
    workspace: P::Workspace,
    bytes: usize,
}

impl<P: Planner> Contestant for Ours<P> {
    fn plan(&mut self, from: Cell, to: Cell) -> Option<Answer> {
        let plan = self.planner.plan(from, to, &mut self.workspace).ok()?;
        Some(Answer { length: plan.path.length().units(), expanded: Some(plan.expanded) })
    }

    fn plan_and_walk(&mut self, grid: &Grid, from: Cell, to: Cell) -> Option<(Answer, bool)> {
        let Plan { path, expanded } = self.planner.plan(from, to, &mut self.workspace).ok()?;
        let leads = (path.start(), path.end()) == (from, to) && path.is_walkable(grid, self.moves);
        Some((Answer { length: path.length().units(), expanded: Some(expanded) }, leads))
    }

    fn bytes(&self) -> Option<usize> {
        Some(self.bytes)
    }
}

struct Pathfinding<'g> {
    grid: &'g Grid,
}

/// A cell's length in millionths.
const STRAIGHT: u64 = 1_000_000;
const DIAGONAL: u64 = 1_414_214;

impl Contestant for Pathfinding<'_> {
    fn plan(&mut self, from: Cell, to: Cell) -> Option<Answer> {
        let weight =
            |length: Length| u64::from(length.straight) * STRAIGHT + u64::from(length.diagonal) * DIAGONAL;
        let grid = self.grid;
        let successors = |&cell: &Cell| {
            let allowed = move |&&step: &&(i32, i32)| moves::allowed(grid, cell, step);
            let steps = MoveSet::Eight.steps().iter().filter(allowed);
            steps.map(move |&step| (cell.offset(step.0, step.1), weight(Length::of(step))))
        };
        let estimate = |cell: &Cell| weight(MoveSet::Eight.open_length(to.x - cell.x, to.y - cell.y));
        let (path, _) = pathfinding::prelude::astar(&from, successors, estimate, |&cell| cell == to)?;
        let step = |pair: &[Cell]| match pair {
            &[one, other] => Length::of((other.x - one.x, other.y - one.y)),
            _ => Length::default(),
        };
        let length: Length = path.windows(2).map(step).sum();
        Some(Answer { length: length.units(), expanded: None })
    }
}

struct GridPathfinding {
    grid: PathingGrid,
}

impl GridPathfinding {
    fn new(map: &Grid) -> Self {
        let mut grid = PathingGrid::new(map.width() as usize, map.height() as usize, true);
        for cell in map.free_cells() {
            grid.set(cell.x, cell.y, false);
        }
        grid.improved_pruning = false;
        grid.initialize();
        grid.generate_components();
        Self { grid }
    }
}

impl Contestant for GridPathfinding {
    fn plan(&mut self, from: Cell, to: Cell) -> Option<Answer> {
        let point = |cell: Cell| Point::new(cell.x, cell.y);
        let waypoints = self.grid.get_waypoints_single_goal(point(from), point(to), false)?;
        let run = |pair: &[Point]| match pair {
            &[one, other] => MoveSet::Eight.open_length(other.x - one.x, other.y - one.y),
            _ => Length::default(),
        };
        let length: Length = waypoints.windows(2).map(run).sum();
        Some(Answer { length: length.units(), expanded: None })
    }
}
