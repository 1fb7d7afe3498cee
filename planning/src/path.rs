//! Paths as waypoints, with exact lengths.

use crate::{
    grid::{Cell, Grid},
    moves::{self, Length, MoveSet, Step},
};

/// A path over a grid: its cells where the direction changes, and its length.
///
/// A path has at least one cell. Between two waypoints one move is repeated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Path {
    waypoints: Vec<Cell>,
    length: Length,
}

impl Path {
    /// The path of a robot that stays at `cell`.
    #[must_use]
    pub fn at(cell: Cell) -> Self {
        Self { waypoints: vec![cell], length: Length::default() }
    }

    /// A path that was taken apart by [`Self::waypoints`] and [`Self::length`].
    pub(crate) const fn from_parts(waypoints: Vec<Cell>, length: Length) -> Self {
        Self { waypoints, length }
    }

    /// Starts anew at `cell`, in the same memory.
    pub(crate) fn restart(&mut self, cell: Cell) {
        self.waypoints.clear();
        self.waypoints.push(cell);
        self.length = Length::default();
    }

    /// As [`Self::restart`], for a path of that length whose other waypoints the caller puts in.
    pub(crate) fn refill(&mut self, start: Cell, length: Length) -> &mut Vec<Cell> {
        self.restart(start);
        self.length = length;
        &mut self.waypoints
    }

    /// Goes on by a path of that length with these waypoints; the first is where this one ends.
    #[inline]
    pub(crate) fn append(&mut self, waypoints: &[Cell], length: Length) {
        let [_, rest @ ..] = waypoints else { return };
        if let ([.., before, last], [next, ..]) = (self.waypoints.as_slice(), rest)
            && is_straight_on(*before, *last, *next)
        {
            self.waypoints.pop();
        }
        self.waypoints.extend_from_slice(rest);
        self.length = self.length + length;
    }

    /// Goes on by one move.
    pub fn step(&mut self, step: Step) {
        self.run(step, 1);
    }

    /// Goes on by `count` times the same move.
    pub(crate) fn run(&mut self, step: Step, count: u32) {
        if count == 0 {
            return;
        }
        let next = self.end().offset(step.0 * count as i32, step.1 * count as i32);
        match *self.waypoints.as_slice() {
            [.., before, last] if single_step(before, last) == Some(step) => {
                if let Some(last) = self.waypoints.last_mut() {
                    *last = next;
                }
            }
            _ => self.waypoints.push(next),
        }
        self.length = self.length + Length::of(step) * count;
    }

    /// The last move.
    pub(crate) fn last_step(&self) -> Option<Step> {
        match *self.waypoints.as_slice() {
            [.., before, last] => single_step(before, last),
            _ => None,
        }
    }

    /// Where it starts.
    #[must_use]
    pub fn start(&self) -> Cell {
        self.waypoints.first().copied().unwrap_or_default()
    }

    /// Where it ends.
    #[must_use]
    pub fn end(&self) -> Cell {
        self.waypoints.last().copied().unwrap_or_default()
    }

    /// Start, turns and end.
    #[must_use]
    pub fn waypoints(&self) -> &[Cell] {
        &self.waypoints
    }

    /// How long it is.
    #[must_use]
    pub const fn length(&self) -> Length {
        self.length
    }

    /// Its moves in order.
    pub fn steps(&self) -> impl Iterator<Item = Step> + '_ {
        self.waypoints.iter().zip(self.waypoints.iter().skip(1)).flat_map(|(&from, &to)| {
            let (count, step) = run(from, to);
            std::iter::repeat_n(step, count as usize)
        })
    }

    /// Every cell it stands on in turn.
    pub fn cells(&self) -> impl Iterator<Item = Cell> + '_ {
        let start = self.start();
        std::iter::once(start).chain(self.steps().scan(start, |cell, (dx, dy)| {
            *cell = cell.offset(dx, dy);
            Some(*cell)
        }))
    }

    /// The same way back.
    #[must_use]
    pub fn reversed(mut self) -> Self {
        self.reverse();
        self
    }

    /// Turns the path round.
    pub fn reverse(&mut self) {
        self.waypoints.reverse();
    }

    /// This path, then `next`, which must start where this one ends; `None` if it does not.
    #[must_use]
    pub fn then(mut self, next: &Self) -> Option<Self> {
        if self.end() != next.start() {
            return None;
        }
        for step in next.steps() {
            self.step(step);
        }
        Some(self)
    }

    /// Whether a robot with these moves can go it on `grid`.
    #[must_use]
    pub fn is_walkable(&self, grid: &Grid, moves: MoveSet) -> bool {
        grid.is_free(self.start())
            && self
                .cells()
                .zip(self.steps())
                .all(|(cell, step)| moves.steps().contains(&step) && moves::allowed(grid, cell, step))
    }
}

