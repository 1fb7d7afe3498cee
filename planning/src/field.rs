//! The way to one known place from everywhere around it.
//!
//! A field keeps a byte a cell: the move that comes next on a shortest way to the field's place. It
//! is built once, by one search from the place, and then answers without any search.

use std::collections::BTreeSet;

use crate::{
    grid::{Cell, Grid},
    moves::{self, Length, MoveSet, Step},
    path::Path,
    search::{Dijkstra, Workspace},
};

/// No way is known from here.
const UNKNOWN: u8 = u8::MAX;
/// The field's place itself.
const HERE: u8 = u8::MAX - 1;

/// Shortest ways to one place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    moves: MoveSet,
    /// For every cell of the grid the number of the next move, [`UNKNOWN`] or [`HERE`].
    next: Vec<u8>,
}

impl Field {
    /// The ways to `place` from all of `around` (and from cells on these ways), without entering
    /// the cells in `closed`. A robot that stands on such a cell is led out.
    #[must_use]
    pub fn build(
        grid: &Grid,
        moves: MoveSet,
        place: Cell,
        around: &[Cell],
        closed: &BTreeSet<Cell>,
        workspace: &mut Workspace,
    ) -> Self {
        let mut field = Self { moves, next: vec![UNKNOWN; grid.len()] };
        let mut open = grid.clone();
        closed.iter().for_each(|&cell| open.set(cell, false));
        let Ok(ways) = Dijkstra::new(&open, moves).ways(place, around, workspace) else { return field };
        let number = |step: Step| moves.steps().iter().position(|&known| known == step);
        for (index, next) in field.next.iter_mut().enumerate() {
            let step = ways.step_back(grid.cell(index)).and_then(number);
            *next = step.and_then(|step| u8::try_from(step).ok()).unwrap_or(*next);
        }
        for &cell in closed {
            let mut freed = open.clone();
            freed.set(cell, true);
            let ways_out =
                (0u8..).zip(moves.steps()).filter(|&(_, &step)| moves::allowed(&freed, cell, step));
            let shortest = ways_out
                .filter_map(|(number, &(dx, dy))| {
                    let rest = ways.length_to(cell.offset(dx, dy))?;
                    Some((rest + Length::of((dx, dy)), number))
                })
                .min();
            if let (Some(index), Some((_, number))) = (grid.index(cell), shortest) {
                field.set(index, number);
            }
        }
        if let Some(index) = grid.index(place).filter(|_| open.is_free(place)) {
            field.set(index, HERE);
        }
        field
    }

    fn set(&mut self, index: usize, next: u8) {
        if let Some(cell) = self.next.get_mut(index) {
            *cell = next;
        }
    }

    /// The moves from `from` to the field's place; `None` if no way is known.
    pub fn steps<'a>(&'a self, grid: &'a Grid, from: Cell) -> Option<impl Iterator<Item = Step> + 'a> {
        let next = |cell: Cell| self.next.get(grid.index(cell)?).copied();
        next(from).filter(|&next| next != UNKNOWN)?;
        let mut here = from;
        Some(std::iter::from_fn(move || {
            let step = *self.moves.steps().get(usize::from(next(here)?))?;
            here = here.offset(step.0, step.1);
            Some(step)
        }))
    }

    /// The length of the shortest way from `from`; `None` if no way is known.
    #[must_use]
    pub fn length(&self, grid: &Grid, from: Cell) -> Option<Length> {
        Some(self.steps(grid, from)?.map(Length::of).sum())
    }

    /// A shortest way from `from`; `None` if no way is known.
    #[must_use]
    pub fn path(&self, grid: &Grid, from: Cell) -> Option<Path> {
        let mut path = Path::at(from);
        self.steps(grid, from)?.for_each(|step| path.step(step));
        Some(path)
    }

    /// What it takes, in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.next.len()
    }
}
