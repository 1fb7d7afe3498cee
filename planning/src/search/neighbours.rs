//! Which moves a cell allows, from the rows of bits around it: 64 cells are looked up as one.
//!
//! The same rule as [`crate::moves::allowed`]: a move's bounding rectangle is a pattern of bits in a
//! window around the cell, and the move is allowed when the whole pattern is free.

use crate::{
    grid::{Cell, Grid},
    moves::{MoveSet, Step},
};

/// Columns and rows of the window around a cell.
const SIDE: i32 = 5;

/// A set of moves: bit `n` for the `n`th of [`MoveSet::steps`].
pub(crate) type Moves = u16;

/// The moves of `moves` that are allowed from `cell`.
#[inline]
pub(crate) fn allowed(grid: &Grid, moves: MoveSet, cell: Cell) -> Moves {
    match moves {
        MoveSet::Eight => eight(grid, cell).into(),
        MoveSet::Sixteen => sixteen(grid, cell),
    }
}

fn eight(grid: &Grid, cell: Cell) -> u8 {
    let row = |dy: i32| bits_from(grid.row(cell.y + dy), cell.x - 1) & 7;
    EIGHT[(row(-1) | row(0) << 3 | row(1) << 6) as usize]
}

fn sixteen(grid: &Grid, cell: Cell) -> Moves {
    let row = |dy: i32| (bits_from(grid.row(cell.y + dy), cell.x - 2) & 31) as u32;
    let window = row(-2) | row(-1) << 5 | row(0) << 10 | row(1) << 15 | row(2) << 20;
    // Without branches, so that all sixteen are compared at once.
    let fits = PATTERNS.map(|pattern| u16::from(window & pattern == pattern));
    fits.iter().rev().fold(0, |moves, fit| moves << 1 | fit)
}

/// The bits of a row from column `x` on, which may lie outside.
#[inline]
fn bits_from(row: &[u64], x: i32) -> u64 {
    let word =
        |index: i32| usize::try_from(index).ok().and_then(|index| row.get(index)).copied().unwrap_or(0);
    let (index, shift) = (x >> 6, x & 63);
    word(index) >> shift | word(index + 1) << 1 << (63 - shift)
}

/// For each of the sixteen moves the cells of its bounding rectangle, in a window of 5 x 5 cells.
const PATTERNS: [u32; 16] = {
    let steps = MoveSet::Sixteen.steps();
    let mut patterns = [0; 16];
    let mut number = 0;
    while number < 16 {
        patterns[number] = rectangle(steps[number], SIDE);
        number += 1;
    }
    patterns
};

/// For each window of 3 x 3 cells the moves of the eight that are allowed in its middle.
const EIGHT: [u8; 512] = {
    let steps = MoveSet::Eight.steps();
    let mut table = [0; 512];
    let mut window = 0;
    while window < 512 {
        let mut number = 0;
        while number < 8 {
            let pattern = rectangle(steps[number], 3);
            if window as u32 & pattern == pattern {
                table[window] |= 1 << number;
            }
            number += 1;
        }
        window += 1;
    }
    table
};

/// The bounding rectangle of a move from the middle of a window of `side` columns.
const fn rectangle((dx, dy): Step, side: i32) -> u32 {
    let middle = side / 2;
    let mut pattern = 0;
    let (mut row, last_row) = if dy < 0 { (dy, 0) } else { (0, dy) };
    while row <= last_row {
        let (mut column, last_column) = if dx < 0 { (dx, 0) } else { (0, dx) };
        while column <= last_column {
            pattern |= 1 << ((row + middle) * side + column + middle);
            column += 1;
        }
        row += 1;
    }
    pattern
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::moves;

    proptest! {
        #[test]
        fn it_is_the_corner_rule(
            width in 1u32..140, height in 1u32..8, blocked in prop::collection::vec(any::<prop::sample::Index>(), 0..80),
        ) {
            let mut grid = Grid::blocked(width, height).unwrap();
            (0..grid.len()).for_each(|index| grid.set(grid.cell(index), true));
            blocked.iter().for_each(|index| grid.set(grid.cell(index.index(grid.len())), false));
            for cell in grid.free_cells() {
                for set in [MoveSet::Eight, MoveSet::Sixteen] {
                    let rule = set.steps().iter().rev();
                    let rule = rule.fold(0, |bits, &step| bits << 1 | Moves::from(moves::allowed(&grid, cell, step)));
                    prop_assert_eq!(allowed(&grid, set, cell), rule, "{:?} at {}", set, cell);
                }
            }
        }
    }
}
