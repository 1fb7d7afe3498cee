//! Repairs fields where cells are blocked or freed, so that they are as if they had been built anew.
//!
//! Field by field: (1) a cell without a neighbour that its distance is owed to any more loses it, and so
//! in turn do the cells that owed theirs to it; (2) a search from the edge of what was lost and from the
//! moves that are new gives distances again; (3) around what changed, moves and runs are chosen again.
//! Cells far from all that are not looked at.

use super::{
    frontier::Frontier,
    metric::Metric,
    table::{Run, TableMut, offsets, prepend, unpack},
};
use crate::{
    grid::{Cell, Grid},
    moves::MoveSet,
    search::neighbours::{self, Moves},
};

/// Of all cells of the map the part that a repair may take out of the queues before building the field
/// anew is taken to be cheaper: a repaired cell costs several times a built one.
const WORTHWHILE: usize = 8;

/// A cell near a change, and its moves before and after.
#[derive(Clone, Copy, Debug)]
struct Near {
    index: usize,
    before: Moves,
    after: Moves,
}

/// A repair of the fields of a map.
#[derive(Debug)]
pub(super) struct Repair<'a, M: Metric> {
    grid: &'a Grid,
    near: Vec<Near>,
    offsets: [i32; 16],
    /// The moves that are allowed from the cells that some field was looked at; none where not.
    allowed: Vec<Moves>,
    frontier: Frontier<M>,
    starts: Vec<(M::Distance, u32)>,
    /// Cells that lost their distance, then cells that were given another, by rising distance.
    changed: Vec<usize>,
    /// Cells whose run may be wrong.
    stale: Vec<usize>,
    /// Cells that may still be taken out of the queues.
    work: usize,
}

/// One field among all in the tables.
pub(super) struct Column<'a, 't, M: Metric> {
    pub table: &'a mut TableMut<'t, M>,
    pub target: usize,
}

impl<M: Metric> Column<'_, '_, M> {
    /// Where the cell's entry is: outside the tables if the cell is outside the map, before its first too.
    #[inline]
    fn entry(&self, index: usize) -> usize {
        index.wrapping_mul(self.table.targets).wrapping_add(self.target)
    }

    /// The distance of a cell; [`Metric::FAR`] outside.
    #[inline]
    fn distance(&self, index: usize) -> M::Distance {
        self.table.distances.get(self.entry(index)).copied().unwrap_or(M::FAR)
    }

    #[inline]
    fn set_distance(&mut self, index: usize, distance: M::Distance) {
        let entry = self.entry(index);
        self.table.distances[entry] = distance;
    }

    #[inline]
    fn run(&self, index: usize) -> Run {
        self.table.runs.get(self.entry(index)).copied().unwrap_or(0)
    }

    #[inline]
    fn set_run(&mut self, index: usize, run: Run) {
        let entry = self.entry(index);
        self.table.runs[entry] = run;
    }
}

/// The places of a cell's neighbours by these moves.
#[inline]
fn neighbours_by(offsets: [i32; 16], index: usize, mut moves: Moves) -> impl Iterator<Item = (usize, usize)> {
    std::iter::from_fn(move || {
        if moves == 0 {
            return None;
        }
        let number = moves.trailing_zeros() as usize;
        moves &= moves - 1;
        Some((number, index.wrapping_add_signed(offsets[number & 15] as isize)))
    })
}

impl<'a, M: Metric> Repair<'a, M> {
    /// Prepares to repair the fields of `grid`, which was `before`, where the cells in `changed` are
    /// different.
    pub fn new(before: &Grid, grid: &'a Grid, changed: &[Cell]) -> Self {
        let reach = if M::MOVES == MoveSet::Eight { 1 } else { 2 };
        let around = |&cell: &Cell| {
            (-reach..=reach).flat_map(move |dy| (-reach..=reach).map(move |dx| cell.offset(dx, dy)))
        };
        let mut near: Vec<_> = changed.iter().flat_map(around).filter_map(|cell| grid.index(cell)).collect();
        near.sort_unstable();
        near.dedup();
        let near = near.into_iter().map(|index| {
            let cell = grid.cell(index);
            Near { index, before: allowed_at::<M>(before, cell), after: allowed_at::<M>(grid, cell) }
        });
        Self {
            grid,
            near: near.collect(),
            offsets: offsets::<M>(grid),
            allowed: vec![0; grid.len()],
            frontier: Frontier::default(),
            starts: Vec::new(),
            changed: Vec::new(),
            stale: Vec::new(),
            work: 0,
        }
    }

    /// The moves that are allowed from a cell; all fields ask for the same ones.
    #[inline]
    fn allowed(&mut self, index: usize) -> Moves {
        let known = &mut self.allowed[index];
        if *known == 0 {
            *known = allowed_at::<M>(self.grid, self.grid.cell(index));
        }
        *known
    }

    /// Repairs the field of the target in `place`. Returns whether that was worth its while; if not, the
    /// field is as good as lost and has to be built.
    pub fn field(&mut self, place: Option<usize>, column: &mut Column<'_, '_, M>) -> bool {
        self.work = self.grid.len() / WORTHWHILE;
        if self.lose(place, column).is_none() || self.find(place, column).is_none() {
            return false;
        }
        self.choose_moves(column);
        self.count_runs(column);
        true
    }

    /// Counts one more cell of work; `None` once it is too much.
    fn work(&mut self) -> Option<()> {
        self.work = self.work.checked_sub(1)?;
        Some(())
    }

