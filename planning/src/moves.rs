//! How a robot steps from cell to cell.
//!
//! **The corner rule**, here and nowhere else: a move is allowed when every cell of its bounding
//! rectangle is free. A diagonal cuts no corner; a knight's move needs its whole 3 x 2 box.

use std::{
    cmp::Ordering,
    iter::Sum,
    ops::{Add, Mul},
};

use crate::grid::{Cell, Grid};

/// Which moves there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MoveSet {
    /// Straight and diagonal, 8 neighbours.
    Eight,
    /// Straight, diagonal and knight's moves, 16 neighbours; what LMPP's printed lengths are made of.
    Sixteen,
}

/// One move by columns and rows.
pub type Step = (i32, i32);

const STEPS: [Step; 16] = [
    (1, 0),
    (-1, 0),
    (0, 1),
    (0, -1),
    (1, 1),
    (1, -1),
    (-1, 1),
    (-1, -1),
    (2, 1),
    (2, -1),
    (-2, 1),
    (-2, -1),
    (1, 2),
    (1, -2),
    (-1, 2),
    (-1, -2),
];

impl MoveSet {
    /// The moves of the set.
    #[must_use]
    pub const fn steps(self) -> &'static [Step] {
        match self {
            Self::Eight => STEPS.split_at(8).0,
            Self::Sixteen => &STEPS,
        }
    }

    /// The length of the shortest way over `dx` columns and `dy` rows where nothing is blocked.
    #[must_use]
    pub fn open_length(self, dx: i32, dy: i32) -> Length {
        let (dx, dy) = (dx.unsigned_abs(), dy.unsigned_abs());
        let (long, short) = (dx.max(dy), dx.min(dy));
        match self {
            Self::Eight => Length { straight: long - short, diagonal: short, knight: 0 },
            // Beyond slope 1/2 knight's moves are mixed with straight ones, below with diagonals.
            Self::Sixteen if long >= 2 * short => {
                Length { straight: long - 2 * short, diagonal: 0, knight: short }
            }
            Self::Sixteen => Length { straight: 0, diagonal: 2 * short - long, knight: long - short },
        }
    }

    /// The moves of that way, each with how often: the finer ones (diagonal of 8, knight's of 16), the others.
    #[inline]
    pub(crate) const fn open_way(self, dx: i32, dy: i32) -> [(Step, u32); 2] {
        let (x, y) = (dx.signum(), dy.signum());
        let (columns, rows) = (dx.unsigned_abs(), dy.unsigned_abs());
        let (along, finer, long, short) = if columns > rows {
            ((x, 0), (2 * x, y), columns, rows)
        } else {
            ((0, y), (x, 2 * y), rows, columns)
        };
        match self {
            Self::Eight => [((x, y), short), (along, long - short)],
            Self::Sixteen if long >= 2 * short => [(finer, short), (along, long - 2 * short)],
            Self::Sixteen => [(finer, long - short), ((x, y), 2 * short - long)],
        }
    }
}

/// Whether a robot may move from `from` by `step`: the corner rule.
#[must_use]
pub fn allowed(grid: &Grid, from: Cell, step: Step) -> bool {
    bounds(from, step).all(|cell| grid.is_free(cell))
}

/// The cells of a move's bounding rectangle.
pub(crate) fn bounds(from: Cell, (dx, dy): Step) -> impl Iterator<Item = Cell> {
    let corner = from.offset(dx.min(0), dy.min(0));
    (0..=dy.abs()).flat_map(move |row| (0..=dx.abs()).map(move |column| corner.offset(column, row)))
}

/// An exact length: how many moves of each kind. Lengths order by [`Self::units`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Length {
    /// Moves of length 1.
    pub straight: u32,
    /// Moves of length sqrt 2.
    pub diagonal: u32,
    /// Moves of length sqrt 5.
    pub knight: u32,
}

/// A length as an integer, for searches: the same on every machine. 1 cell is 2^32, which tells
/// apart every two lengths below a thousand cells.
pub(crate) type Cost = u64;

const SQRT_5: f64 = 2.236_067_977_499_79;

impl Length {
    /// The length of one move.
    #[must_use]
    pub const fn of(step: Step) -> Self {
        match (step.0.abs(), step.1.abs()) {
            (1, 1) => Self { straight: 0, diagonal: 1, knight: 0 },
            (0, _) | (_, 0) => Self { straight: 1, diagonal: 0, knight: 0 },
            _ => Self { straight: 0, diagonal: 0, knight: 1 },
        }
    }

