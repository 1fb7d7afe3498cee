//! Finds the nearest of many cells: a quadtree down to single cells, so that its depth is bounded by the
//! map's side, in whatever order cells come.

use crate::grid::Cell;

/// Cells, each with a number, on a square of `2^levels` cells a side.
#[derive(Clone, Debug, Default)]
pub(super) struct Quadtree {
    levels: u32,
    /// For each quarter the place of its own quarters in this list, or of a single cell its number; each
    /// plus one, and 0 for none.
    quarters: Vec<[u32; 4]>,
}

/// The nearest cell so far.
struct Nearest {
    squared: u64,
    number: u32,
}

/// A quarter that is yet to be looked at: its corner and what is in it.
type Quarter = (u64, Cell, u32);

impl Quadtree {
    /// Forgets all cells, for a map of `side` cells.
    pub(super) fn clear(&mut self, side: u32) {
        self.levels = side.max(2).next_power_of_two().trailing_zeros();
        self.quarters.clear();
        self.quarters.push([0; 4]);
    }

    /// Puts in `cell`, which must be on the map. Answers whether it is new.
    pub(super) fn insert(&mut self, cell: Cell, number: u32) -> bool {
        let mut here = 0;
        for level in (0..self.levels).rev() {
            let which = ((cell.x >> level & 1) | (cell.y >> level & 1) << 1) as usize;
            let new = if level == 0 { number + 1 } else { self.quarters.len() as u32 + 1 };
            let Some(quarter) = self.quarters.get_mut(here).and_then(|quarters| quarters.get_mut(which))
            else {
                return false;
            };
            match (level, *quarter) {
                (0, 0) => *quarter = new,
                (0, _) => return false,
                (_, 0) => {
                    *quarter = new;
                    here = self.quarters.len();
                    self.quarters.push([0; 4]);
                }
                (_, deeper) => here = deeper as usize - 1,
            }
        }
        true
    }

    /// The number of the cell nearest to `to`; `None` if there is none.
    pub(super) fn nearest(&self, to: Cell) -> Option<u32> {
        let mut nearest = Nearest { squared: u64::MAX, number: u32::MAX };
        if let Some(level) = self.levels.checked_sub(1) {
            self.search(0, level, Cell::default(), to, &mut nearest);
        }
        (nearest.squared < u64::MAX).then_some(nearest.number)
    }

    /// Looks at the quarters of `here`, each of `2^level` cells a side, nearest first.
    fn search(&self, here: usize, level: u32, corner: Cell, to: Cell, nearest: &mut Nearest) {
        let Some(quarters) = self.quarters.get(here) else { return };
        let side = 1 << level;
        let mut order: [Quarter; 4] = [(u64::MAX, corner, 0); 4];
        for ((which, &inside), place) in (0..).zip(quarters).zip(&mut order) {
            if inside != 0 {
                let corner = corner.offset((which & 1) * side, (which >> 1) * side);
                *place = (squared_distance(to, corner, side), corner, inside);
            }
        }
        order.sort_unstable_by_key(|&(squared, corner, _)| (squared, corner));
        for (squared, corner, inside) in order {
            if squared >= nearest.squared {
                return;
            } else if level == 0 {
                *nearest = Nearest { squared, number: inside - 1 };
            } else {
                self.search(inside as usize - 1, level - 1, corner, to, nearest);
            }
        }
    }
}

/// From `to` to the nearest cell of a square.
fn squared_distance(to: Cell, corner: Cell, side: i32) -> u64 {
    let beyond = |at: i32, corner: i32| {
        let (at, corner) = (i64::from(at), i64::from(corner));
        (corner - at).max(at - (corner + i64::from(side) - 1)).max(0).unsigned_abs()
    };
    let (dx, dy) = (beyond(to.x, corner.x), beyond(to.y, corner.y));
    dx * dx + dy * dy
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn no_other_cell_is_nearer(
            side in 1u32..70, cells in prop::collection::vec((0..70i32, 0..70i32), 0..60), to in (0..70i32, 0..70i32),
        ) {
            let mut tree = Quadtree::default();
            prop_assert_eq!(tree.nearest(to.into()), None);
            tree.clear(side);
            let on_map = |&(x, y): &(i32, i32)| x < side as i32 && y < side as i32;
            let cells: Vec<Cell> = cells.into_iter().filter(on_map).map(Cell::from).collect();
            for (number, &cell) in (0..).zip(&cells) {
                let known = cells[..number as usize].contains(&cell);
                prop_assert_eq!(tree.insert(cell, number), !known);
            }
            let squared = |cell: Cell| (cell.x - to.0).pow(2) + (cell.y - to.1).pow(2);
            let found = tree.nearest(to.into()).map(|number| squared(cells[number as usize]));
            prop_assert_eq!(found, cells.iter().copied().map(squared).min());
        }
    }
}
