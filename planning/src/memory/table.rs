//! The tables of all fields of a map: for each cell its distances to all targets, one beside the other,
//! and the moves that come next. What one cell asks of all targets is in one or two cache lines.

use super::metric::Metric;
use crate::{
    grid::{Cell, Grid},
    moves::Length,
    path::Path,
};

/// A byte of the run table: the number of the next move in the low bits, and how often it repeats above
/// them, capped at what fits. 0 where there is no next move: at the target and where no way is known.
pub(super) type Run = u8;

/// The most repeats that a [`Run`] counts.
pub(super) const fn most_repeats<M: Metric>() -> u8 {
    u8::MAX >> M::NUMBER_BITS
}

/// A move and how often it repeats; `None` at the target and where no way is known.
#[inline]
pub(super) fn unpack<M: Metric>(run: Run) -> Option<(usize, u8)> {
    let repeats = run >> M::NUMBER_BITS;
    (repeats != 0).then_some((usize::from(run & !(u8::MAX << M::NUMBER_BITS)), repeats))
}

/// The run of the move of this number, where `next` is the run of the cell that it leads to.
#[inline]
pub(super) fn prepend<M: Metric>(number: usize, next: Run) -> Run {
    let repeats = match unpack::<M>(next) {
        Some((same, repeats)) if same == number => (repeats + 1).min(most_repeats::<M>()),
        _ => 1,
    };
    number as u8 | repeats << M::NUMBER_BITS
}

/// How far apart in the grid's order the cells are that each move joins.
pub(super) fn offsets<M: Metric>(grid: &Grid) -> [i32; 16] {
    let mut offsets = [0; 16];
    for (offset, &(dx, dy)) in offsets.iter_mut().zip(M::MOVES.steps()) {
        *offset = dy * grid.width() as i32 + dx;
    }
    offsets
}

/// The tables, to read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Table<'a, M: Metric> {
    pub distances: &'a [M::Distance],
    pub runs: &'a [Run],
    pub targets: usize,
}

/// The tables, to change.
#[derive(Debug)]
pub(super) struct TableMut<'a, M: Metric> {
    pub distances: &'a mut [M::Distance],
    pub runs: &'a mut [Run],
    pub targets: usize,
}

impl<'a, M: Metric> Table<'a, M> {
    /// The distances of a cell to all targets; none outside the map.
    #[inline]
    pub fn row(&self, grid: &Grid, from: Cell) -> &'a [M::Distance] {
        let row = grid.index(from).and_then(|index| {
            let start = index * self.targets;
            self.distances.get(start..start + self.targets)
        });
        row.unwrap_or_default()
    }

    /// The distance to a target, if there is a way.
    #[inline]
    pub fn distance(&self, grid: &Grid, from: Cell, target: usize) -> Option<M::Distance> {
        self.row(grid, from).get(target).copied().filter(|&distance| distance != M::FAR)
    }

    /// The nearest target and its distance; of equals the first.
    #[inline]
    pub fn nearest(&self, grid: &Grid, from: Cell) -> Option<(usize, Length)> {
        let row = self.row(grid, from);
        let (&first, rest) = row.split_first()?;
        let mut nearest = (0, first);
        for (target, &distance) in (1..).zip(rest) {
            if distance < nearest.1 {
                nearest = (target, distance);
            }
        }
        let (target, distance) = nearest;
        (distance != M::FAR).then(|| (target, M::length(distance)))
    }

    /// Puts the way to a target into `path`; whether there is one.
    #[inline]
    pub fn walk(&self, grid: &Grid, from: Cell, target: usize, path: &mut Path) -> bool {
        let (Some(distance), Some(mut index)) = (self.distance(grid, from, target), grid.index(from)) else {
            return false;
        };
        let width = grid.width() as usize;
        let steps = M::MOVES.steps();
        let waypoints = path.refill(from, M::length(distance));
        let mut here = from;
        let mut before = usize::MAX;
        loop {
            let run = self.runs.get(index.wrapping_mul(self.targets).wrapping_add(target));
            let Some((number, repeats)) = run.and_then(|&run| unpack::<M>(run)) else { break };
            let Some(&(dx, dy)) = steps.get(number) else { break };
            here = here.offset(dx * i32::from(repeats), dy * i32::from(repeats));
            match waypoints.last_mut() {
                // A run was longer than a byte counts.
                Some(last) if number == before => *last = here,
                _ => waypoints.push(here),
            }
            before = number;
            index = (here.y as usize).wrapping_mul(width).wrapping_add(here.x as usize);
        }
        true
    }
}
