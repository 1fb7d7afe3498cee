//! Shortest paths between any two cells, found on the map itself.
//!
//! | planner | moves | what it keeps of the map |
//! |---|---|---|
//! | [`Dijkstra`] | 8 or 16 | nothing; also from one cell to many |
//! | [`AStar`] | 8 or 16 | nothing |
//! | [`Jps`] | 8 or 16 | bitmaps of where jumps end |
//!
//! All answer the one trait [`Planner`]. Costs are integers, so the same query expands the same nodes
//! on every machine.

mod astar;
mod dijkstra;
pub mod jps;
pub(crate) mod neighbours;
mod nodes;
mod open;

pub use astar::AStar;
pub use dijkstra::{Dijkstra, Ways};
pub use jps::Jps;
pub use nodes::Workspace;
pub(crate) use open::Open;

use crate::{
    grid::{Cell, Grid},
    path::Path,
};

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
    /// The planner knows the ways to some places only, and this is none of them.
    #[error("cell {cell} is no known target: plan to one of the targets, or search the map")]
    NoTarget {
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

/// The index of `cell`, if a robot can be there.
pub(crate) fn free_index(grid: &Grid, cell: Cell) -> Result<usize, SearchError> {
    let (width, height) = (grid.width(), grid.height());
    let index = grid.index(cell).ok_or(SearchError::Outside { cell, width, height })?;
    if grid.is_free(cell) { Ok(index) } else { Err(SearchError::Blocked { cell }) }
}
