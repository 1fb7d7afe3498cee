//! The subgoals of a map and what sees what.
//!
//! A subgoal is a free cell at a convex corner: a shortest path turns around blocked cells only
//! there. Two cells see each other when every shortest octile way between them is free and no other
//! subgoal is on any; then any shortest path is a chain of cells that see each other, all but its
//! ends subgoals (Uras, Koenig and Hernandez, "Subgoal Graphs for Optimal Pathfinding in
//! Eight-Neighbor Grids", ICAPS 2013, with the corner rule of [`crate::moves`]).

use crate::{
    grid::{Cell, Grid},
    moves::{Cost, MoveSet, Step},
};

/// No subgoal.
const NONE: u32 = u32::MAX;

/// Lines of bits, 1 where a scan stops, with a margin of ones all around.
#[derive(Clone, Debug)]
struct Lines {
    words: usize,
    bits: Vec<u64>,
}

impl Lines {
    fn stopped(length: usize, lines: usize) -> Self {
        let words = (length + 2) / 64 + 1;
        Self { words, bits: vec![u64::MAX; words * (lines + 2)] }
    }

    /// The word with the bit of place `at` of `line`, and the bit's number. Places and lines go from
    /// -1, the margin.
    const fn place(&self, at: i32, line: i32) -> (usize, u32) {
        let bit = (at + 1) as usize;
        ((line + 1) as usize * self.words + bit / 64, (bit % 64) as u32)
    }

    fn set(&mut self, at: i32, line: i32, stop: bool) {
        let (word, bit) = self.place(at, line);
        let mask = 1 << bit;
        self.bits[word] = if stop { self.bits[word] | mask } else { self.bits[word] & !mask };
    }

    fn stops(&self, at: i32, line: i32) -> bool {
        let (word, bit) = self.place(at, line);
        self.bits[word] >> bit & 1 != 0
    }

    /// How far after `at` the next stop is; more than `limit` if it is farther than that.
    fn after(&self, at: i32, line: i32, limit: i32) -> i32 {
        let (mut word, bit) = self.place(at + 1, line);
        let mut bits = self.bits[word] >> bit;
        let mut passed = 1;
        let mut width = 64 - bit as i32;
        while bits == 0 {
            passed += width;
            if passed > limit {
                return passed;
            }
            word += 1;
            width = 64;
            bits = self.bits[word];
        }
        passed + bits.trailing_zeros() as i32
    }

    /// The same before `at`.
    fn before(&self, at: i32, line: i32, limit: i32) -> i32 {
        let (mut word, bit) = self.place(at - 1, line);
        let mut bits = self.bits[word] << (63 - bit);
        let mut passed = 1;
        let mut width = bit as i32 + 1;
        while bits == 0 {
            passed += width;
            if passed > limit {
                return passed;
            }
            word -= 1;
            width = 64;
            bits = self.bits[word];
        }
        passed + bits.leading_zeros() as i32
    }
}

/// The subgoals of a map, by number, with the bit maps that are scanned for them.
#[derive(Clone, Debug)]
pub(super) struct Subgoals {
    width: usize,
    blocked: Lines,
    /// Rows that stop at blocked cells and subgoals.
    rows: Lines,
    /// The same by columns.
    columns: Lines,
    /// By cell, [`NONE`] where none is.
    numbers: Vec<u32>,
    cells: Vec<Cell>,
}

