//! Some fields of a map while they are worked on: a lane each, so that one look from a cell serves them all.
//!
//! The tables of all fields are packed; here the distances of a cell are as many as a computer's vectors hold,
//! and what is allowed at a cell is looked up once for all lanes. Only what is worked on is copied.

use std::ops::Range;

use bytemuck::Zeroable;

use super::{
    metric::Metric,
    sweep::{Division, Segments},
    table::{Run, TableMut, most_repeats, offsets},
};
use crate::{
    grid::{Cell, Grid},
    moves::MoveSet,
    search::neighbours::{self, Moves},
};

/// Does something with the number of each of the constant `$moves` that is allowed, from the highest, each
/// compiled for its number. That all are allowed is the rule, and asked first.
macro_rules! each_allowed {
    ($metric:ty, $moves:expr, $allowed:expr, |$number:ident| $with:block) => {
        each_allowed!($metric, $moves, $allowed, $number, $with, 15 14 13 12 11 10 9 8 7 6 5 4 3 2 1 0)
    };
    ($metric:ty, $moves:expr, $allowed:expr, $number:ident, $with:block, $($each:literal)*) => {{
        let moves = $moves & (Moves::MAX >> (16 - <$metric>::MOVES.steps().len()));
        let allowed = $allowed & moves;
        let all = allowed == moves;
        $(
            if moves >> $each & 1 != 0 && (all || allowed >> $each & 1 != 0) {
                let $number: usize = $each;
                $with
            }
        )*
    }};
}

/// Lanes of neighbouring targets.
#[derive(Debug)]
pub(super) struct Lanes<'a, M: Metric, const N: usize> {
    grid: &'a Grid,
    pub division: Division,
    /// What of the tables is here.
    loaded: Segments,
    /// How far apart the cells are that each move joins.
    offsets: [isize; 16],
    allowed: Vec<Moves>,
    pub distances: Vec<[M::Distance; N]>,
    runs: Vec<[Run; N]>,
}

/// How a map is divided for moves of a set.
pub(super) fn division<M: Metric>(grid: &Grid) -> Division {
    Division::of(grid, if M::MOVES == MoveSet::Eight { 1 } else { 2 })
}

impl<'a, M: Metric, const N: usize> Lanes<'a, M, N> {
    /// Fields without any way.
    pub fn blank(grid: &'a Grid) -> Self {
        let mut lanes = Self::over(grid, M::FAR);
        lanes.loaded = lanes.division.all();
        let cells = (0..grid.height() as i32).flat_map(|y| (0..grid.width() as i32).map(move |x| Cell { x, y }));
        for (allowed, cell) in lanes.allowed.iter_mut().zip(cells) {
            *allowed = allowed_at::<M>(grid, cell);
        }
        lanes
    }

    /// Fields of which nothing is loaded yet. What is not touched takes no memory.
    pub fn empty(grid: &'a Grid) -> Self {
        Self::over(grid, M::Distance::zeroed())
    }

    fn over(grid: &'a Grid, distance: M::Distance) -> Self {
        let (division, cells) = (division::<M>(grid), grid.len());
        Self {
            grid,
            division,
            loaded: division.none(),
            offsets: offsets::<M>(grid).map(|offset| offset as isize),
            allowed: vec![0; cells],
            distances: vec![[distance; N]; cells],
            runs: vec![[0; N]; cells],
        }
    }

    /// Loads the segments of a row, of lanes `targets`, and all that moves lead to from there.
    #[inline]
    pub fn load(&mut self, table: &TableMut<'_, M>, targets: &Range<usize>, y: usize, segments: u64) {
        let wide = self.division.widened(segments);
        for row in self.division.rows(y) {
            let missing = wide & !self.loaded[row];
            if missing != 0 {
                self.load_row(table, targets, row, missing);
            }
        }
    }

    #[cold]
    fn load_row(&mut self, table: &TableMut<'_, M>, targets: &Range<usize>, y: usize, segments: u64) {
        self.loaded[y] |= segments;
        for x in super::sweep::each(segments).flat_map(|segment| self.division.columns(segment)) {
            let index = y * self.division.width + x;
            self.allowed[index] = allowed_at::<M>(self.grid, Cell { x: x as i32, y: y as i32 });
            let entries = index * table.targets + targets.start..index * table.targets + targets.end;
            self.distances[index] = [M::FAR; N];
            self.distances[index][..targets.len()].copy_from_slice(&table.distances[entries.clone()]);
            self.runs[index][..targets.len()].copy_from_slice(&table.runs[entries]);
        }
    }

