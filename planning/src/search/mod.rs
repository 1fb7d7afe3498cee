//! Shortest paths: A* for one goal, Dijkstra for many.
//!
//! Costs are integers, so the same query expands the same nodes on every machine. A [`Workspace`]
//! is reused from query to query and allocates only when a grid is larger than any before.

use std::{
    cmp::Reverse,
    collections::{BinaryHeap, HashSet},
};

use crate::{
    grid::{Cell, Grid},
    moves::{self, Cost, Length, MoveSet, Step},
    path::Path,
};

/// The memory of a search.
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    nodes: Vec<Node>,
    /// Nodes of other rounds are as good as new: no need to clear them.
    round: u32,
    open: BinaryHeap<Reverse<(Cost, Cost, u32)>>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Node {
    cost: Cost,
    round: u32,
    /// The move by which the node was reached; `(0, 0)` at the start.
    reached_by: (i8, i8),
    closed: bool,
}

/// A path and what it took to find it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// A shortest path.
    pub path: Path,
    /// How many nodes were expanded.
    pub expanded: u32,
}

/// Plans between any two cells of the map it was made for.
///
/// One trait for all planners, so that they can be measured and compared alike. What a planner keeps
/// of its map is in the planner; what a query needs is in the workspace, which is handed over, so that
/// threads share one planner. After some queries of the same map a workspace allocates no more.
pub trait Planner {
    /// The memory of a query.
    type Workspace: Default;

    /// The shortest path, or whatever else the planner's own documentation promises.
    ///
    /// # Errors
    /// [`SearchError`] if an end is outside or blocked, or there is no path.
    fn plan<'w>(
        &self,
        from: Cell,
        to: Cell,
        workspace: &'w mut Self::Workspace,
    ) -> Result<Plan<'w>, SearchError>;
}

/// What a [`Planner`] answers; it lives until the next query.
#[derive(Clone, Copy, Debug)]
pub struct Plan<'w> {
    /// The path.
    pub path: &'w Path,
    /// How many nodes were expanded.
    pub expanded: u32,
}

/// Why there is no path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SearchError {
    /// The start or goal is outside the map.
    #[error("cell {cell} is outside the map of {width} x {height} cells: x goes from 0 to {}, y from 0 to {}", width.saturating_sub(1), height.saturating_sub(1))]
    Outside {
        /// Which cell.
        cell: Cell,
        /// The map's columns.
        width: u32,
        /// The map's rows.
        height: u32,
    },
    /// The start or goal is blocked.
    #[error("cell {cell} is blocked: choose a free one")]
    Blocked {
        /// Which cell.
        cell: Cell,
    },
    /// Start and goal are free, but walls part them.
    #[error("no path leads from {from} to {to}: walls part them")]
    NoPath {
        /// The start.
        from: Cell,
        /// The goal.
        to: Cell,
    },
}

/// A shortest path by A*, with the free-grid distance of the move set as heuristic.
///
/// # Errors
/// [`SearchError`] if an end is outside or blocked, or there is no path.
pub fn astar(
    grid: &Grid,
    moves: MoveSet,
    from: Cell,
    to: Cell,
    workspace: &mut Workspace,
) -> Result<Found, SearchError> {
    let start = free_index(grid, from)?;
    let goal = free_index(grid, to)?;
    let estimate = |cell: Cell| moves.open_length(to.x - cell.x, to.y - cell.y).cost();
    let expanded = workspace.run(grid, moves, start, estimate, |index| index == goal);
    let path = workspace.path_to(grid, to).ok_or(SearchError::NoPath { from, to })?;
    Ok(Found { path, expanded })
}

/// The shortest ways from `from`, by Dijkstra's algorithm: to all of `targets`, or to every cell
/// if there are none.
///
/// # Errors
/// [`SearchError`] if `from` is outside or blocked.
pub fn dijkstra<'a>(
    grid: &'a Grid,
    moves: MoveSet,
    from: Cell,
    targets: &[Cell],
    workspace: &'a mut Workspace,
) -> Result<Ways<'a>, SearchError> {
    let start = free_index(grid, from)?;
    let mut missing: HashSet<_> = targets.iter().filter_map(|&cell| free_index(grid, cell).ok()).collect();
    let done = |index: usize| missing.remove(&index) && missing.is_empty();
    let expanded = workspace.run(grid, moves, start, |_| 0, done);
    Ok(Ways { grid, workspace, expanded })
}

