//! What sight along slanted lines takes with 16 neighbours.

use super::{
    lines::Lines,
    turns::{RING, number},
};
use crate::{
    grid::{Cell, Grid},
    moves::MoveSet,
    search::neighbours::{self, Moves},
};

/// Which moves are allowed, and where diagonals stop.
#[derive(Clone, Debug)]
pub(super) struct Slanted {
    width: i32,
    height: i32,
    /// By cell.
    allowed: Vec<Moves>,
    /// By quarter of the turn, diagonals that stop where no move leads on, and at subgoals.
    diagonals: [Lines; 4],
}

/// By direction the number of the move in [`MoveSet::steps`].
const STEPS: [u8; 16] = {
    let mut steps = [0; 16];
    let mut step = 0;
    while step < 16 {
        steps[number(MoveSet::Sixteen.steps()[step as usize])] = step;
        step += 1;
    }
    steps
};

impl Slanted {
    /// Of a map whose rows stop at blocked cells and subgoals.
    pub(super) fn new(grid: &Grid, rows: &Lines) -> Self {
        let moves = |index| neighbours::allowed(grid, MoveSet::Sixteen, grid.cell(index));
        let allowed = (0..grid.len()).map(moves).collect();
        let (width, height) = (grid.width() as usize, grid.height() as usize);
        let stopped = || Lines::stopped(height, width + height);
        let diagonals = [stopped(), stopped(), stopped(), stopped()];
        let mut slanted = Self { width: width as i32, height: height as i32, allowed, diagonals };
        for cell in grid.free_cells().filter(|cell| !rows.stops(cell.x, cell.y)) {
            for quarter in 0..4 {
                let direction = 4 * quarter + 2;
                let (dx, dy) = RING[direction];
                // What may be gone back may be gone forth.
                if slanted.allows(cell, (direction + 8) % 16) {
                    let line = slanted.line(cell, dx == dy);
                    slanted.diagonals[quarter].set(cell.y, line, false);
                }
            }
        }
        slanted
    }

    /// The number of a cell's diagonal: of those that fall to the right, or of those that rise.
    const fn line(&self, Cell { x, y }: Cell, falls: bool) -> i32 {
        if falls { x - y + self.height } else { x + y }
    }

    /// Whether a robot may move from a cell on the map in a direction.
    pub(super) fn allows(&self, Cell { x, y }: Cell, direction: usize) -> bool {
        self.allowed[(y * self.width + x) as usize] >> STEPS[direction] & 1 != 0
    }

    /// How far from `cell` the next stop in a diagonal direction is; more than `limit` if farther.
    pub(super) fn scan(&self, cell: Cell, direction: usize, limit: i32) -> i32 {
        let (dx, dy) = RING[direction];
        let (lines, line) = (&self.diagonals[direction / 4], self.line(cell, dx == dy));
        if dy > 0 { lines.after(cell.y, line, limit) } else { lines.before(cell.y, line, limit) }
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.allowed.as_slice()) + self.diagonals.iter().map(Lines::bytes).sum::<usize>()
    }
}