    /// The length in cells.
    #[must_use]
    pub fn units(self) -> f64 {
        f64::from(self.straight)
            + f64::from(self.diagonal) * std::f64::consts::SQRT_2
            + f64::from(self.knight) * SQRT_5
    }

    pub(crate) const fn cost(self) -> Cost {
        // 2^32 times 1, sqrt 2 and sqrt 5, rounded.
        self.straight as Cost * 4_294_967_296
            + self.diagonal as Cost * 6_074_001_000
            + self.knight as Cost * 9_603_838_835
    }
}

impl Ord for Length {
    fn cmp(&self, other: &Self) -> Ordering {
        self.cost().cmp(&other.cost()).then_with(|| {
            (self.straight, self.diagonal, self.knight).cmp(&(other.straight, other.diagonal, other.knight))
        })
    }
}

impl PartialOrd for Length {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Add for Length {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            straight: self.straight + other.straight,
            diagonal: self.diagonal + other.diagonal,
            knight: self.knight + other.knight,
        }
    }
}

impl Mul<u32> for Length {
    type Output = Self;

    fn mul(self, times: u32) -> Self {
        Self { straight: self.straight * times, diagonal: self.diagonal * times, knight: self.knight * times }
    }
}

impl Sum for Length {
    fn sum<I: Iterator<Item = Self>>(lengths: I) -> Self {
        lengths.fold(Self::default(), Add::add)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::search::{Dijkstra, Workspace};

    fn open_grid(width: u32, height: u32) -> Grid {
        let mut grid = Grid::blocked(width, height).unwrap();
        (0..grid.len()).for_each(|index| grid.set(grid.cell(index), true));
        grid
    }

    #[test]
    fn one_blocked_cell_forbids_just_the_moves_whose_box_it_is_in() {
        let from = Cell { x: 2, y: 2 };
        for &(dx, dy) in MoveSet::Sixteen.steps() {
            for blocked in open_grid(5, 5).free_cells() {
                let mut grid = open_grid(5, 5);
                grid.set(blocked, false);
                let (x, y) = (blocked.x - from.x, blocked.y - from.y);
                let in_box = (dx.min(0)..=dx.max(0)).contains(&x) && (dy.min(0)..=dy.max(0)).contains(&y);
                assert_eq!(allowed(&grid, from, (dx, dy)), !in_box, "({dx}, {dy}) with {blocked} blocked");
            }
        }
    }

    #[test]
    fn no_move_leaves_the_grid_wherever_it_starts() {
        let grid = open_grid(3, 3);
        for far in [i32::MIN, -1, 3, i32::MAX] {
            for &step in MoveSet::Sixteen.steps() {
                assert!(
                    !allowed(&grid, Cell { x: far, y: 1 }, step)
                        && !allowed(&grid, Cell { x: 1, y: far }, step)
                );
            }
        }
    }

    #[test]
    fn the_open_length_is_what_a_search_finds() {
        let grid = open_grid(19, 19);
        let from = Cell { x: 9, y: 9 };
        for moves in [MoveSet::Eight, MoveSet::Sixteen] {
            let mut workspace = Workspace::default();
            let ways = Dijkstra::new(&grid, moves).ways(from, &[], &mut workspace).unwrap();
            for cell in grid.free_cells() {
                let open = moves.open_length(cell.x - from.x, cell.y - from.y);
                assert_eq!(ways.length_to(cell), Some(open), "{moves:?} to {cell}");
                let mut path = crate::path::Path::at(from);
                let way = moves.open_way(cell.x - from.x, cell.y - from.y);
                way.into_iter().for_each(|(step, count)| path.run(step, count));
                assert_eq!((path.end(), path.length()), (cell, open), "{moves:?} to {cell}");
            }
        }
    }

    #[test]
    fn lengths_a_hundred_thousandth_apart_are_told_apart() {
        let shorter = Length { straight: 34, diagonal: 6, knight: 0 };
        let longer = Length { straight: 0, diagonal: 0, knight: 19 };
        assert!(longer.units() - shorter.units() < 1.1e-5);
        assert!(shorter < longer);
    }

    proptest! {
        #[test]
        fn lengths_order_as_their_real_values(
            one in (0u32..300, 0u32..300, 0u32..300), other in (0u32..300, 0u32..300, 0u32..300),
        ) {
            let length = |(straight, diagonal, knight)| Length { straight, diagonal, knight };
            let (one, other) = (length(one), length(other));
            // Nearer than that a double does not tell which is longer.
            prop_assume!(one == other || (one.units() - other.units()).abs() > 1e-9);
            prop_assert_eq!(one.cmp(&other), one.units().total_cmp(&other.units()));
        }
    }
}
