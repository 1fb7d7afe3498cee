//! How far a place is from what is blocked: exact, from the grid's bits, without a table to keep up to date.

use super::motion::Point;
use crate::grid::{Cell, Grid};

/// A map in m.
#[derive(Clone, Copy, Debug)]
pub struct Obstacles<'g> {
    /// The map.
    pub grid: &'g Grid,
    /// The side of a cell, in m; above zero.
    pub cell_m: f64,
}

/// The least step along a line, in m, so that every walk along it ends.
const LEAST_STEP_M: f64 = 1e-3;

impl Obstacles<'_> {
    /// The middle of a cell.
    #[must_use]
    pub fn point(&self, cell: Cell) -> Point {
        Point { x_m: f64::from(cell.x) * self.cell_m, y_m: -f64::from(cell.y) * self.cell_m }
    }

    /// From `point` to the nearest blocked cell or the map's edge, in m, but at most `most_m`; 0 inside of
    /// one. Takes time for the rows within `most_m`, 64 cells at once.
    #[must_use]
    pub fn clearance_m(&self, point: Point, most_m: f64) -> f64 {
        // In cells, with middles at whole numbers.
        let (x, y) = (point.x_m / self.cell_m, -point.y_m / self.cell_m);
        let here = Cell { x: (x + 0.5).floor() as i32, y: (y + 0.5).floor() as i32 };
        if !(x.is_finite() && y.is_finite() && self.grid.is_free(here)) {
            return 0.0;
        }
        let most = most_m / self.cell_m;
        let mut nearest = most * most;
        for (first, step) in [(here.y, 1), (here.y - 1, -1)] {
            let mut row = first;
            loop {
                let down = ((f64::from(row) - y).abs() - 0.5).max(0.0);
                if down * down >= nearest {
                    break;
                }
                let across = self.blocked_in_row(row, here.x, x, nearest);
                nearest = nearest.min(down * down + across * across);
                row += step;
            }
        }
        nearest.sqrt() * self.cell_m
    }

    /// From `x` in the column `column` to the nearest blocked cell of a row, along the row; what is farther
    /// than the root of `enough` may be missed.
    fn blocked_in_row(&self, row: i32, column: i32, x: f64, enough: f64) -> f64 {
        let words = self.grid.row(row);
        let (first, bit) = (column as usize / 64, column as u32 % 64);
        let Some(&word) = words.get(first) else { return 0.0 };
        let to = |blocked: i64| ((blocked as f64 - x).abs() - 0.5).max(0.0);
        let far = |reached: i64| to(reached) * to(reached) > enough;
        let mut right = !word & (u64::MAX << bit);
        let mut at = first;
        while right == 0 && !far(at as i64 * 64 + 63) {
            at += 1;
            right = words.get(at).map_or(1, |word| !word);
        }
        let right =
            if right == 0 { f64::INFINITY } else { to(at as i64 * 64 + i64::from(right.trailing_zeros())) };
        let mut left = !word & (u64::MAX >> (63 - bit));
        let mut at = first;
        while left == 0 && at > 0 && !far(at as i64 * 64) {
            at -= 1;
            left = words.get(at).map_or(1, |word| !word);
        }
        // Left of the first column all is blocked.
        let left = match left {
            0 if at == 0 => to(-1),
            0 => f64::INFINITY,
            _ => to(at as i64 * 64 + 63 - i64::from(left.leading_zeros())),
        };
        left.min(right)
    }

    /// Whether a disc can go straight from `from` to `to`.
    #[must_use]
    pub fn is_clear(&self, from: Point, to: Point, radius_m: f64) -> bool {
        // An end far outside is found out before a walk there.
        if self.clearance_m(to, radius_m) < radius_m {
            return false;
        }
        let way_m = from.distance_m(to);
        let mut gone_m = 0.0;
        loop {
            let share = if way_m > 0.0 { (gone_m / way_m).min(1.0) } else { 1.0 };
            let room_m = self.clearance_m(from.towards(to, share), radius_m + way_m) - radius_m;
            if room_m < 0.0 {
                return false;
            }
            if gone_m >= way_m {
                return true;
            }
            // Nothing is nearer than the room there is.
            gone_m += room_m.max(LEAST_STEP_M);
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn clearance_is_the_distance_to_the_nearest_of_all_blocked_squares(
            (width, height) in (1u32..150, 1u32..12), blocked in prop::collection::vec((0..150i32, 0..12i32), 0..30),
            (x, y) in (0.0..1.0, 0.0..1.0), most in 0.0..90.0,
        ) {
            let mut grid = Grid::blocked(width, height).unwrap();
            (0..grid.len()).for_each(|index| grid.set(grid.cell(index), true));
            blocked.iter().for_each(|&cell| grid.set(cell.into(), false));
            let obstacles = Obstacles { grid: &grid, cell_m: 0.5 };
            let (x, y) = (x * f64::from(width) - 0.5, y * f64::from(height) - 0.5);
            let found = obstacles.clearance_m(Point { x_m: 0.5 * x, y_m: -0.5 * y }, 0.5 * most);
            let edge = [x + 0.5, f64::from(width) - 0.5 - x, y + 0.5, f64::from(height) - 0.5 - y];
            let square = |cell: Cell| {
                let beyond = |at: f64, middle: i32| ((at - f64::from(middle)).abs() - 0.5).max(0.0);
                (beyond(x, cell.x).powi(2) + beyond(y, cell.y).powi(2)).sqrt()
            };
            let cells = (0..grid.len()).map(|index| grid.cell(index)).filter(|&cell| !grid.is_free(cell));
            let expected = cells.map(square).chain(edge).fold(most, f64::min);
            prop_assert!((found - 0.5 * expected).abs() < 1e-9, "{} and {}", found, 0.5 * expected);
        }
    }

    #[test]
    fn what_is_outside_or_no_number_is_blocked() {
        let mut grid = Grid::blocked(3, 3).unwrap();
        (0..grid.len()).for_each(|index| grid.set(grid.cell(index), true));
        let obstacles = Obstacles { grid: &grid, cell_m: 1.0 };
        for far in [f64::NAN, f64::INFINITY, -1e300, 1e300, -0.6, 2.6] {
            assert_eq!(obstacles.clearance_m(Point { x_m: far, y_m: -1.0 }, 5.0), 0.0);
            assert!(!obstacles.is_clear(Point { x_m: 1.0, y_m: -1.0 }, Point { x_m: far, y_m: -1.0 }, 0.1));
        }
    }
}
