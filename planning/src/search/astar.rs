//! A* (Hart, Nilsson and Raphael), with the free-grid distance of the move set as heuristic.

use super::{Plan, Planner, SearchError, Workspace, free_index};
use crate::{
    grid::{Cell, Grid},
    moves::MoveSet,
};

/// Plans shortest paths by A*. It keeps nothing of its map: make one wherever one is needed.
#[derive(Clone, Copy, Debug)]
pub struct AStar<'g> {
    grid: &'g Grid,
    moves: MoveSet,
}

impl<'g> AStar<'g> {
    /// A planner on `grid`.
    #[must_use]
    pub const fn new(grid: &'g Grid, moves: MoveSet) -> Self {
        Self { grid, moves }
    }
}

impl Planner for AStar<'_> {
    type Workspace = Workspace;

    fn plan<'w>(&self, from: Cell, to: Cell, workspace: &'w mut Workspace) -> Result<Plan<'w>, SearchError> {
        let Self { grid, moves } = *self;
        free_index(grid, from)?;
        let goal = free_index(grid, to)?;
        let estimate = |cell: Cell| moves.open_length(to.x - cell.x, to.y - cell.y).cost();
        workspace.begin(grid);
        workspace.want(goal);
        let expanded = workspace.run(grid, moves, from, estimate, 1);
        if !workspace.is_reached(goal) {
            return Err(SearchError::NoPath { from, to });
        }
        workspace.trace(grid, to);
        Ok(Plan { path: &workspace.path, expanded })
    }
}
