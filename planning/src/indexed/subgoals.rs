//! The subgoals of a map.
//!
//! A subgoal is a free cell at a convex corner: with either move set a shortest path turns around blocked cells
//! only there, if it goes by the finer moves first wherever that is as short. Two cells see each other when
//! every way between them that is as short as if nothing were blocked is free and no other subgoal is on any;
//! then any two cells are joined by a shortest path that is a chain of cells that see each other, all but its
//! ends subgoals (Uras, Koenig and Hernandez, "Subgoal Graphs for Optimal Pathfinding in Eight-Neighbor Grids",
//! ICAPS 2013, with the corner rule of [`crate::moves`]). What holds for 8 moves holds for 16, too, for where
//! two moves may not change places, the cell between them is at a corner.

use super::{lines::Lines, slanted::Slanted};
use crate::{
    grid::{Cell, Grid},
    moves::MoveSet,
};

/// No subgoal.
const NONE: u32 = u32::MAX;

/// The subgoals of a map, by number, with the bit maps that are scanned for them.
#[derive(Clone, Debug)]
pub(super) struct Subgoals {
    moves: MoveSet,
    width: usize,
    blocked: Lines,
    /// Rows that stop at blocked cells and subgoals.
    rows: Lines,
    /// The same by columns.
    columns: Lines,
    /// With 16 neighbours.
    pub(super) slanted: Option<Slanted>,
    /// By cell, [`NONE`] where none is.
    numbers: Vec<u32>,
    cells: Vec<Cell>,
}

impl Subgoals {
    /// All subgoals of `grid`, numbered so that near ones have near numbers.
    pub(super) fn find(grid: &Grid, moves: MoveSet) -> Self {
        let (width, height) = (grid.width() as usize, grid.height() as usize);
        let mut blocked = Lines::stopped(width, height);
        let mut columns = Lines::stopped(height, width);
        for cell in grid.free_cells() {
            blocked.set(cell.x, cell.y, false);
            columns.set(cell.y, cell.x, false);
        }
        let corner = |cell: Cell, dx: i32, dy: i32| {
            !blocked.stops(cell.x + dx, cell.y)
                && !blocked.stops(cell.x, cell.y + dy)
                && blocked.stops(cell.x + dx, cell.y + dy)
        };
        let at_corner = |cell: &Cell| {
            [(1, 1), (1, -1), (-1, 1), (-1, -1)].into_iter().any(|(dx, dy)| corner(*cell, dx, dy))
        };
        let mut cells: Vec<Cell> = grid.free_cells().filter(at_corner).collect();
        cells.sort_unstable_by_key(|cell| interleave(cell.x) | interleave(cell.y) << 1);
        let mut rows = blocked.clone();
        for cell in &cells {
            rows.set(cell.x, cell.y, true);
            columns.set(cell.y, cell.x, true);
        }
        let slanted = (moves == MoveSet::Sixteen).then(|| Slanted::new(grid, &rows));
        let numbers = vec![NONE; grid.len()];
        let mut found = Self { moves, width, blocked, rows, columns, slanted, numbers, cells };
        found.number();
        found
    }

    fn number(&mut self) {
        for (number, cell) in (0..).zip(&self.cells) {
            self.numbers[cell.y as usize * self.width + cell.x as usize] = number;
        }
    }

    /// Numbers the subgoals anew: `order` says which number each had before.
    pub(super) fn reorder(&mut self, order: &[u32]) {
        self.cells = order.iter().map(|&before| self.cells[before as usize]).collect();
        self.number();
    }

    /// The moves that they are for.
    pub(super) const fn moves(&self) -> MoveSet {
        self.moves
    }

    pub(super) fn cells(&self) -> &[Cell] {
        &self.cells
    }

    pub(super) fn bytes(&self) -> usize {
        let lines = [&self.blocked, &self.rows, &self.columns].map(Lines::bytes);
        lines.iter().sum::<usize>()
            + self.slanted.as_ref().map_or(0, Slanted::bytes)
            + size_of_val(self.numbers.as_slice())
            + size_of_val(self.cells.as_slice())
    }

    /// How far from `cell` the next stop in a direction is that is no finer one; more than `limit` if farther.
    #[inline]
    pub(super) fn scan(&self, cell: Cell, direction: usize, limit: i32) -> i32 {
        match direction {
            0 => self.rows.after(cell.x, cell.y, limit),
            4 => self.columns.after(cell.y, cell.x, limit),
            8 => self.rows.before(cell.x, cell.y, limit),
            12 => self.columns.before(cell.y, cell.x, limit),
            _ => self.slanted.as_ref().map_or(1, |slanted| slanted.scan(cell, direction, limit)),
        }
    }

    /// Whether a cell is blocked or a subgoal.
    pub(super) fn stops(&self, cell: Cell) -> bool {
        self.rows.stops(cell.x, cell.y)
    }

    pub(super) fn is_blocked(&self, cell: Cell) -> bool {
        self.blocked.stops(cell.x, cell.y)
    }

    /// The number of the subgoal at a free or blocked `cell`.
    pub(super) fn number_at(&self, cell: Cell) -> Option<u32> {
        if self.blocked.stops(cell.x, cell.y) {
            return None;
        }
        Some(self.numbers[cell.y as usize * self.width + cell.x as usize])
    }
}

/// The bits of `value`, each followed by a zero.
fn interleave(value: i32) -> u64 {
    (0..16).fold(0, |bits, bit| bits | (value as u64 >> bit & 1) << (2 * bit))
}
