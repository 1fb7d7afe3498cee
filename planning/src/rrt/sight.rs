//! Straight lines between cells, under the corner rule.

use crate::{
    grid::{Cell, Grid},
    path::shortcut,
};

/// Whether a point can go straight from the middle of `from` to the middle of `to`: every cell that the
/// segment touches is free, all four where it runs through a corner. For moves to the 8 neighbours that
/// is the corner rule of [`crate::moves`], and between two cells that see each other a path of such moves
/// leads through the touched cells alone, at most as long as columns and rows together.
#[must_use]
pub fn sees(grid: &Grid, from: Cell, to: Cell) -> bool {
    let (dx, dy) = (i64::from(to.x) - i64::from(from.x), i64::from(to.y) - i64::from(from.y));
    // Cells beyond the grid are blocked: the ends say so before a long walk does.
    if !grid.is_free(from) || !grid.is_free(to) {
        return false;
    }
    let (columns, rows) = (dx.abs(), dy.abs());
    let (right, down) = (dx.signum() as i32, dy.signum() as i32);
    let (mut column, mut row, mut here) = (0, 0, from);
    while column < columns || row < rows {
        // Where the segment leaves this cell: of the next vertical and the next horizontal border, the one
        // that comes first, both times 2 * columns * rows along the way.
        let (vertical, horizontal) = ((1 + 2 * column) * rows, (1 + 2 * row) * columns);
        if vertical == horizontal
            && !(grid.is_free(here.offset(right, 0)) && grid.is_free(here.offset(0, down)))
        {
            return false;
        }
        if vertical <= horizontal {
            (here, column) = (here.offset(right, 0), column + 1);
        }
        if horizontal <= vertical {
            (here, row) = (here.offset(0, down), row + 1);
        }
        if !grid.is_free(here) {
            return false;
        }
    }
    true
}

/// Keeps of a path whose neighbours see each other the necessary nodes (Figs. 4, 5): the start, and from each
/// the farthest along the path that it sees. What is left is as free, and never longer.
pub fn keep_necessary_nodes(grid: &Grid, path: &mut Vec<Cell>) {
    shortcut(path, |from, to| sees(grid, from, to));
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::{
        formats::movingai::read_map,
        moves::{self, MoveSet},
    };

    fn open_grid(side: u32) -> Grid {
        let mut grid = Grid::blocked(side, side).unwrap();
        (0..grid.len()).for_each(|index| grid.set(grid.cell(index), true));
        grid
    }

    /// Whether the segment between the middles of two cells touches the closed square of a third: the square
    /// has no corner on the other side, and their boxes meet.
    fn touches(from: Cell, to: Cell, cell: Cell) -> bool {
        let (dx, dy) = (to.x - from.x, to.y - from.y);
        // Twice the corner's offset from the start.
        let side = |right: i32, down: i32| {
            dx * (2 * (cell.y - from.y) + down) - dy * (2 * (cell.x - from.x) + right)
        };
        let sides = [side(-1, -1), side(1, -1), side(-1, 1), side(1, 1)];
        let apart = sides.iter().all(|&side| side > 0) || sides.iter().all(|&side| side < 0);
        let boxed = (from.x.min(to.x)..=from.x.max(to.x)).contains(&cell.x)
            && (from.y.min(to.y)..=from.y.max(to.y)).contains(&cell.y);
        boxed && !apart
    }

    #[test]
    fn a_blocked_cell_hides_just_what_lies_behind_it() {
        let from = Cell { x: 3, y: 3 };
        for to in open_grid(9).free_cells() {
            for blocked in open_grid(9).free_cells() {
                let mut grid = open_grid(9);
                grid.set(blocked, false);
                let hidden = touches(from, to, blocked);
                assert_eq!(sees(&grid, from, to), !hidden, "{from} to {to} with {blocked} blocked");
                assert_eq!(sees(&grid, to, from), !hidden, "{to} to {from} with {blocked} blocked");
            }
        }
    }

    #[test]
    fn neighbours_see_each_other_where_the_corner_rule_allows_a_move() {
        let grid = read_map("type octile\nheight 4\nwidth 5\nmap\n..@..\n.@...\n.....\n@..@.\n").unwrap();
        for from in grid.free_cells() {
            for &(dx, dy) in MoveSet::Eight.steps() {
                assert_eq!(
                    sees(&grid, from, from.offset(dx, dy)),
                    moves::allowed(&grid, from, (dx, dy)),
                    "{from} by ({dx}, {dy})"
                );
            }
        }
    }

    #[test]
    fn nothing_is_seen_outside_however_far() {
        let grid = open_grid(3);
        for far in [i32::MIN, -1, 3, i32::MAX] {
            assert!(!sees(&grid, Cell { x: 1, y: 1 }, Cell { x: far, y: 1 }));
            assert!(!sees(&grid, Cell { x: 1, y: far }, Cell { x: 1, y: 1 }));
        }
    }

    proptest! {
        #[test]
        fn a_zigzag_in_the_open_comes_down_to_its_ends(
            path in prop::collection::vec((0..20i32, 0..20i32), 2..20),
        ) {
            let path: Vec<Cell> = path.into_iter().map(Cell::from).collect();
            let ends = [path[0], path[path.len() - 1]];
            let mut kept = path;
            keep_necessary_nodes(&open_grid(20), &mut kept);
            prop_assert_eq!(kept, ends);
        }
    }
}
