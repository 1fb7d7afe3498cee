//! Which ways may follow each other on a shortest path.
//!
//! A way that arrives by a move `a` and leaves by a move `b` is no shortest one if what lies before `a`
//! and after `b` can be joined by less than both. With the corner rule it can wherever the turn leaves the
//! quarter that `a` is in, or is sharper than a right angle between straight moves, inside of which
//! something may stand: the cells that the two moves need free are just those of the shorter way.
//! Such a turn need not be searched, whichever of several shortest ways led to it.

use crate::{
    grid::Cell,
    moves::{MoveSet, Step},
};

/// A set of the sixteen directions, one bit each, in turning order from the first axis: every fourth is
/// straight, those in the middle between are diagonals, the others knight's moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Directions(u16);

/// The directions in order.
pub(super) const RING: [Step; 16] = [
    (1, 0),
    (2, 1),
    (1, 1),
    (1, 2),
    (0, 1),
    (-1, 2),
    (-1, 1),
    (-2, 1),
    (-1, 0),
    (-2, -1),
    (-1, -1),
    (-1, -2),
    (0, -1),
    (1, -2),
    (1, -1),
    (2, -1),
];

/// By columns and rows, each 2 more, the direction of a move.
const NUMBERS: [[u8; 5]; 5] = {
    let mut numbers = [[0; 5]; 5];
    let mut number = 0;
    while number < 16 {
        let (dx, dy) = RING[number as usize];
        numbers[(dx + 2) as usize][(dy + 2) as usize] = number;
        number += 1;
    }
    numbers
};

/// The place of a move in [`RING`].
pub(super) const fn number((dx, dy): Step) -> usize {
    NUMBERS[(dx + 2) as usize][(dy + 2) as usize] as usize
}

impl Directions {
    /// Any direction: nothing is known.
    pub(super) const ALL: Self = Self(u16::MAX);

    /// The moves of the shortest ways from one cell to another that it sees.
    pub(super) fn between(moves: MoveSet, from: Cell, to: Cell) -> Self {
        let way = moves.open_way(to.x - from.x, to.y - from.y).into_iter().filter(|&(_, count)| count > 0);
        Self(way.fold(0, |set, (step, _)| set | 1 << number(step)))
    }

    /// The same backwards.
    pub(super) const fn reversed(self) -> Self {
        Self(self.0.rotate_left(8))
    }

    /// By what a shortest path that arrives by any of these directions may go on.
    pub(super) const fn onward(self) -> Self {
        /// After the straight direction 0 those of the half before it, after others of the first quarter that
        /// quarter.
        const AFTER: [u16; 2] = [0b1111_0000_0001_1111, 0b0001_1111];
        let (mut onward, mut arriving) = (u16::MAX, self.0);
        while arriving != 0 {
            let direction = arriving.trailing_zeros();
            let is_slanted = direction % 4 != 0;
            onward &= AFTER[is_slanted as usize].rotate_left(direction / 4 * 4);
            arriving &= arriving - 1;
        }
        Self(onward)
    }

    /// Whether all of these are among `others`.
    pub(super) const fn within(self, others: Self) -> bool {
        self.0 & !others.0 == 0
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;
    use crate::{
        grid::Grid,
        moves::Length,
        search::{AStar, Planner, Workspace},
    };

    const MIDDLE: Cell = Cell { x: 2, y: 2 };

    /// Looks at all pairs of moves through the middle of a map of 5 x 5 cells; tells how many are left out.
    fn left_out(grid: &Grid, moves: MoveSet, workspace: &mut Workspace) -> u32 {
        let steps = moves.steps().iter();
        let pairs = steps.flat_map(|arrive| moves.steps().iter().map(move |leave| (*arrive, *leave)));
        let mut left_out = 0;
        for (arrive, leave) in pairs {
            let (before, after) = (MIDDLE.offset(-arrive.0, -arrive.1), MIDDLE.offset(leave.0, leave.1));
            let onward = Directions::between(moves, before, MIDDLE).onward();
            if !crate::moves::allowed(grid, before, arrive)
                || !crate::moves::allowed(grid, MIDDLE, leave)
                || Directions::between(moves, MIDDLE, after).within(onward)
            {
                continue;
            }
            let through = Length::of(arrive) + Length::of(leave);
            let shortest = AStar::new(grid, moves).plan(before, after, workspace).unwrap().path.length();
            assert!(shortest < through, "{arrive:?} then {leave:?}: {grid:?}");
            left_out += 1;
        }
        left_out
    }

    /// Around one cell every map there is: two moves that a shortest path makes are never left out.
    #[test]
    fn no_two_of_eight_moves_of_a_shortest_path_are_left_out() {
        let mut workspace = Workspace::default();
        let around = (-1..2).flat_map(|dy| (-1..2).map(move |dx| MIDDLE.offset(dx, dy)));
        let maps = (0u32..512).map(|free| {
            let mut grid = Grid::blocked(5, 5).unwrap();
            around.clone().enumerate().for_each(|(bit, cell)| grid.set(cell, free >> bit & 1 != 0));
            grid
        });
        assert!(maps.map(|grid| left_out(&grid, MoveSet::Eight, &mut workspace)).sum::<u32>() > 1000);
    }

    #[test]
    fn no_two_of_sixteen_moves_of_a_shortest_path_are_left_out() {
        let mut random = Pcg64Mcg::seed_from_u64(1);
        let mut workspace = Workspace::default();
        let maps = (0..3000).map(|_| {
            let blocked = random.random_range(0.0..0.4);
            let mut grid = Grid::blocked(5, 5).unwrap();
            (0..25).for_each(|index| grid.set(grid.cell(index), !random.random_bool(blocked)));
            grid
        });
        assert!(maps.map(|grid| left_out(&grid, MoveSet::Sixteen, &mut workspace)).sum::<u32>() > 10_000);
    }
}
