//! What sees what on a map.

use super::{
    subgoals::Subgoals,
    turns::{RING, number},
};
use crate::{
    grid::Cell,
    moves::{Cost, MoveSet, Step},
};

/// By move set, the directions of the finer moves (diagonal of 8, knight's of 16), each after the first of the
/// two others that it is between.
const fn sectors(moves: MoveSet) -> (usize, usize) {
    match moves {
        MoveSet::Eight => (4, 4),
        MoveSet::Sixteen => (8, 2),
    }
}

impl Subgoals {
    /// Tells of every subgoal that the free cell `from` sees, and how far it is.
    ///
    /// Every sector between a finer move and another is a stack of lines by the other that start on a line by
    /// the finer. None reaches farther than the one before it: beyond is a blocked cell or a subgoal.
    pub(super) fn sight(&self, from: Cell, mut see: impl FnMut(u32, Cost)) {
        let moves = self.moves();
        let (count, width) = sectors(moves);
        let mut stop = |end: Cell| {
            if let Some(number) = self.number_at(end) {
                see(number, moves.open_length(end.x - from.x, end.y - from.y).cost());
            }
        };
        let mut limits = [i32::MAX; 8];
        for (sector, limit) in limits[..count].iter_mut().enumerate() {
            self.look(from, sector * width, limit).into_iter().for_each(&mut stop);
        }
        for sector in 0..count {
            let [one, other] = [sector, (sector + 1) % count];
            let [mut to_one, mut to_other] = [limits[one], limits[other]];
            let finer = sector * width + width / 2;
            let (dx, dy) = RING[finer];
            let mut cell = from;
            while self.allows(cell, finer) {
                cell = cell.offset(dx, dy);
                if self.stops(cell) {
                    // It hides what is behind it.
                    stop(cell);
                    break;
                }
                if to_one > 0 {
                    self.look(cell, one * width, &mut to_one).into_iter().for_each(&mut stop);
                }
                if to_other > 0 {
                    self.look(cell, other * width, &mut to_other).into_iter().for_each(&mut stop);
                }
            }
        }
    }

    /// Where a line stops, unless beyond its `limit`, which becomes what is before.
    #[inline]
    fn look(&self, cell: Cell, direction: usize, limit: &mut i32) -> Option<Cell> {
        let distance = self.scan(cell, direction, *limit);
        if distance > *limit {
            return None;
        }
        *limit = distance - 1;
        let (dx, dy) = RING[direction];
        let before = cell.offset(dx * (distance - 1), dy * (distance - 1));
        // A diagonal may not lead to where it stops, though that is free.
        (dx == 0 || dy == 0 || self.allows(before, direction)).then(|| before.offset(dx, dy))
    }

    /// The first of the two moves of a free way from `from` to `to` as long as if nothing were
    /// blocked, the finer one if both are; `None` if neither way is free.
    pub(super) fn direct(&self, from: Cell, to: Cell) -> Option<Turn> {
        let free = |from: Cell, leg: &Leg| {
            let (finer, count) = leg.finer;
            let turn = from.offset(finer.0 * count as i32, finer.1 * count as i32);
            self.run_is_free(from, leg.finer) && self.run_is_free(turn, leg.other)
        };
        if free(from, &Leg::new(self.moves(), from, to)) {
            return Some(Turn::FinerFirst);
        }
        free(to, &Leg::new(self.moves(), to, from)).then_some(Turn::FinerLast)
    }

    fn run_is_free(&self, mut cell: Cell, (step, count): (Step, u32)) -> bool {
        if count == 0 {
            return true;
        }
        let direction = number(step);
        let straight = step.0 == 0 || step.1 == 0;
        let mut left = count as i32;
        while left > 0 {
            let distance = if straight { self.scan(cell, direction, left) } else { 1 };
            if !straight && !self.allows(cell, direction) {
                return false;
            }
            left -= distance;
            cell = cell.offset(step.0 * distance, step.1 * distance);
            // A subgoal is passed, a blocked cell is not.
            if straight && left >= 0 && self.is_blocked(cell) {
                return false;
            }
        }
        true
    }
}

/// Which move of a [`Leg`] comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Turn {
    FinerFirst,
    FinerLast,
}

/// A way with at most one turn, as long as if nothing were blocked: two moves, each with how often.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leg {
    /// Diagonal of 8 moves, knight's of 16.
    pub(super) finer: (Step, u32),
    pub(super) other: (Step, u32),
}

impl Leg {
    pub(super) fn new(moves: MoveSet, from: Cell, to: Cell) -> Self {
        let [finer, other] = moves.open_way(to.x - from.x, to.y - from.y);
        Self { finer, other }
    }
}
