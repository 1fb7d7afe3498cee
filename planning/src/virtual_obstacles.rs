//! Virtual obstacles: one robot keeps off another's path (Access eq. 7).
//!
//! A robot that leaves a charging point to one that needs it plans on a map in which the other's
//! shortest path is blocked. The one that arrives has the shortest path, the one that leaves is charged
//! and can afford a detour.

use crate::{
    grid::{Cell, Grid},
    path::Path,
};

/// `grid` with the cells blocked that a robot on `other` needs free, which is the bounding rectangle of
/// each of its moves (the [corner rule](crate::moves)). `from` and `to` stay as they are: the charging
/// point, where one path ends and the other starts, is on both.
///
/// A path from `from` to `to` on the answer shares no other cell with `other` and crosses it nowhere. There may
/// be none, such as from a charging point at the end of a passage one cell wide: then the robot
/// that leaves has to wait for another way, or the other one for it.
#[must_use]
pub fn with_virtual_obstacles(grid: &Grid, other: &Path, from: Cell, to: Cell) -> Grid {
    let mut blocked = grid.clone();
    for (cell, (dx, dy)) in other.cells().zip(other.steps()) {
        let corner = cell.offset(dx.min(0), dy.min(0));
        for row in 0..=dy.abs() {
            for column in 0..=dx.abs() {
                blocked.set(corner.offset(column, row), false);
            }
        }
    }
    for end in [from, to] {
        blocked.set(end, grid.is_free(end));
    }
    blocked
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;
    use crate::{
        moves::{MoveSet, Step},
        search::{AStar, Planner, SearchError, Workspace},
    };

    /// The cells that a move needs free.
    fn box_of(cell: Cell, (dx, dy): Step) -> impl Iterator<Item = Cell> {
        let corner = cell.offset(dx.min(0), dy.min(0));
        (0..=dx.abs()).flat_map(move |x| (0..=dy.abs()).map(move |y| corner.offset(x, y)))
    }

    fn swept(path: &Path) -> BTreeSet<Cell> {
        path.cells().zip(path.steps()).flat_map(|(cell, step)| box_of(cell, step)).collect()
    }

    fn grid(width: u32, bits: &[bool]) -> Grid {
        let mut grid = Grid::blocked(width, bits.len() as u32 / width).unwrap();
        for (index, &free) in bits.iter().enumerate() {
            grid.set(grid.cell(index), free);
        }
        grid
    }

    /// Whether some walk from `from` to `to` needs none of `forbidden` but its ends, found without the
    /// planner.
    fn another_way(grid: &Grid, moves: MoveSet, from: Cell, to: Cell, forbidden: &BTreeSet<Cell>) -> bool {
        let usable =
            |cell: &Cell| grid.is_free(*cell) && (!forbidden.contains(cell) || [from, to].contains(cell));
        let (mut seen, mut open) = (BTreeSet::from([from]), vec![from]);
        while let Some(cell) = open.pop() {
            for &step in moves.steps() {
                let next = cell.offset(step.0, step.1);
                if box_of(cell, step).all(|cell| usable(&cell)) && seen.insert(next) {
                    open.push(next);
                }
            }
        }
        seen.contains(&to)
    }

    proptest! {
        #[test]
        fn a_path_keeps_off_the_other_one_wherever_another_way_exists(
            bits in prop::collection::vec(prop::bool::weighted(0.85), 100),
            ends in prop::array::uniform3(0usize..100),
            moves in prop::sample::select(&[MoveSet::Eight, MoveSet::Sixteen][..]),
        ) {
            let mut grid = grid(10, &bits);
            let [arriving, dock, leaving] = ends.map(|index| grid.cell(index));
            for cell in [arriving, dock, leaving] {
                grid.set(cell, true);
            }
            let mut workspace = Workspace::default();
            let Ok(other) = AStar::new(&grid, moves).plan(arriving, dock, &mut workspace) else { return Ok(()) };
            let other = other.path.clone();
            let open = with_virtual_obstacles(&grid, &other, dock, leaving);
            match AStar::new(&open, moves).plan(dock, leaving, &mut workspace) {
                Ok(found) => {
                    prop_assert!(found.path.is_walkable(&grid, moves));
                    let shared: BTreeSet<_> = swept(found.path).intersection(&swept(&other)).copied().collect();
                    prop_assert!(shared.iter().all(|cell| [dock, leaving].contains(cell)), "{shared:?}");
                }
                Err(SearchError::NoPath { .. }) => {
                    prop_assert!(!another_way(&grid, moves, dock, leaving, &swept(&other)));
                }
                Err(error) => prop_assert!(false, "{error}"),
            }
        }
    }

    #[test]
    fn from_the_end_of_a_passage_one_cell_wide_there_is_no_other_way() {
        let grid = grid(5, &[true; 5]);
        let mut workspace = Workspace::default();
        let (arriving, dock) = ((0, 0).into(), (4, 0).into());
        let search = AStar::new(&grid, MoveSet::Eight);
        let other = search.plan(arriving, dock, &mut workspace).unwrap().path.clone();
        let open = with_virtual_obstacles(&grid, &other, dock, arriving);
        let found = AStar::new(&open, MoveSet::Eight).plan(dock, arriving, &mut workspace);
        assert_eq!(found.map(|plan| plan.expanded), Err(SearchError::NoPath { from: dock, to: arriving }));
    }
}
