//! The paper's improved A* (Mecanum III.B.3, Figs. 6, 7): a search with obstacles in its way becomes some
//! without.

use super::{Rrt, RrtError, Tree, keep_necessary_nodes};
use crate::{
    grid::{Cell, Grid},
    path::Path,
    search::{Plan, Planner, SearchError},
};

/// Plans by a tree: its necessary nodes are intermediate goals, between which `P` plans, in the paper
/// jump point search.
///
/// Nodes that follow each other see each other, so that the way between them is no longer than their
/// columns and rows together, at most sqrt 2 times the straight line. How long the line through the nodes is
/// nobody knows: the tree may go around the wrong side of everything, so that there is no bound on how
/// much longer than the shortest the path is. If the tree gives up, `P` plans the whole way: a path is found
/// wherever there is one.
#[derive(Clone, Copy, Debug)]
pub struct ImprovedAStar<'g, P> {
    grid: &'g Grid,
    between: P,
    rrt: Rrt,
    seed: u64,
}

/// The memory of [`ImprovedAStar`].
#[derive(Clone, Debug, Default)]
pub struct ImprovedWorkspace<W> {
    tree: Tree,
    nodes: Vec<Cell>,
    between: W,
    path: Path,
}

impl<W> ImprovedWorkspace<W> {
    /// The tree of the last query.
    #[must_use]
    pub const fn tree(&self) -> &Tree {
        &self.tree
    }

    /// The necessary nodes of the last query, from start to goal; none if its tree gave up.
    #[must_use]
    pub fn nodes(&self) -> &[Cell] {
        &self.nodes
    }
}

impl<'g, P: Planner> ImprovedAStar<'g, P> {
    /// A planner on `grid`, which `between` plans on too. Every query grows its tree from the same seed, so
    /// that its answer is always the same.
    #[must_use]
    pub const fn new(grid: &'g Grid, between: P, rrt: Rrt, seed: u64) -> Self {
        Self { grid, between, rrt, seed }
    }
}

impl<P: Planner> Planner for ImprovedAStar<'_, P> {
    type Workspace = ImprovedWorkspace<P::Workspace>;

    /// A path, seldom the shortest. `expanded` counts what the searches between the nodes expanded; the
    /// tree's nodes are in the workspace.
    fn plan<'w>(
        &self,
        from: Cell,
        to: Cell,
        workspace: &'w mut Self::Workspace,
    ) -> Result<Plan<'w>, SearchError> {
        let ImprovedWorkspace { tree, nodes, between, path } = workspace;
        nodes.clear();
        match self.rrt.grow(self.grid, from, to, self.seed, tree) {
            Ok(()) => tree.trace(nodes),
            Err(RrtError::Search(error)) => return Err(error),
            Err(RrtError::Exhausted { .. }) => return self.between.plan(from, to, between),
        }
        keep_necessary_nodes(self.grid, nodes);
        path.restart(from);
        let mut expanded = 0;
        for (&from, &to) in nodes.iter().zip(nodes.iter().skip(1)) {
            let plan = self.between.plan(from, to, between)?;
            plan.path.steps().for_each(|step| path.step(step));
            expanded += plan.expanded;
        }
        Ok(Plan { path, expanded })
    }
}