    /// Step 1: takes the distance from all cells that do not have it any more.
    fn lose(&mut self, place: Option<usize>, column: &mut Column<'_, '_, M>) -> Option<()> {
        self.changed.clear();
        self.starts.clear();
        for near in self.near.iter().filter(|near| near.before & !near.after != 0 || near.after == 0) {
            let distance = column.distance(near.index);
            if distance != M::FAR {
                self.starts.push((distance, near.index as u32));
            }
        }
        self.frontier.start(&mut self.starts);
        while let Some((distance, index)) = self.frontier.pop() {
            let index = index as usize;
            if column.distance(index) != distance {
                continue;
            }
            self.work()?;
            let stays = match distance == M::HERE {
                true => place == Some(index),
                false => neighbours_by(self.offsets, index, self.allowed(index))
                    .any(|(number, next)| M::plus(column.distance(next), number) == distance),
            };
            if stays {
                continue;
            }
            column.set_distance(index, M::FAR);
            self.changed.push(index);
            for (number, next) in neighbours_by(self.offsets, index, all_moves::<M>()) {
                let further = M::plus(distance, number);
                if column.distance(next) == further {
                    self.frontier.push(number, further, next as u32);
                }
            }
        }
        Some(())
    }

    /// Step 2: gives distances again.
    fn find(&mut self, place: Option<usize>, column: &mut Column<'_, '_, M>) -> Option<()> {
        self.starts.clear();
        if let Some(place) = place.filter(|&place| column.distance(place) != M::HERE) {
            column.set_distance(place, M::HERE);
            self.starts.push((M::HERE, place as u32));
        }
        let gained = self.near.iter().filter(|near| near.after & !near.before != 0).map(|near| near.index);
        let mut lost: Vec<_> = self.changed.iter().copied().chain(gained).collect();
        for index in lost.drain(..) {
            let ways = neighbours_by(self.offsets, index, self.allowed(index));
            let best = ways.map(|(number, next)| M::plus(column.distance(next), number)).min();
            if let Some(best) = best.filter(|&best| best < column.distance(index)) {
                column.set_distance(index, best);
                self.starts.push((best, index as u32));
            }
        }
        self.frontier.start(&mut self.starts);
        while let Some((distance, index)) = self.frontier.pop() {
            let index = index as usize;
            if column.distance(index) != distance {
                continue;
            }
            self.work()?;
            self.changed.push(index);
            for (number, next) in neighbours_by(self.offsets, index, self.allowed(index)) {
                let further = M::plus(distance, number);
                if further < column.distance(next) {
                    column.set_distance(next, further);
                    self.frontier.push(number, further, next as u32);
                }
            }
        }
        Some(())
    }

    /// Step 3: chooses the next move of every cell whose distance, neighbours or moves have changed.
    fn choose_moves(&mut self, column: &mut Column<'_, '_, M>) {
        self.stale.clear();
        for near in 0..self.near.len() {
            self.choose_move(self.near[near].index, column);
        }
        for place in 0..self.changed.len() {
            let index = self.changed[place];
            self.choose_move(index, column);
            let distance = column.distance(index);
            for (number, next) in neighbours_by(self.offsets, index, self.allowed(index)) {
                let back = REVERSE[number & 15];
                let now = unpack::<M>(column.run(next)).map_or(usize::MAX, |(number, _)| number);
                // Its move led here, or might better do so.
                if now == back || back < now && M::plus(distance, number) == column.distance(next) {
                    self.choose_move(next, column);
                }
            }
        }
    }

    fn choose_move(&mut self, index: usize, column: &mut Column<'_, '_, M>) {
        let distance = column.distance(index);
        let before = unpack::<M>(column.run(index)).map(|(number, _)| number);
        let after = if distance == M::FAR || distance == M::HERE {
            None
        } else {
            neighbours_by(self.offsets, index, self.allowed(index))
                .find(|&(number, next)| M::plus(column.distance(next), number) == distance)
                .map(|(number, _)| number)
        };
        if before == after {
            return;
        }
        column.set_run(index, after.map_or(0, |number| prepend::<M>(number, 0)));
        self.stale.push(index);
        // The cell before on the same run as it was.
        self.stale.extend(before.and_then(|number| self.cell_before(number, index, column)));
    }

    /// The cell whose next move is this one and leads to `index`.
    fn cell_before(&self, number: usize, index: usize, column: &Column<'_, '_, M>) -> Option<usize> {
        let before = index.wrapping_add_signed(-self.offsets[number & 15] as isize);
        unpack::<M>(column.run(before)).filter(|&(same, _)| same == number).map(|_| before)
    }

    /// Step 3, its other half: counts the repeats of moves again, against the way.
    fn count_runs(&mut self, column: &mut Column<'_, '_, M>) {
        for place in 0..self.stale.len() {
            let start = self.stale[place];
            let mut index = start;
            while let Some((number, _)) = unpack::<M>(column.run(index)) {
                let next = index.wrapping_add_signed(self.offsets[number & 15] as isize);
                let run = prepend::<M>(number, column.run(next));
                if run == column.run(index) && index != start {
                    break;
                }
                column.set_run(index, run);
                let Some(before) = self.cell_before(number, index, column) else { break };
                index = before;
            }
        }
    }
}

/// For each move the one that leads back.
const REVERSE: [usize; 16] = {
    let steps = MoveSet::Sixteen.steps();
    let mut reverse = [0; 16];
    let mut number = 0;
    while number < 16 {
        let mut back = 0;
        while steps[back].0 != -steps[number].0 || steps[back].1 != -steps[number].1 {
            back += 1;
        }
        reverse[number] = back;
        number += 1;
    }
    reverse
};

/// The moves allowed from a cell; none if it is blocked.
pub(super) fn allowed_at<M: Metric>(grid: &Grid, cell: Cell) -> Moves {
    if grid.is_free(cell) { neighbours::allowed(grid, M::MOVES, cell) } else { 0 }
}

fn all_moves<M: Metric>() -> Moves {
    Moves::MAX >> (16 - M::MOVES.steps().len())
}
