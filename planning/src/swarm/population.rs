//! The paths a swarm starts with (IGWO, 3.1, step 1): at random, but each leads to the goal.

use std::{cmp::Reverse, collections::BinaryHeap};

use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::Ground;
use crate::{
    grid::Cell,
    moves::{self, MoveSet, Step},
};

/// A move is up to so many times as dear as it is long: the more, the more a path winds.
const DEAREST: u32 = 4;

/// The memory of the search for random paths.
#[derive(Clone, Debug, Default)]
pub(super) struct RandomPaths {
    cells: Vec<Reached>,
    open: BinaryHeap<Reverse<(u64, u32)>>,
}

#[derive(Clone, Copy, Debug)]
struct Reached {
    cost: u64,
    /// The move that leads on towards the goal; `(0, 0)` there.
    next: (i8, i8),
    closed: bool,
}

const UNREACHED: Reached = Reached { cost: u64::MAX, next: (0, 0), closed: false };

impl RandomPaths {
    /// Puts the turns of a random path into `turns`, start and goal included: a shortest path if every
    /// move costs a random multiple of its length. `None` if walls part the two.
    pub fn draw(&mut self, ground: Ground<'_>, rng: &mut Pcg64Mcg, turns: &mut Vec<Cell>) -> Option<()> {
        self.search(ground, rng)?;
        turns.clear();
        let (mut here, mut before) = (ground.from, (0, 0));
        while let Some(step) = self.next(ground, here).filter(|&step| step != (0, 0)) {
            if step != before {
                turns.push(here);
            }
            (here, before) = (here.offset(step.0, step.1), step);
        }
        turns.push(ground.to);
        Some(())
    }

    fn next(&self, ground: Ground<'_>, cell: Cell) -> Option<Step> {
        let (dx, dy) = self.cells.get(ground.grid.index(cell)?)?.next;
        Some((i32::from(dx), i32::from(dy)))
    }

    /// Dijkstra's algorithm from the goal, so that the moves lead forward.
    fn search(&mut self, ground: Ground<'_>, rng: &mut Pcg64Mcg) -> Option<()> {
        let Ground { grid, from, to } = ground;
        let (start, goal) = (grid.index(from)?, grid.index(to)?);
        self.open.clear();
        self.cells.clear();
        self.cells.resize(grid.len(), UNREACHED);
        self.reach(goal, Reached { cost: 0, ..UNREACHED });
        while let Some(Reverse((cost, index))) = self.open.pop() {
            let index = index as usize;
            let Some(cell) = self.cells.get_mut(index).filter(|cell| !cell.closed) else { continue };
            if index == start {
                return Some(());
            }
            cell.closed = true;
            let here = grid.cell(index);
            for &(dx, dy) in MoveSet::Eight.steps() {
                if !moves::allowed(grid, here, (dx, dy)) {
                    continue;
                }
                let length: u32 = if dx == 0 || dy == 0 { 1000 } else { 1414 };
                let cost = cost + u64::from(length) * u64::from(rng.random_range(1000..=1000 * DEAREST));
                let next = (-dx as i8, -dy as i8);
                if let Some(index) = grid.index(here.offset(dx, dy)) {
                    self.reach(index, Reached { cost, next, closed: false });
                }
            }
        }
        None
    }

    fn reach(&mut self, index: usize, reached: Reached) {
        if let Some(cell) = self.cells.get_mut(index).filter(|cell| reached.cost < cell.cost) {
            *cell = reached;
            self.open.push(Reverse((reached.cost, index as u32)));
        }
    }
}
