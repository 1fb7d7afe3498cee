//! Builds fields, up to [`LANES`] at a time: a lane each, so that one look from a cell serves them all.
//!
//! (1) Every cell takes the shortest ways over its neighbours until none is shorter; (2) each next move is
//! chosen; (3) its repeats are counted. The first and the last are rules that are swept over the map, with as
//! many distances of a cell side by side as a computer's vectors hold.

use super::{
    metric::Metric,
    repair::allowed_at,
    sweep::{Division, Rule, Sweep},
    table::{Run, TableMut, most_repeats, offsets},
};
use crate::{
    grid::{Cell, Grid},
    moves::MoveSet,
    search::neighbours::Moves,
};

/// The most fields that are built together.
const LANES: usize = 16;

/// A target by its number, and its place if it is not in a wall.
pub(super) type Target = (usize, Option<usize>);

/// Builds the fields of some targets.
pub(super) fn build<M: Metric>(grid: &Grid, targets: &[Target], table: &mut TableMut<'_, M>) {
    match targets.len() {
        0 | 1 => build_in::<M, 1>(grid, targets, table),
        2..=4 => build_in::<M, 4>(grid, targets, table),
        5..=8 => build_in::<M, 8>(grid, targets, table),
        _ => build_in::<M, LANES>(grid, targets, table),
    }
}

fn build_in<M: Metric, const N: usize>(grid: &Grid, targets: &[Target], table: &mut TableMut<'_, M>) {
    let mut lanes = Lanes::<M, N>::new(grid);
    for targets in targets.chunks(N) {
        lanes.build(targets, table);
    }
}

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

/// Fields that are being built.
#[derive(Debug)]
struct Lanes<M: Metric, const N: usize> {
    division: Division,
    /// How far apart the cells are that each move joins.
    offsets: [isize; 16],
    allowed: Vec<Moves>,
    distances: Vec<[M::Distance; N]>,
    runs: Vec<[Run; N]>,
}

impl<M: Metric, const N: usize> Lanes<M, N> {
    fn new(grid: &Grid) -> Self {
        let cells =
            (0..grid.height() as i32).flat_map(|y| (0..grid.width() as i32).map(move |x| Cell { x, y }));
        Self {
            division: Division::of(grid, if M::MOVES == MoveSet::Eight { 1 } else { 2 }),
            offsets: offsets::<M>(grid).map(|offset| offset as isize),
            allowed: cells.map(|cell| allowed_at::<M>(grid, cell)).collect(),
            distances: vec![[M::FAR; N]; grid.len()],
            runs: vec![[0; N]; grid.len()],
        }
    }

    /// Builds the fields of up to `N` targets.
    fn build(&mut self, targets: &[Target], table: &mut TableMut<'_, M>) {
        self.distances.fill([M::FAR; N]);
        let mut sweep = Sweep::new(self.division);
        for (lane, &(_, place)) in targets.iter().enumerate() {
            if let Some(place) = place {
                self.distances[place][lane] = M::HERE;
                sweep.visit_around(place);
            }
        }
        sweep.run(&mut Find(self));
        (0..self.allowed.len()).for_each(|index| self.choose(index));
        sweep.visit_all();
        sweep.run(&mut Count(self));
        for (row, lanes) in table.distances.chunks_exact_mut(table.targets).zip(&self.distances) {
            targets.iter().zip(lanes).for_each(|(&(target, _), &distance)| row[target] = distance);
        }
        for (row, lanes) in table.runs.chunks_exact_mut(table.targets).zip(&self.runs) {
            targets.iter().zip(lanes).for_each(|(&(target, _), &run)| row[target] = run);
        }
    }

    /// The distances where a move leads to.
    #[inline(always)]
    fn beyond(&self, index: usize, number: usize) -> &[M::Distance; N] {
        &self.distances[index.wrapping_add_signed(self.offsets[number])]
    }

    /// Takes the shortest ways over neighbours.
    #[inline(always)]
    fn find<const MOVES: Moves>(&mut self, index: usize) -> bool {
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
    fn choose(&mut self, index: usize) {
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
    fn count<const MOVES: Moves>(&mut self, index: usize) -> bool {
        let before = self.runs[index];
        let mut runs = before;
        let is_move =
            |run: Run, number: usize| (run & low_bits::<M>() == number as Run) & (run > low_bits::<M>());
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

/// No cell has a longer distance than over a neighbour.
struct Find<'a, M: Metric, const N: usize>(&'a mut Lanes<M, N>);

impl<M: Metric, const N: usize> Rule for Find<'_, M, N> {
    const IS_ONE_WAY: bool = false;

    #[inline(always)]
    fn look<const MOVES: Moves>(&mut self, index: usize) -> bool {
        self.0.find::<MOVES>(index)
    }
}

/// Every move repeats once more often than the next, if that is the same.
struct Count<'a, M: Metric, const N: usize>(&'a mut Lanes<M, N>);

impl<M: Metric, const N: usize> Rule for Count<'_, M, N> {
    const IS_ONE_WAY: bool = true;

    #[inline(always)]
    fn look<const MOVES: Moves>(&mut self, index: usize) -> bool {
        self.0.count::<MOVES>(index)
    }
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