/// The shortest ways from one cell to others.
#[derive(Debug)]
pub struct Ways<'a> {
    grid: &'a Grid,
    workspace: &'a Workspace,
    expanded: u32,
}

impl Ways<'_> {
    /// A shortest path to `cell`; `None` if there is none.
    #[must_use]
    pub fn path_to(&self, cell: Cell) -> Option<Path> {
        self.workspace.path_to(self.grid, cell)
    }

    /// The length of the shortest path to `cell`; `None` if there is none.
    #[must_use]
    pub fn length_to(&self, cell: Cell) -> Option<Length> {
        Some(self.workspace.steps_back(self.grid, cell)?.map(Length::of).sum())
    }

    /// The first move of a shortest path from `cell` back to the start; `None` at the start itself
    /// and where none is known.
    #[must_use]
    pub fn step_back(&self, cell: Cell) -> Option<Step> {
        let (dx, dy) = self.workspace.steps_back(self.grid, cell)?.next()?;
        Some((-dx, -dy))
    }

    /// How many nodes were expanded.
    #[must_use]
    pub const fn expanded(&self) -> u32 {
        self.expanded
    }
}

/// The index of `cell`, if a robot can be there.
pub(crate) fn free_index(grid: &Grid, cell: Cell) -> Result<usize, SearchError> {
    let (width, height) = (grid.width(), grid.height());
    let index = grid.index(cell).ok_or(SearchError::Outside { cell, width, height })?;
    if grid.is_free(cell) { Ok(index) } else { Err(SearchError::Blocked { cell }) }
}

impl Workspace {
    /// Searches from `start` until `done` says so of an expanded node; returns how many were.
    fn run(
        &mut self,
        grid: &Grid,
        moves: MoveSet,
        start: usize,
        estimate: impl Fn(Cell) -> Cost,
        mut done: impl FnMut(usize) -> bool,
    ) -> u32 {
        self.begin(grid.len());
        self.reach(start, 0, (0, 0), estimate(grid.cell(start)));
        let mut expanded = 0;
        while let Some(Reverse((_, _, index))) = self.open.pop() {
            let index = index as usize;
            let Some(node) = self.nodes.get_mut(index).filter(|node| !node.closed) else { continue };
            node.closed = true;
            expanded += 1;
            if done(index) {
                break;
            }
            let (cost, cell) = (node.cost, grid.cell(index));
            for &step in moves.steps() {
                if !moves::allowed(grid, cell, step) {
                    continue;
                }
                let next = cell.offset(step.0, step.1);
                if let Some(next_index) = grid.index(next) {
                    self.reach(next_index, cost + Length::of(step).cost(), step, estimate(next));
                }
            }
        }
        expanded
    }

    fn begin(&mut self, cells: usize) {
        self.open.clear();
        if self.nodes.len() < cells || self.round == u32::MAX {
            self.nodes.clear();
            self.nodes.resize(cells, Node::default());
            self.round = 0;
        }
        self.round += 1;
    }

    fn reach(&mut self, index: usize, cost: Cost, (dx, dy): Step, estimate: Cost) {
        let Some(node) = self.nodes.get_mut(index) else { return };
        if node.round == self.round && node.cost <= cost {
            return;
        }
        *node = Node { cost, round: self.round, reached_by: (dx as i8, dy as i8), closed: false };
        // Of equal sums the one nearer to the goal comes first.
        self.open.push(Reverse((cost + estimate, estimate, index as u32)));
    }

    /// The moves from `cell` back to the start, each as it was made; `None` if it was not reached.
    fn steps_back<'a>(&'a self, grid: &'a Grid, cell: Cell) -> Option<impl Iterator<Item = Step> + 'a> {
        let reached_by = |cell: Cell| {
            let node = self.nodes.get(grid.index(cell)?)?;
            // What was reached and not expanded may have a shorter way.
            if node.round != self.round || !node.closed {
                return None;
            }
            Some((i32::from(node.reached_by.0), i32::from(node.reached_by.1)))
        };
        reached_by(cell)?;
        let mut here = cell;
        Some(std::iter::from_fn(move || {
            let step = reached_by(here).filter(|&step| step != (0, 0))?;
            here = here.offset(-step.0, -step.1);
            Some(step)
        }))
    }

    fn path_to(&self, grid: &Grid, cell: Cell) -> Option<Path> {
        let mut path = Path::at(cell);
        self.steps_back(grid, cell)?.for_each(|(dx, dy)| path.step((-dx, -dy)));
        Some(path.reversed())
    }
}
