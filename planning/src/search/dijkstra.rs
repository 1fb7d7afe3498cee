//! Dijkstra's algorithm: from one cell to another, to many, or to all.

use super::{Plan, Planner, SearchError, Workspace, free_index};
use crate::{
    grid::{Cell, Grid},
    moves::{Length, MoveSet, Step},
    path::Path,
};

/// Plans shortest paths by Dijkstra's algorithm. It keeps nothing of its map: make one wherever one
/// is needed.
#[derive(Clone, Copy, Debug)]
pub struct Dijkstra<'g> {
    grid: &'g Grid,
    moves: MoveSet,
}

impl<'g> Dijkstra<'g> {
    /// A planner on `grid`.
    #[must_use]
    pub const fn new(grid: &'g Grid, moves: MoveSet) -> Self {
        Self { grid, moves }
    }

    /// The shortest ways from `from` to all of `targets`, or to every cell if there are none.
    ///
    /// # Errors
    /// [`SearchError`] if `from` is outside or blocked.
    pub fn ways<'w>(
        self,
        from: Cell,
        targets: &[Cell],
        workspace: &'w mut Workspace,
    ) -> Result<Ways<'w>, SearchError>
    where
        'g: 'w,
    {
        let Self { grid, moves } = self;
        free_index(grid, from)?;
        workspace.begin(grid);
        let targets = targets.iter().filter_map(|&cell| free_index(grid, cell).ok());
        let wanted = targets.filter(|&index| workspace.want(index)).count();
        let expanded = workspace.run(grid, moves, from, |_| 0, wanted);
        Ok(Ways { grid, workspace, expanded })
    }
}

impl Planner for Dijkstra<'_> {
    type Workspace = Workspace;

    fn plan<'w>(&self, from: Cell, to: Cell, workspace: &'w mut Workspace) -> Result<Plan<'w>, SearchError> {
        free_index(self.grid, from)?;
        free_index(self.grid, to)?;
        let expanded = self.ways(from, &[to], workspace)?.expanded;
        if !workspace.is_expanded(self.grid, to) {
            return Err(SearchError::NoPath { from, to });
        }
        workspace.trace(self.grid, to);
        Ok(Plan { path: &workspace.path, expanded })
    }
}

/// The shortest ways from one cell to others.
#[derive(Debug)]
pub struct Ways<'w> {
    grid: &'w Grid,
    workspace: &'w Workspace,
    expanded: u32,
}

impl Ways<'_> {
    /// A shortest path to `cell`; `None` if there is none.
    #[must_use]
    pub fn path_to(&self, cell: Cell) -> Option<Path> {
        let mut path = Path::at(cell);
        self.steps_back(cell)?.for_each(|(dx, dy)| path.step((-dx, -dy)));
        Some(path.reversed())
    }

    /// Whether there is a path to `cell`; unlike its length that needs no walk along it.
    #[must_use]
    pub fn leads_to(&self, cell: Cell) -> bool {
        self.workspace.is_expanded(self.grid, cell)
    }

    /// The length of the shortest path to `cell`, which is walked for it; `None` if there is none.
    #[must_use]
    pub fn length_to(&self, cell: Cell) -> Option<Length> {
        Some(self.steps_back(cell)?.map(Length::of).sum())
    }

    /// The first move of a shortest path from `cell` back to the start; `None` at the start itself
    /// and where none is known.
    #[must_use]
    pub fn step_back(&self, cell: Cell) -> Option<Step> {
        let (dx, dy) = self.steps_back(cell)?.next()?;
        Some((-dx, -dy))
    }

    /// How many nodes were expanded.
    #[must_use]
    pub const fn expanded(&self) -> u32 {
        self.expanded
    }

    fn steps_back(&self, cell: Cell) -> Option<impl Iterator<Item = Step> + '_> {
        // What was reached and not expanded may have a shorter way.
        self.leads_to(cell).then(|| self.workspace.steps_back(self.grid, cell))
    }
}
