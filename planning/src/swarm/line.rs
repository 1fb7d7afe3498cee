//! Straight lines over a grid, under the one corner rule.
//!
//! The digital line between two cells is a row of straight and diagonal moves. Where a robot may make
//! all of them, the true line between the two middles runs through free cells only: a diagonal move's
//! four cells cover what the true line touches there. So one check answers for both.

use crate::{
    grid::{Cell, Grid},
    moves::{self, Step},
};

/// The moves of the digital line from `from` to `to`.
pub(super) fn steps(from: Cell, to: Cell) -> impl Iterator<Item = Step> {
    let (dx, dy) = (i64::from(to.x) - i64::from(from.x), i64::from(to.y) - i64::from(from.y));
    let (long, short) = (dx.abs().max(dy.abs()), dx.abs().min(dy.abs()));
    let sign = (dx.signum() as i32, dy.signum() as i32);
    // How far the line is across after `along` moves, rounded.
    let across = move |along: i64| (2 * along * short + long) / (2 * long);
    (0..long).map(move |along| match across(along + 1) > across(along) {
        true => sign,
        false if dx.abs() > dy.abs() => (sign.0, 0),
        false => (0, sign.1),
    })
}

/// How far a robot at `from` gets straight towards `to`: the last cell of the line before the first
/// obstacle to which a line of its own is open. (That line can round differently.)
pub(super) fn advance(grid: &Grid, from: Cell, to: Cell) -> Cell {
    let reached = open_moves(grid, from, to);
    let cell = |moves| steps(from, to).take(moves).fold(from, |cell, (dx, dy)| cell.offset(dx, dy));
    (0..=reached).rev().map(cell).find(|&stop| is_open(grid, from, stop)).unwrap_or(from)
}

/// Whether nothing is between `from`, where a robot stands, and `to`.
pub(super) fn is_open(grid: &Grid, from: Cell, to: Cell) -> bool {
    open_moves(grid, from, to) == steps(from, to).count()
}

/// How many moves of the line are allowed before the first that is not.
fn open_moves(grid: &Grid, from: Cell, to: Cell) -> usize {
    let mut here = from;
    let open = steps(from, to).take_while(|&step| {
        let open = moves::allowed(grid, here, step);
        here = here.offset(step.0, step.1);
        open
    });
    open.count()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::moves::{Length, MoveSet};

    proptest! {
        #[test]
        fn a_line_arrives_and_is_as_short_as_moves_can_be(from in (0..90, 0..90), to in (0..90, 0..90)) {
            let (from, to): (Cell, Cell) = (from.into(), to.into());
            let end = steps(from, to).fold(from, |cell, (dx, dy)| cell.offset(dx, dy));
            prop_assert_eq!(end, to);
            let length: Length = steps(from, to).map(Length::of).sum();
            prop_assert_eq!(length, MoveSet::Eight.open_length(to.x - from.x, to.y - from.y));
        }

        #[test]
        fn where_the_line_is_open_the_true_line_meets_free_cells_only(
            blocked in prop::collection::vec(0..400usize, 0..40), from in (0..20, 0..20), to in (0..20, 0..20),
        ) {
            let (from, to): (Cell, Cell) = (from.into(), to.into());
            let mut grid = Grid::blocked(20, 20).unwrap();
            (0..400).for_each(|index| grid.set(grid.cell(index), !blocked.contains(&index)));
            prop_assume!(grid.is_free(from) && is_open(&grid, from, to));
            for at in 0..=1000 {
                let along = |from: i32, to: i32| {
                    let value = f64::from(from) + f64::from(to - from) * f64::from(at) / 1000.0;
                    // An edge between two cells belongs to neither.
                    let on_an_edge = (value.fract() - 0.5).abs() < 1e-9;
                    (!on_an_edge).then_some(value.round() as i32)
                };
                let (Some(x), Some(y)) = (along(from.x, to.x), along(from.y, to.y)) else { continue };
                let met = Cell { x, y };
                prop_assert!(grid.is_free(met), "{} is blocked", met);
            }
        }
    }
}
