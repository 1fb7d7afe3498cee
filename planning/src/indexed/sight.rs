//! What sees what on a map.

use super::{
    slanted::Slanted,
    subgoals::Subgoals,
    turns::{RING, number},
};
use crate::{
    grid::Cell,
    moves::{Cost, MoveSet, Step},
};

impl Subgoals {
    /// Tells of every subgoal that the free cell `from` sees, and how far it is.
    pub(super) fn sight(&self, from: Cell, see: impl FnMut(u32, Cost)) {
        match &self.slanted {
            None => self.look_around::<4>(from, &Eight(self), see),
            Some(slanted) => self.look_around::<8>(from, slanted, see),
        }
    }

    /// Looks into all sectors: between each of the `OTHERS` moves that are not finer (straight of 8, straight
    /// and diagonal of 16) and the next one there is a finer one.
    ///
    /// Every sector between a finer move and another is a stack of lines by the other that start on a line by
    /// the finer. None reaches farther than the one before it: beyond is a blocked cell or a subgoal.
    #[inline]
    fn look_around<const OTHERS: usize>(
        &self,
        from: Cell,
        allowed: &impl Allowed,
        mut see: impl FnMut(u32, Cost),
    ) {
        let moves = if OTHERS == 4 { MoveSet::Eight } else { MoveSet::Sixteen };
        let width = 16 / OTHERS;
        let mut stop = |end: Cell| {
            if let Some(number) = self.number_at(end) {
                see(number, moves.open_length(end.x - from.x, end.y - from.y).cost());
            }
        };
        let mut limits = [i32::MAX; OTHERS];
        for (sector, limit) in limits.iter_mut().enumerate() {
            self.look(from, sector * width, limit, allowed).into_iter().for_each(&mut stop);
        }
        for sector in 0..OTHERS {
            let [one, other] = [sector, (sector + 1) % OTHERS];
            let [mut to_one, mut to_other] = [limits[one], limits[other]];
            let finer = sector * width + width / 2;
            let (dx, dy) = RING[finer];
            let mut cell = from;
            while allowed.allows(cell, finer) {
                cell = cell.offset(dx, dy);
                if self.stops(cell) {
                    // It hides what is behind it.
                    stop(cell);
                    break;
                }
                if to_one > 0 {
                    self.look(cell, one * width, &mut to_one, allowed).into_iter().for_each(&mut stop);
                }
                if to_other > 0 {
                    self.look(cell, other * width, &mut to_other, allowed).into_iter().for_each(&mut stop);
                }
            }
        }
    }

    /// Where a line stops, unless beyond its `limit`, which becomes what is before.
    #[inline]
    fn look(&self, cell: Cell, direction: usize, limit: &mut i32, allowed: &impl Allowed) -> Option<Cell> {
        let distance = self.scan(cell, direction, *limit);
        if distance > *limit {
            return None;
        }
        *limit = distance - 1;
        let (dx, dy) = RING[direction];
        let before = cell.offset(dx * (distance - 1), dy * (distance - 1));
        // A diagonal may not lead to where it stops, though that is free.
        (is_straight(direction) || allowed.allows(before, direction)).then(|| before.offset(dx, dy))
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

    fn run_is_free(&self, cell: Cell, (step, count): (Step, u32)) -> bool {
        if count == 0 {
            return true;
        }
        let direction = number(step);
        if is_straight(direction) {
            return self.straight_run_is_free(cell, direction, count);
        }
        let cells = (0..count as i32).map(|along| cell.offset(step.0 * along, step.1 * along));
        match &self.slanted {
            None => cells.into_iter().all(|cell| Eight(self).allows(cell, direction)),
            Some(slanted) => cells.into_iter().all(|cell| slanted.allows(cell, direction)),
        }
    }

    fn straight_run_is_free(&self, mut cell: Cell, direction: usize, count: u32) -> bool {
        let (dx, dy) = RING[direction];
        let mut left = count as i32;
        while left > 0 {
            let distance = self.scan(cell, direction, left);
            left -= distance;
            cell = cell.offset(dx * distance, dy * distance);
            // A subgoal is passed, a blocked cell is not.
            if left >= 0 && self.is_blocked(cell) {
                return false;
            }
        }
        true
    }
}

const fn is_straight(direction: usize) -> bool {
    direction.is_multiple_of(4)
}

/// Which moves that are not straight a robot may make from a free cell.
trait Allowed {
    fn allows(&self, cell: Cell, direction: usize) -> bool;
}

/// The diagonal ones.
struct Eight<'a>(&'a Subgoals);

impl Allowed for Eight<'_> {
    #[inline]
    fn allows(&self, Cell { x, y }: Cell, direction: usize) -> bool {
        let (dx, dy) = RING[direction];
        let is_blocked = |dx, dy| self.0.is_blocked(Cell { x: x + dx, y: y + dy });
        !(is_blocked(dx, 0) || is_blocked(0, dy) || is_blocked(dx, dy))
    }
}

impl Allowed for Slanted {
    #[inline]
    fn allows(&self, cell: Cell, direction: usize) -> bool {
        self.allows(cell, direction)
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