impl Default for Path {
    /// The path of a robot that stays at the first cell.
    fn default() -> Self {
        Self::at(Cell::default())
    }
}

/// Leaves turns out of a way: after each that is kept comes the farthest along the way that it sees. Turns
/// that follow each other must see each other.
pub(crate) fn shortcut(turns: &mut Vec<Cell>, sees: impl Fn(Cell, Cell) -> bool) {
    let (mut here, mut kept) = (0, 1);
    while let [from, ahead @ ..] = turns.get(here..).unwrap_or_default()
        && !ahead.is_empty()
    {
        here += 1 + ahead.iter().rposition(|&there| sees(*from, there)).unwrap_or_default();
        turns.copy_within(here..=here, kept);
        kept += 1;
    }
    turns.truncate(kept);
}

/// The one move that, repeated, leads from one waypoint to the next, and how often.
const fn run(from: Cell, to: Cell) -> (u32, Step) {
    let (dx, dy) = (to.x - from.x, to.y - from.y);
    let (columns, rows) = (dx.unsigned_abs(), dy.unsigned_abs());
    let (long, short) = if columns > rows { (columns, rows) } else { (rows, columns) };
    let count = if short == 0 { long } else { short };
    if count == 0 { (0, (0, 0)) } else { (count, (dx / count as i32, dy / count as i32)) }
}

/// Whether a robot that comes from `before` to `last` goes on to `next` in the same direction.
const fn is_straight_on(before: Cell, last: Cell, next: Cell) -> bool {
    let (x, y) = ((last.x - before.x) as i64, (last.y - before.y) as i64);
    let (next_x, next_y) = ((next.x - last.x) as i64, (next.y - last.y) as i64);
    x * next_y == y * next_x && x * next_x + y * next_y > 0
}

fn single_step(from: Cell, to: Cell) -> Option<Step> {
    let (count, step) = run(from, to);
    (count > 0).then_some(step)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn steps() -> impl Strategy<Value = Vec<Step>> {
        prop::collection::vec(prop::sample::select(MoveSet::Sixteen.steps()), 0..60)
    }

    fn path(start: Cell, steps: &[Step]) -> Path {
        let mut path = Path::at(start);
        steps.iter().for_each(|&step| path.step(step));
        path
    }

    proptest! {
        #[test]
        fn waypoints_lose_no_step(steps in steps()) {
            let path = path(Cell::default(), &steps);
            prop_assert_eq!(path.steps().collect::<Vec<_>>(), steps.clone());
            prop_assert_eq!(path.length(), steps.iter().copied().map(Length::of).sum());
        }

        #[test]
        fn a_path_cut_anywhere_and_joined_is_the_same(steps in steps(), cut in any::<prop::sample::Index>()) {
            let whole = path(Cell::default(), &steps);
            let (first, second) = steps.split_at(cut.index(steps.len() + 1));
            let first = path(Cell::default(), first);
            let second = path(first.end(), second);
            prop_assert_eq!(first.then(&second), Some(whole));
        }

        #[test]
        fn the_way_back_of_the_way_back_is_the_way(steps in steps()) {
            let path = path(Cell::default(), &steps);
            let back = path.clone().reversed();
            prop_assert_eq!(back.cells().collect::<Vec<_>>(), {
                let mut cells: Vec<_> = path.cells().collect();
                cells.reverse();
                cells
            });
            prop_assert_eq!(back.reversed(), path);
        }
    }
}
