//! Where a grid lies in the world.

use crate::grid::{Cell, Grid};

/// Where a grid lies in a site's world, x to the right and y UP, in metres: as ROS does it for an
/// occupancy grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// The length of a cell in metres, more than 0.
    pub resolution_m: f64,
    /// The world's coordinates of the outer corner of the grid's lower left cell, in metres.
    pub origin_m: [f64; 2],
    /// How far the grid's rows are turned against the world's x axis, anticlockwise, in radians.
    pub yaw_rad: f64,
    /// The grid's rows, for cells count downwards.
    pub rows: u32,
}

impl Frame {
    /// The world's coordinates of the middle of `cell`, in metres.
    #[must_use]
    pub fn position_m(&self, cell: Cell) -> [f64; 2] {
        let along = (f64::from(cell.x) + 0.5) * self.resolution_m;
        let up = (f64::from(self.rows) - f64::from(cell.y) - 0.5) * self.resolution_m;
        let (sin, cos) = self.yaw_rad.sin_cos();
        [self.origin_m[0] + along * cos - up * sin, self.origin_m[1] + along * sin + up * cos]
    }

    /// The cell that a position of the world is in, perhaps outside the grid.
    #[must_use]
    pub fn cell_at(&self, [x, y]: [f64; 2]) -> Cell {
        let [column, up] = self.units([x, y]);
        // `as` saturates; what is far out is outside the grid.
        let row = (f64::from(self.rows) - 1.0 - up.floor()) as i32;
        Cell { x: column.floor() as i32, y: row }
    }

    /// A position of the world in cells from the grid's lower left corner, to the right and up.
    pub(crate) fn units(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (dx, dy) = (x - self.origin_m[0], y - self.origin_m[1]);
        let (sin, cos) = self.yaw_rad.sin_cos();
        [dx * cos + dy * sin, dy * cos - dx * sin].map(|metres| metres / self.resolution_m)
    }

    /// The free cell of `grid` nearest to a position of the world that is at most `reach_m` away;
    /// of two as near the upper, then the left one.
    #[must_use]
    pub fn free_cell_near(&self, grid: &Grid, at: [f64; 2], reach_m: f64) -> Option<Cell> {
        let middle = self.cell_at(at);
        let reach = (reach_m / self.resolution_m).min(f64::from(u16::MAX)) as i32;
        let mut nearest: Option<(i64, Cell)> = None;
        // Rings of growing radius: the first hit bounds how much further one must look.
        for radius in 0..=reach {
            if nearest.is_some_and(|(found, _)| found <= i64::from(radius) * i64::from(radius)) {
                break;
            }
            for (dx, dy) in ring(radius) {
                let cell = middle.offset(dx, dy);
                let apart = i64::from(dx) * i64::from(dx) + i64::from(dy) * i64::from(dy);
                let nearer = nearest.is_none_or(|(found, _)| apart < found);
                if nearer && apart <= i64::from(reach) * i64::from(reach) && grid.is_free(cell) {
                    nearest = Some((apart, cell));
                }
            }
        }
        nearest.map(|(_, cell)| cell)
    }
}

/// The offsets whose larger coordinate is `radius`, row by row.
fn ring(radius: i32) -> impl Iterator<Item = (i32, i32)> {
    (-radius..=radius).flat_map(move |dy| {
        let step = if dy.abs() == radius { 1 } else { (2 * radius).max(1) as usize };
        (-radius..=radius).step_by(step).map(move |dx| (dx, dy))
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_origin_is_the_outer_corner_of_the_lower_left_cell() {
        let frame = Frame { resolution_m: 0.05, origin_m: [-10.0, 2.0], yaw_rad: 0.0, rows: 4 };
        assert_eq!(frame.cell_at([-10.0, 2.0]), Cell { x: 0, y: 3 });
        assert_eq!(frame.cell_at([-9.96, 2.19]), Cell { x: 0, y: 0 });
        let turned = Frame { yaw_rad: std::f64::consts::FRAC_PI_2, ..frame };
        let [x, y] = turned.position_m(Cell { x: 1, y: 3 });
        assert!((x + 10.025).abs() < 1e-9 && (y - 2.075).abs() < 1e-9, "({x}, {y})");
    }

    #[test]
    fn the_nearest_free_cell_is_found_within_reach_only() {
        let mut grid = Grid::blocked(9, 9).unwrap();
        let frame = Frame { resolution_m: 1.0, origin_m: [0.0; 2], yaw_rad: 0.0, rows: 9 };
        grid.set(Cell { x: 7, y: 7 }, true);
        grid.set(Cell { x: 4, y: 0 }, true);
        assert_eq!(frame.free_cell_near(&grid, [4.5, 4.5], 3.0), None);
        assert_eq!(frame.free_cell_near(&grid, [4.5, 4.5], 9.0), Some(Cell { x: 4, y: 0 }));
        grid.set(Cell { x: 7, y: 5 }, true);
        assert_eq!(frame.free_cell_near(&grid, [4.5, 4.5], 9.0), Some(Cell { x: 7, y: 5 }));
    }

    proptest! {
        #[test]
        fn the_middle_of_a_cell_is_in_that_cell(
            x in -50..50, y in -50..50, rows in 1u32..100, yaw_rad in -4.0..4.0, resolution_m in 0.01..2.0,
        ) {
            let frame = Frame { resolution_m, origin_m: [3.5, -7.25], yaw_rad, rows };
            prop_assert_eq!(frame.cell_at(frame.position_m(Cell { x, y })), Cell { x, y });
        }
    }
}
