//! Which cells of a map are free.

use std::{fmt, ops::Range};

/// A cell by column and row, from 0; x to the right and y DOWN, as in MovingAI's files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cell {
    /// The column.
    pub x: i32,
    /// The row.
    pub y: i32,
}

impl Cell {
    /// The cell `dx` columns and `dy` rows on.
    #[must_use]
    pub const fn offset(self, dx: i32, dy: i32) -> Self {
        Self { x: self.x.saturating_add(dx), y: self.y.saturating_add(dy) }
    }
}

impl From<(i32, i32)> for Cell {
    fn from((x, y): (i32, i32)) -> Self {
        Self { x, y }
    }
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "({}, {})", self.x, self.y)
    }
}

/// The largest width and height of a grid, so that every cell's index fits 32 bits.
pub const MAX_SIDE: u32 = 65_535;

/// A rectangle of cells, each free or blocked; everything outside is blocked. One bit a cell, and every
/// row starts a word, so that a search reads 64 cells at once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Grid {
    width: u32,
    height: u32,
    /// Words a row: enough for one cell more than there are, which is blocked.
    words: usize,
    free: Vec<u64>,
}

/// A grid was asked for that is too large.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a grid of {width} x {height} cells is too large: a side is at most {MAX_SIDE}")]
pub struct TooLarge {
    /// The width asked for.
    pub width: u32,
    /// The height asked for.
    pub height: u32,
}

impl Grid {
    /// A grid with every cell blocked.
    ///
    /// # Errors
    /// [`TooLarge`] if a side is longer than [`MAX_SIDE`].
    pub fn blocked(width: u32, height: u32) -> Result<Self, TooLarge> {
        if width.max(height) > MAX_SIDE {
            return Err(TooLarge { width, height });
        }
        let words = width as usize / 64 + 1;
        Ok(Self { width, height, words, free: vec![0; words * height as usize] })
    }

    /// A grid with every cell free.
    #[must_use]
    pub fn open(width: u16, height: u16) -> Self {
        let words = usize::from(width) / 64 + 1;
        let free = vec![0; words * usize::from(height)];
        let mut grid = Self { width: width.into(), height: height.into(), words, free };
        (0..i32::from(height)).for_each(|y| grid.set_run(y, 0..width.into(), true));
        grid
    }

    /// Columns.
    #[must_use]
    pub const fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    #[must_use]
    pub const fn height(&self) -> u32 {
        self.height
    }

    /// The number of cells.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Whether there are no cells.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// A cell's place in arrays over the grid, row by row; `None` outside.
    #[must_use]
    pub fn index(&self, cell: Cell) -> Option<usize> {
        let (x, y) = (u32::try_from(cell.x).ok()?, u32::try_from(cell.y).ok()?);
        (x < self.width && y < self.height).then(|| y as usize * self.width as usize + x as usize)
    }

    /// The cell at a place in arrays over the grid, the inverse of [`Self::index`].
    #[must_use]
    pub const fn cell(&self, index: usize) -> Cell {
        let width = if self.width == 0 { 1 } else { self.width as usize };
        Cell { x: (index % width) as i32, y: (index / width) as i32 }
    }

    /// Whether a robot can be on `cell`.
    #[must_use]
    pub fn is_free(&self, cell: Cell) -> bool {
        self.bit(cell).is_some_and(|(word, bit)| self.free.get(word).is_some_and(|word| word & bit != 0))
    }

    /// The cells of a row, cell `x` in bit `x % 64` of word `x / 64`, 1 where free. At least one bit
    /// after the last cell is 0, as are all that follow. No words outside the grid.
    #[must_use]
    pub fn row(&self, y: i32) -> &[u64] {
        let Ok(row) = usize::try_from(y) else { return &[] };
        let start = row.saturating_mul(self.words);
        self.free.get(start..start.saturating_add(self.words)).unwrap_or_default()
    }

    /// The word and the bit in it that say whether `cell` is free; `None` outside.
    fn bit(&self, cell: Cell) -> Option<(usize, u64)> {
        let (x, y) = (u32::try_from(cell.x).ok()?, u32::try_from(cell.y).ok()?);
        (x < self.width && y < self.height)
            .then(|| (y as usize * self.words + x as usize / 64, 1 << (x % 64)))
    }

    /// Frees or blocks `cell`; nothing happens outside the grid.
    pub fn set(&mut self, cell: Cell, free: bool) {
        let Some((word, bit)) = self.bit(cell) else { return };
        if let Some(word) = self.free.get_mut(word) {
            *word = if free { *word | bit } else { *word & !bit };
        }
    }

    /// Frees or blocks the cells of `columns` in row `y`, 64 at once; nothing happens outside the grid.
    pub fn set_run(&mut self, y: i32, columns: Range<u32>, free: bool) {
        let (start, end) = (columns.start, columns.end.min(self.width));
        let Ok(row) = usize::try_from(y) else { return };
        let row = row.saturating_mul(self.words);
        let row = self.free.get_mut(row..row.saturating_add(self.words)).unwrap_or_default();
        // How many bits of the word that begins with `first` are before `column`.
        let before = |first: u32, column: u32| column.saturating_sub(first).min(64);
        let lowest = |bits: u32| u64::MAX.checked_shr(64 - bits).unwrap_or(0);
        for (word, first) in row.iter_mut().zip((0..).step_by(64)).skip(start as usize / 64) {
            let mask = lowest(before(first, end)) & !lowest(before(first, start));
            if mask == 0 {
                break;
            }
            *word = if free { *word | mask } else { *word & !mask };
        }
    }

    /// The free cells, row by row.
    pub fn free_cells(&self) -> impl Iterator<Item = Cell> + '_ {
        (0..self.len()).map(|index| self.cell(index)).filter(|&cell| self.is_free(cell))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_run_is_set_as_its_cells_one_by_one(
            width in 1_u32..200, y in -1..3, columns in (0_u32..210, 0_u32..210), free: bool, before: [u64; 8],
        ) {
            let mut grid = Grid::blocked(width, 2).unwrap();
            for index in 0..grid.len() {
                grid.set(grid.cell(index), before[index / 64] >> (index % 64) & 1 == 1);
            }
            let mut expected = grid.clone();
            (columns.0..columns.1).for_each(|x| expected.set(Cell { x: x as i32, y }, free));
            grid.set_run(y, columns.0..columns.1, free);
            prop_assert_eq!(grid, expected);
        }
    }
}
