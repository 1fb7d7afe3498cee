//! Rapidly exploring random trees with goal bias (Mecanum III.B.1), and what the paper makes of them.
//!
//! A tree grows from the start: a cell is drawn by chance, and the node nearest to it sends out a branch
//! towards it. If often the goal itself is drawn ([`Rrt::goal_bias`]) the tree has fewer branches (Fig. 3).
//! What zigzags there are in its path [`keep_necessary_nodes`] takes out (Figs. 4, 5). The result is a line of
//! any angle from cell to cell, each seen from the one before ([`sees`]); [`ImprovedAStar`] makes a path of
//! the usual moves of it (Fig. 7).
//!
//! A tree finds some way, not a short one: there is no bound on how much longer than the shortest it is.
//! And it proves nothing: where it finds none there may be one.
//!
//! The paper draws points, we draw cells, so that a line is checked with whole numbers and the tree of a
//! seed is the same on every machine.

mod improved;
mod nearest;
mod sight;

use std::num::NonZeroU32;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use self::nearest::Quadtree;
pub use self::{
    improved::{ImprovedAStar, ImprovedWorkspace},
    sight::{keep_necessary_nodes, sees},
};
use crate::{
    grid::{Cell, Grid},
    search::{SearchError, free_index},
};

/// How a tree grows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rrt {
    /// The longest branch, in cells, before its end is rounded to a cell.
    pub branch: NonZeroU32,
    /// How probable it is that the goal is drawn: never at 0, always at 1. Below 1 every way there is will
    /// be found in the end; at 1 the tree gets stuck at the first wall.
    pub goal_bias: f64,
    /// After so many draws it gives up.
    pub samples: u32,
}

impl Rrt {
    /// The paper's bias of 0.7; it prints neither the length of a branch nor when it gives up.
    pub const PAPER: Self = Self { branch: NonZeroU32::new(3).unwrap(), goal_bias: 0.7, samples: 20_000 };
}

/// Why a tree has found no path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RrtError {
    /// The start or goal is outside or blocked.
    #[error(transparent)]
    Search(#[from] SearchError),
    /// All draws are used up. That does not say that there is no path.
    #[error(
        "no path from {from} to {to} was found with {samples} samples, though there may be one: allow more \
         samples, or search with A*, which knows"
    )]
    Exhausted {
        /// The start.
        from: Cell,
        /// The goal.
        to: Cell,
        /// The draws.
        samples: u32,
    },
}

/// A tree, kept from query to query for its memory.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    /// Each with the number of the node it grew from; the first is the start.
    nodes: Vec<(Cell, u32)>,
    index: Quadtree,
}

impl Tree {
    /// How many nodes it has, the start among them.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Whether nothing has grown yet.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The branches, each from its node to its new end, in the order they grew.
    pub fn branches(&self) -> impl Iterator<Item = (Cell, Cell)> + '_ {
        let start = |parent: u32| self.nodes.get(parent as usize).map(|&(cell, _)| cell);
        self.nodes.iter().skip(1).filter_map(move |&(end, parent)| Some((start(parent)?, end)))
    }

    /// The nodes from the start to the one that grew last, which is the goal if it was reached.
    #[must_use]
    pub fn path(&self) -> Vec<Cell> {
        let mut path = Vec::new();
        self.trace(&mut path);
        path
    }

    /// Puts [`Self::path`] in place of what is in `path`.
    fn trace(&self, path: &mut Vec<Cell>) {
        path.clear();
        let mut number = self.nodes.len().wrapping_sub(1);
        while let Some(&(cell, parent)) = self.nodes.get(number) {
            path.push(cell);
            number = if number == 0 { usize::MAX } else { parent as usize };
        }
        path.reverse();
    }

    fn clear(&mut self, grid: &Grid) {
        self.nodes.clear();
        self.index.clear(grid.width().max(grid.height()));
    }

    /// Adds a node and answers its number; `None` if its cell has one.
    fn add(&mut self, cell: Cell, parent: u32) -> Option<u32> {
        let number = self.nodes.len() as u32;
        self.index.insert(cell, number).then(|| self.nodes.push((cell, parent)))?;
        Some(number)
    }
}

impl Rrt {
    /// Grows `tree` from `from` until it reaches `to`. The tree is the same for the same arguments, on
    /// every machine.
    ///
    /// # Errors
    /// [`RrtError::Search`] if an end is outside or blocked, [`RrtError::Exhausted`] if `to` was not reached;
    /// the tree holds what has grown.
    pub fn grow(
        &self,
        grid: &Grid,
        from: Cell,
        to: Cell,
        seed: u64,
        tree: &mut Tree,
    ) -> Result<(), RrtError> {
        tree.clear(grid);
        free_index(grid, from)?;
        free_index(grid, to)?;
        tree.add(from, 0);
        if from == to {
            return Ok(());
        }
        let mut chance = Pcg64Mcg::seed_from_u64(seed);
        // How large the tree was when it last aimed at the goal: until it has grown, that is in vain again.
        let mut aimed_with = 0;
        for _ in 0..self.samples {
            let aims = chance.random::<f64>() < self.goal_bias;
            if aims && tree.len() == aimed_with {
                continue;
            }
            let drawn = if aims {
                aimed_with = tree.len();
                to
            } else {
                any_cell(grid, &mut chance)
            };
            let Some(parent) = tree.index.nearest(drawn) else { break };
            let Some(&(start, _)) = tree.nodes.get(parent as usize) else { break };
            let Some(end) = branch_end(grid, start, drawn, self.branch) else { continue };
            let Some(number) = tree.add(end, parent) else { continue };
            if end == to {
                return Ok(());
            }
            if towards(end, to, self.branch) == to && sees(grid, end, to) {
                tree.add(to, number);
                return Ok(());
            }
        }
        Err(RrtError::Exhausted { from, to, samples: self.samples })
    }
}

/// Any cell of a grid that has some, free or not.
fn any_cell(grid: &Grid, chance: &mut Pcg64Mcg) -> Cell {
    let x = chance.random_range(0..grid.width().max(1));
    let y = chance.random_range(0..grid.height().max(1));
    Cell { x: x as i32, y: y as i32 }
}

/// Where a branch towards `to` ends: one that a wall is in the way of is halved until none is, so that trees
/// find through doors. `None` if not even a cell is free.
fn branch_end(grid: &Grid, from: Cell, to: Cell, branch: NonZeroU32) -> Option<Cell> {
    let shorter = |branch: &NonZeroU32| NonZeroU32::new(branch.get() / 2);
    let mut ends = std::iter::successors(Some(branch), shorter).map(|branch| towards(from, to, branch));
    ends.find(|&end| sees(grid, from, end))
}

/// `to`, or the cell on the way there that is `branch` away.
fn towards(from: Cell, to: Cell, branch: NonZeroU32) -> Cell {
    let (dx, dy) = (f64::from(to.x - from.x), f64::from(to.y - from.y));
    let share = f64::from(branch.get()) / (dx * dx + dy * dy).sqrt();
    if share >= 1.0 { to } else { from.offset((dx * share).round() as i32, (dy * share).round() as i32) }
}
