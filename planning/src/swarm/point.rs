//! A place between cells.

use crate::grid::{Cell, Grid};

/// A node of a path as the swarm moves it, in cells: a cell's middle is at its whole numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Point {
    pub x: f64,
    pub y: f64,
}

impl From<Cell> for Point {
    fn from(cell: Cell) -> Self {
        Self { x: f64::from(cell.x), y: f64::from(cell.y) }
    }
}

impl Point {
    /// A square root is the same on every machine, unlike other functions of `f64`.
    pub fn distance(self, other: Self) -> f64 {
        let (dx, dy) = (self.x - other.x, self.y - other.y);
        (dx * dx + dy * dy).sqrt()
    }

    /// The point `share` of the way from here to `other`.
    pub fn towards(self, other: Self, share: f64) -> Self {
        Self { x: self.x + (other.x - self.x) * share, y: self.y + (other.y - self.y) * share }
    }

    /// The same, moved onto the grid if it is beside it.
    pub fn clamped(self, grid: &Grid) -> Self {
        let clamp = |value: f64, side: u32| value.max(0.0).min(f64::from(side.saturating_sub(1)));
        Self { x: clamp(self.x, grid.width()), y: clamp(self.y, grid.height()) }
    }

    /// The cell it is in.
    pub fn cell(self) -> Cell {
        Cell { x: self.x.round() as i32, y: self.y.round() as i32 }
    }
}
