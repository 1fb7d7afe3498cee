//! How far cells are from what is blocked, and a map for robots that are more than a point.
//!
//! Distances are Euclidean and exact, from middle to middle of cells, by a linear-time transform:
//! columns first, then the lower envelope of parabolas along each row (Felzenszwalb, Huttenlocher,
//! "Distance Transforms of Sampled Functions", 2012).

use crate::grid::{Cell, Grid};

/// The square of every cell's distance to the nearest blocked cell, in cells, row by row; the
/// outside is blocked. 0 for blocked cells.
#[must_use]
pub fn squared(grid: &Grid) -> Vec<u32> {
    let (width, height) = (grid.width() as usize, grid.height() as usize);
    let mut far = vertical(grid);
    let (mut heights, mut envelope) = (vec![0; width + 2], Vec::new());
    for row in far.chunks_exact_mut(width.max(1)).take(height) {
        // The columns just outside are blocked.
        for (to, from) in heights.iter_mut().skip(1).zip(&*row) {
            *to = i64::from(*from);
        }
        if let Some(last) = heights.last_mut() {
            *last = 0;
        }
        lower_envelope(&heights, &mut envelope);
        read(&heights, &envelope, row);
    }
    far
}

/// The square of every cell's distance to the nearest blocked cell of its column.
fn vertical(grid: &Grid) -> Vec<u32> {
    let mut far = vec![0; grid.len()];
    let width = grid.width() as usize;
    let mut steps = vec![0_u32; width];
    let mut sweep = |rows: &mut dyn Iterator<Item = u32>, keep: fn(u32, u32) -> u32| {
        steps.fill(0);
        for y in rows {
            let row = far.iter_mut().skip(y as usize * width).zip(&mut steps);
            for (x, (cell, steps)) in (0..grid.width()).zip(row) {
                let free = grid.is_free(Cell { x: x as i32, y: y as i32 });
                *steps = if free { *steps + 1 } else { 0 };
                *cell = keep(*cell, *steps * *steps);
            }
        }
    };
    sweep(&mut (0..grid.height()), |_, squared| squared);
    sweep(&mut (0..grid.height()).rev(), u32::min);
    far
}

/// A parabola of the envelope: its column, and the first column where it is the lowest.
type Parabola = (i64, i64);

/// Which of the parabolas `heights[column] + (x - column)^2` is lowest where.
fn lower_envelope(heights: &[i64], envelope: &mut Vec<Parabola>) {
    let at = |column: i64| heights.get(column as usize).copied().unwrap_or(0);
    envelope.clear();
    for column in 0..heights.len() as i64 {
        let start = loop {
            let Some(&(last, start)) = envelope.last() else { break 0 };
            // The first whole x where the new parabola is lower.
            let numerator = at(column) + column * column - at(last) - last * last;
            let lower = numerator.div_euclid(2 * (column - last)) + 1;
            if lower > start {
                break lower;
            }
            envelope.pop();
        };
        if start < heights.len() as i64 {
            envelope.push((column, start));
        }
    }
}

/// The lowest parabola at every column of `row`, which starts one column in.
fn read(heights: &[i64], envelope: &[Parabola], row: &mut [u32]) {
    let mut parabolas = envelope.iter().peekable();
    let mut current = 0;
    for (x, cell) in (1_i64..).zip(row) {
        while let Some(&&(column, _)) = parabolas.peek().filter(|&&&(_, start)| start <= x) {
            current = column;
            parabolas.next();
        }
        let squared = heights.get(current as usize).copied().unwrap_or(0) + (x - current) * (x - current);
        *cell = squared as u32;
    }
}

/// The map for the middle of a round robot of `radius` cells: a cell is blocked if the middle of
/// a blocked cell of `grid` is nearer than `radius` to its own. The outside counts as blocked.
#[must_use]
pub fn inflated(grid: &Grid, radius: f64) -> Grid {
    let mut inflated = grid.clone();
    for (index, far) in squared(grid).into_iter().enumerate() {
        if f64::from(far) < radius * radius {
            inflated.set(grid.cell(index), false);
        }
    }
    inflated
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn squared_by_comparison(grid: &Grid) -> Vec<u32> {
        let (width, height) = (grid.width() as i32, grid.height() as i32);
        let nearest = |cell: Cell| {
            let all = (-1..=height).flat_map(|y| (-1..=width).map(move |x| Cell { x, y }));
            let blocked = all.filter(|&other| !grid.is_free(other));
            blocked.map(|other| (other.x - cell.x).pow(2) + (other.y - cell.y).pow(2)).min()
        };
        (0..grid.len()).map(|index| nearest(grid.cell(index)).unwrap_or(0) as u32).collect()
    }

    #[test]
    fn a_radius_blocks_what_is_nearer_and_nothing_else() {
        let mut grid = Grid::blocked(21, 21).unwrap();
        (0..grid.len()).for_each(|index| grid.set(grid.cell(index), true));
        grid.set(Cell { x: 10, y: 10 }, false);
        let free = |radius, x| inflated(&grid, radius).is_free(Cell { x, y: 10 });
        assert!(free(3.0, 13), "as far as the radius is free");
        assert!(!free(3.01, 13) && !free(3.0, 12));
        assert_eq!(inflated(&grid, 0.0), grid);
    }

    proptest! {
        #[test]
        fn distances_are_those_found_by_comparing_all_cells(
            width in 1u32..20, cells in prop::collection::vec(prop::bool::weighted(0.85), 1..200),
        ) {
            let height = (cells.len() as u32).div_ceil(width);
            let mut grid = Grid::blocked(width, height).unwrap();
            for (index, free) in cells.into_iter().enumerate() {
                grid.set(grid.cell(index), free);
            }
            prop_assert_eq!(squared(&grid), squared_by_comparison(&grid));
        }
    }
}