impl Subgoals {
    /// All subgoals of `grid`, numbered so that near ones have near numbers.
    pub(super) fn find(grid: &Grid) -> Self {
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
        let mut found = Self { width, blocked, rows, columns, numbers: vec![NONE; grid.len()], cells };
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

    pub(super) fn cells(&self) -> &[Cell] {
        &self.cells
    }

    pub(super) fn bytes(&self) -> usize {
        let bits = self.blocked.bits.len() + self.rows.bits.len() + self.columns.bits.len();
        8 * bits + size_of_val(self.numbers.as_slice()) + size_of_val(self.cells.as_slice())
    }

    /// How far from `cell` the next stop in a straight direction is; more than `limit` if farther.
    fn scan(&self, cell: Cell, step: Step, limit: i32) -> i32 {
        match step {
            (1, _) => self.rows.after(cell.x, cell.y, limit),
            (-1, _) => self.rows.before(cell.x, cell.y, limit),
            (_, 1) => self.columns.after(cell.y, cell.x, limit),
            _ => self.columns.before(cell.y, cell.x, limit),
        }
    }

    fn diagonal_is_free(&self, Cell { x, y }: Cell, (dx, dy): Step) -> bool {
        !(self.blocked.stops(x + dx, y)
            || self.blocked.stops(x, y + dy)
            || self.blocked.stops(x + dx, y + dy))
    }

    /// The number of the subgoal at a free or blocked `cell`.
    fn number_at(&self, cell: Cell) -> Option<u32> {
        if self.blocked.stops(cell.x, cell.y) {
            return None;
        }
        Some(self.numbers[cell.y as usize * self.width + cell.x as usize])
    }

    /// Tells of every subgoal that the free cell `from` sees, and how far it is.
    ///
    /// Every octant is a stack of lines that start on its diagonal. None reaches farther than the one
    /// before it: beyond is a blocked cell or a subgoal.
    pub(super) fn sight(&self, from: Cell, mut see: impl FnMut(u32, Cost)) {
        let mut stop = |end: Cell| {
            if let Some(number) = self.number_at(end) {
                see(number, MoveSet::Eight.open_length(end.x - from.x, end.y - from.y).cost());
            }
        };
        let mut look = |cell: Cell, step: Step, limit: &mut i32| {
            let distance = self.scan(cell, step, *limit);
            if distance <= *limit {
                *limit = distance - 1;
                stop(cell.offset(step.0 * distance, step.1 * distance));
            }
        };
        let mut straight = [i32::MAX; 4];
        for (limit, step) in straight.iter_mut().zip([(1, 0), (-1, 0), (0, 1), (0, -1)]) {
            look(from, step, limit);
        }
        let [right, left, down, up] = straight;
        let corners = [(1, 1, right, down), (1, -1, right, up), (-1, 1, left, down), (-1, -1, left, up)];
        for (dx, dy, mut columns, mut rows) in corners {
            let mut cell = from;
            while self.diagonal_is_free(cell, (dx, dy)) {
                cell = cell.offset(dx, dy);
                if self.rows.stops(cell.x, cell.y) {
                    // A line of no length that ends at a subgoal, which hides what is behind it.
                    look(cell.offset(-dx, 0), (dx, 0), &mut 1);
                    break;
                }
                if columns > 0 {
                    look(cell, (dx, 0), &mut columns);
                }
                if rows > 0 {
                    look(cell, (0, dy), &mut rows);
                }
            }
        }
    }

    /// The first of the two moves of a free way from `from` to `to` as long as if nothing were
    /// blocked, diagonal first or straight first; `None` if neither way is free.
    pub(super) fn direct(&self, from: Cell, to: Cell) -> Option<Turn> {
        let leg = Leg::new(from, to);
        let back = Leg::new(to, from);
        let free = |from: Cell, leg: &Leg| {
            self.diagonal_run_is_free(from, leg.diagonal, leg.diagonals)
                && self.straight_run_is_free(leg.turn(from), leg.straight, leg.straights)
        };
        if free(from, &leg) {
            return Some(Turn::DiagonalFirst);
        }
        free(to, &back).then_some(Turn::StraightFirst)
    }

    fn diagonal_run_is_free(&self, mut cell: Cell, step: Step, count: u32) -> bool {
        (0..count).all(|_| {
            let free = self.diagonal_is_free(cell, step);
            cell = cell.offset(step.0, step.1);
            free
        })
    }

    fn straight_run_is_free(&self, mut cell: Cell, step: Step, count: u32) -> bool {
        let mut left = count as i32;
        while left > 0 {
            let distance = self.scan(cell, step, left);
            left -= distance;
            cell = cell.offset(step.0 * distance, step.1 * distance);
            // A subgoal is passed, a blocked cell is not.
            if left >= 0 && self.blocked.stops(cell.x, cell.y) {
                return false;
            }
        }
        true
    }
}

/// Which move of a [`Leg`] comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Turn {
    DiagonalFirst,
    StraightFirst,
}

/// A way with at most one turn, as long as if nothing were blocked.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leg {
    pub(super) straight: Step,
    pub(super) straights: u32,
    pub(super) diagonal: Step,
    pub(super) diagonals: u32,
}

impl Leg {
    pub(super) fn new(from: Cell, to: Cell) -> Self {
        let (dx, dy) = (to.x - from.x, to.y - from.y);
        let (columns, rows) = (dx.unsigned_abs(), dy.unsigned_abs());
        let diagonal = (dx.signum(), dy.signum());
        let straight = if columns > rows { (diagonal.0, 0) } else { (0, diagonal.1) };
        let diagonals = columns.min(rows);
        Self { straight, straights: columns.max(rows) - diagonals, diagonal, diagonals }
    }

    /// Where it turns if it starts diagonally at `from`.
    const fn turn(&self, from: Cell) -> Cell {
        from.offset(self.diagonal.0 * self.diagonals as i32, self.diagonal.1 * self.diagonals as i32)
    }
}

/// The bits of `value`, each followed by a zero.
fn interleave(value: i32) -> u64 {
    (0..16).fold(0, |bits, bit| bits | (value as u64 >> bit & 1) << (2 * bit))
}
