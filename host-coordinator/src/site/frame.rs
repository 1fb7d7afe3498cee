//! A site's own coordinates.
//!
//! Inside, a [`Cell`] counts from the upper left corner of the map, y downwards, as maps and
//! pictures do. People who measured a site may count from 1 or upwards.

use planning::grid::{Cell, Grid};

/// How a site counts its cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SiteFrame {
    /// The coordinate of the first column, and of the first row in the direction of y.
    pub origin: i32,
    /// Whether y grows upwards on the map, not downwards.
    pub y_up: bool,
}

/// A coordinate pair that is no cell of the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("({x}, {y}) is outside the map, where x goes from {first} to {} and y from {first} to {}", last.0, last.1)]
pub struct OutsideMap {
    x: i32,
    y: i32,
    first: i32,
    last: (i32, i32),
}

impl SiteFrame {
    /// The cell at site coordinates `(x, y)`.
    ///
    /// In a frame that counts from 1 a coordinate 0 acts as 1: LMPP prints both for the same
    /// cell.
    ///
    /// # Errors
    /// [`OutsideMap`] if `grid` has no such cell.
    pub fn cell_at(self, grid: &Grid, x: i32, y: i32) -> Result<Cell, OutsideMap> {
        self.cell(grid, x, y).ok_or_else(|| {
            let last = |cells: u32| self.origin + cells as i32 - 1;
            OutsideMap { x, y, first: self.origin, last: (last(grid.width()), last(grid.height())) }
        })
    }

    fn cell(self, grid: &Grid, x: i32, y: i32) -> Option<Cell> {
        let index = |coordinate: i32| match (coordinate, self.origin) {
            (0, 1) => Some(0),
            _ => coordinate.checked_sub(self.origin),
        };
        let cell = self.flipped(grid, Cell { x: index(x)?, y: index(y)? });
        grid.index(cell).is_some().then_some(cell)
    }

    /// The site coordinates of `cell`.
    #[must_use]
    pub fn coordinates(self, grid: &Grid, cell: Cell) -> (i32, i32) {
        let Cell { x, y } = self.flipped(grid, cell);
        (x.saturating_add(self.origin), y.saturating_add(self.origin))
    }

    /// `cell` with its row counted from the other side if y grows upwards.
    fn flipped(self, grid: &Grid, cell: Cell) -> Cell {
        // A side has at most 65535 cells.
        let last = grid.height() as i32 - 1;
        if self.y_up { Cell { x: cell.x, y: last.saturating_sub(cell.y) } } else { cell }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_papers_frame_counts_from_1_upwards_and_takes_0_for_1() {
        let grid = Grid::blocked(100, 100).unwrap();
        let frame = SiteFrame { origin: 1, y_up: true };
        assert_eq!(frame.cell(&grid, 1, 100), Some(Cell { x: 0, y: 0 }));
        assert_eq!(frame.cell(&grid, 0, 0), Some(Cell { x: 0, y: 99 }));
        assert_eq!(frame.cell(&grid, 101, 5), None);
        assert_eq!(frame.cell(&grid, 5, -1), None);
        assert_eq!(
            frame.cell_at(&grid, 70, 102).unwrap_err().to_string(),
            "(70, 102) is outside the map, where x goes from 1 to 100 and y from 1 to 100"
        );
    }

    proptest! {
        #[test]
        fn there_and_back_is_the_same_cell(
            (width, height) in (1u32..50, 1u32..50), origin in 0..=1, y_up: bool, index: prop::sample::Index,
        ) {
            let grid = Grid::blocked(width, height).unwrap();
            let (frame, cell) = (SiteFrame { origin, y_up }, grid.cell(index.index(grid.len())));
            let (x, y) = frame.coordinates(&grid, cell);
            prop_assert_eq!(frame.cell(&grid, x, y), Some(cell));
        }

        #[test]
        fn no_coordinate_overflows(x: i32, y: i32, origin in 0..=1, y_up: bool) {
            let grid = Grid::blocked(3, 3).unwrap();
            let frame = SiteFrame { origin, y_up };
            let inside = |coordinate| (origin..origin + 3).contains(&coordinate) || (coordinate, origin) == (0, 1);
            prop_assert_eq!(frame.cell(&grid, x, y).is_some(), inside(x) && inside(y));
            let _ = frame.coordinates(&grid, Cell { x, y });
        }
    }
}