    /// Puts segments back into the tables.
    pub fn store(&self, table: &mut TableMut<'_, M>, targets: &Range<usize>, segments: &Segments) {
        for (y, &segments) in segments.iter().enumerate() {
            for x in super::sweep::each(segments).flat_map(|segment| self.division.columns(segment)) {
                let index = y * self.division.width + x;
                let entries = index * table.targets + targets.start..index * table.targets + targets.end;
                table.distances[entries.clone()].copy_from_slice(&self.distances[index][..targets.len()]);
                table.runs[entries].copy_from_slice(&self.runs[index][..targets.len()]);
            }
        }
    }

    /// The distances where a move leads to.
    #[inline(always)]
    fn beyond(&self, index: usize, number: usize) -> &[M::Distance; N] {
        &self.distances[index.wrapping_add_signed(self.offsets[number])]
    }

    /// Takes the distance from all lanes in which no neighbour leads to it any more. `places` are the
    /// targets' own cells.
    #[inline(always)]
    pub fn lose(&mut self, index: usize, places: &[Option<usize>; N]) -> bool {
        let here = self.distances[index];
        if !differ(&here, &[M::FAR; N]) {
            return false;
        }
        let mut stays = here.map(|distance| distance == M::FAR);
        each_allowed!(M, Moves::MAX, self.allowed[index], |number| {
            let beyond = self.beyond(index, number);
            for lane in 0..N {
                stays[lane] |= M::plus(beyond[lane], number) == here[lane];
            }
        });
        if !differ(&stays, &[true; N]) {
            return false;
        }
        for lane in 0..N {
            stays[lane] |= here[lane] == M::HERE && places[lane] == Some(index);
            if !stays[lane] {
                self.distances[index][lane] = M::FAR;
            }
        }
        differ(&stays, &[true; N])
    }

    /// Takes the shortest ways over neighbours.
    #[inline(always)]
    pub fn find<const MOVES: Moves>(&mut self, index: usize) -> bool {
        let allowed = self.allowed[index];
        if allowed & MOVES == 0 {
            return false;
        }
        let before = self.distances[index];
        let mut best = before;
        each_allowed!(M, MOVES, allowed, |number| {
            let beyond = self.beyond(index, number);
            for lane in 0..N {
                best[lane] = best[lane].min(M::plus(beyond[lane], number));
            }
        });
        self.distances[index] = best;
        differ(&best, &before)
    }

    /// Chooses the next move in all lanes: of those of shortest ways the one with the lowest number.
    #[inline(always)]
    pub fn choose(&mut self, index: usize) {
        let here = self.distances[index];
        let mut runs = [0; N];
        // From the highest, so that the lowest is kept.
        each_allowed!(M, Moves::MAX, self.allowed[index], |number| {
            let beyond = self.beyond(index, number);
            for lane in 0..N {
                let is_way = M::plus(beyond[lane], number) == here[lane];
                runs[lane] = if is_way { single::<M>(number) } else { runs[lane] };
            }
        });
        for lane in 0..N {
            if here[lane] == M::FAR {
                runs[lane] = 0;
            }
        }
        self.runs[index] = runs;
    }

    /// Counts how often the next moves repeat, as the cells know that they lead to.
    #[inline(always)]
    pub fn count<const MOVES: Moves>(&mut self, index: usize) -> bool {
        let before = self.runs[index];
        let mut runs = before;
        let is_move = |run: Run, number: usize| (run & low_bits::<M>() == number as Run) & (run > low_bits::<M>());
        each_allowed!(M, MOVES, self.allowed[index], |number| {
            let beyond = &self.runs[index.wrapping_add_signed(self.offsets[number])];
            let most = number as Run | (most_repeats::<M>() - 1) << M::NUMBER_BITS;
            for lane in 0..N {
                let repeated = beyond[lane].min(most) + (1 << M::NUMBER_BITS);
                let counted = if is_move(beyond[lane], number) { repeated } else { single::<M>(number) };
                runs[lane] = if is_move(before[lane], number) { counted } else { runs[lane] };
            }
        });
        self.runs[index] = runs;
        differ(&runs, &before)
    }
}

/// The moves allowed from a cell; none if it is blocked.
fn allowed_at<M: Metric>(grid: &Grid, cell: Cell) -> Moves {
    if grid.is_free(cell) { neighbours::allowed(grid, M::MOVES, cell) } else { 0 }
}

/// The run of a move that is not repeated.
#[inline]
const fn single<M: Metric>(number: usize) -> Run {
    number as Run | 1 << M::NUMBER_BITS
}

/// Whether any lane differs; in contrast to `!=` all are compared at once.
#[inline(always)]
fn differ<T: PartialEq, const N: usize>(one: &[T; N], other: &[T; N]) -> bool {
    (0..N).fold(false, |differ, lane| differ | (one[lane] != other[lane]))
}

/// The bits of a run that are the number of its move.
const fn low_bits<M: Metric>() -> Run {
    !(Run::MAX << M::NUMBER_BITS)
}
