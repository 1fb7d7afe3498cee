//! Which ways may follow each other on a shortest path.
//!
//! A way that arrives by a move `a` and leaves by a move `b` is no shortest one if what lies before `a`
//! and after `b` can be joined by less than both. With the corner rule it can wherever the turn is
//! sharper than 45 degrees, but for a turn of 90 degrees between straight moves, inside of which
//! something may stand: the cells that a diagonal move needs free are just those of the shorter way.
//! Such a turn need not be searched, whichever of several shortest ways led to it.

use crate::grid::Cell;

/// A set of the eight directions, one bit each, in turning order from the first axis; odd bits are
/// diagonals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Directions(u8);

impl Directions {
    /// Any direction: nothing is known.
    pub(super) const ALL: Self = Self(u8::MAX);

    /// The moves of the shortest ways from one cell to another that it sees.
    pub(super) fn between(from: Cell, to: Cell) -> Self {
        let (dx, dy) = (to.x - from.x, to.y - from.y);
        let straight = match (dx.abs() > dy.abs(), dx > 0, dy > 0) {
            (true, true, _) => 0,
            (false, _, true) => 2,
            (true, false, _) => 4,
            (false, _, false) => 6,
        };
        let diagonal = match (dx > 0, dy > 0) {
            (true, true) => 1,
            (false, true) => 3,
            (false, false) => 5,
            (true, false) => 7,
        };
        let straight = if dx.abs() == dy.abs() { 0 } else { 1 << straight };
        let diagonal = if dx == 0 || dy == 0 { 0 } else { 1 << diagonal };
        Self(straight | diagonal)
    }

    /// The same backwards.
    pub(super) const fn reversed(self) -> Self {
        Self(self.0.rotate_left(4))
    }

    /// By what a shortest path that arrives by any of these directions may go on.
    pub(super) const fn onward(self) -> Self {
        Self(ONWARD[self.0 as usize])
    }

    /// Whether all of these are among `others`.
    pub(super) const fn within(self, others: Self) -> bool {
        self.0 & !others.0 == 0
    }
}

/// By set of arriving directions.
const ONWARD: [u8; 256] = {
    /// After the straight direction 0, and after a diagonal one if that were 0.
    const AFTER: [u8; 2] = [0b1100_0111, 0b1000_0011];
    let mut onward = [u8::MAX; 256];
    let mut arriving = 0;
    while arriving < onward.len() {
        let mut direction = 0;
        while direction < 8 {
            if arriving >> direction & 1 != 0 {
                onward[arriving] &= AFTER[direction % 2].rotate_left(direction as u32);
            }
            direction += 1;
        }
        arriving += 1;
    }
    onward
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        grid::Grid,
        moves::{Length, MoveSet},
        search::{AStar, Planner, Workspace},
    };

    /// Around one cell every map there is: two moves that a shortest path makes are never left out.
    #[test]
    fn no_two_moves_of_a_shortest_path_are_left_out() {
        let middle = Cell { x: 1, y: 1 };
        let mut workspace = Workspace::default();
        let mut left_out = 0;
        for blocked in 0u32..512 {
            let mut grid = Grid::blocked(3, 3).unwrap();
            (0..9).for_each(|index| grid.set(grid.cell(index), blocked >> index & 1 == 0));
            for (&arrive, &leave) in MoveSet::Eight
                .steps()
                .iter()
                .flat_map(|arrive| MoveSet::Eight.steps().iter().map(move |leave| (arrive, leave)))
            {
                let (before, after) = (middle.offset(-arrive.0, -arrive.1), middle.offset(leave.0, leave.1));
                let allowed = |from, step| crate::moves::allowed(&grid, from, step);
                if !allowed(before, arrive) || !allowed(middle, leave) {
                    continue;
                }
                let through = Length::of(arrive) + Length::of(leave);
                let shortest = AStar::new(&grid, MoveSet::Eight)
                    .plan(before, after, &mut workspace)
                    .unwrap()
                    .path
                    .length();
                let onward = Directions::between(before, middle).onward();
                if !Directions::between(middle, after).within(onward) {
                    assert!(shortest < through, "{arrive:?} then {leave:?} with {blocked:b} blocked");
                    left_out += 1;
                }
            }
        }
        assert!(left_out > 1000);
    }
}
