//! Builds fields: one search from each target over the whole map.

use super::{
    frontier::Frontier,
    metric::Metric,
    table::{Run, offsets, prepend},
};
use crate::{
    grid::{Cell, Grid},
    search::neighbours::{self, Moves},
};

/// Fields that are built together before they are put into the tables: as many distances as fill a cache
/// line.
const TOGETHER: usize = 16;

/// The memory of searches, as large as the map.
#[derive(Debug)]
pub(super) struct Builder<M: Metric> {
    /// The moves that are allowed from each cell.
    allowed: Vec<Moves>,
    offsets: [i32; 16],
    /// By which moves each cell was reached, all equally short.
    arrivals: Vec<Moves>,
    frontier: Frontier<M>,
}

/// One field by itself.
#[derive(Clone, Debug)]
struct Field<M: Metric> {
    distances: Vec<M::Distance>,
    runs: Vec<Run>,
}

impl<M: Metric> Builder<M> {
    pub fn new(grid: &Grid) -> Self {
        let mut allowed = vec![0; grid.len()];
        let mut index = 0;
        for y in 0..grid.height() as i32 {
            for x in 0..grid.width() as i32 {
                let cell = Cell { x, y };
                if grid.is_free(cell) {
                    allowed[index] = neighbours::allowed(grid, M::MOVES, cell);
                }
                index += 1;
            }
        }
        let arrivals = vec![0; grid.len()];
        Self { allowed, offsets: offsets::<M>(grid), arrivals, frontier: Frontier::default() }
    }

    /// Builds fields into the tables of `of` targets: the number of each target, and its place if it is
    /// not in a wall.
    pub fn build_all(
        &mut self,
        targets: &[(usize, Option<usize>)],
        of: usize,
        distances: &mut [M::Distance],
        runs: &mut [Run],
    ) {
        let cells = self.allowed.len();
        let empty = Field::<M> { distances: vec![M::FAR; cells], runs: vec![0; cells] };
        let mut fields = vec![empty; targets.len().min(TOGETHER)];
        for targets in targets.chunks(TOGETHER) {
            for (field, &(_, place)) in fields.iter_mut().zip(targets) {
                self.build(place, field);
            }
            for (cell, row) in distances.chunks_exact_mut(of).enumerate() {
                for (field, &(number, _)) in fields.iter().zip(targets) {
                    row[number] = field.distances[cell];
                }
            }
            for (cell, row) in runs.chunks_exact_mut(of).enumerate() {
                for (field, &(number, _)) in fields.iter().zip(targets) {
                    row[number] = field.runs[cell];
                }
            }
        }
    }

    fn build(&mut self, target: Option<usize>, field: &mut Field<M>) {
        let Field { distances, runs } = field;
        distances.fill(M::FAR);
        runs.fill(0);
        self.arrivals.fill(0);
        let Some(target) = target else { return };
        distances[target] = M::HERE;
        self.frontier.start(&mut [(M::HERE, target as u32)]);
        while let Some((distance, index)) = self.frontier.pop() {
            let index = index as usize;
            if distances[index] != distance {
                continue;
            }
            let allowed = self.allowed[index];
            if distance != M::HERE
                && let Some((number, next)) = first_move::<M>(&self.offsets, allowed, distances, index)
            {
                runs[index] = prepend::<M>(number, runs[next]);
            }
            let mut successors = M::successors(self.arrivals[index], allowed);
            while successors != 0 {
                let number = successors.trailing_zeros() as usize;
                successors &= successors - 1;
                let next = index.wrapping_add_signed(self.offsets[number & 15] as isize);
                let further = M::plus(distance, number);
                if distances[next] == further {
                    self.arrivals[next] |= 1 << number;
                } else if M::key(further) < M::key(distances[next]) && M::key(further) <= M::LIMIT {
                    distances[next] = further;
                    self.arrivals[next] = 1 << number;
                    self.frontier.push(number, further, next as u32);
                }
            }
        }
    }
}

/// The move that comes next from a cell and where it leads: of the shortest ways' moves the one with the
/// lowest number.
#[inline]
fn first_move<M: Metric>(
    offsets: &[i32; 16],
    mut allowed: Moves,
    distances: &[M::Distance],
    index: usize,
) -> Option<(usize, usize)> {
    let distance = distances[index];
    while allowed != 0 {
        let number = allowed.trailing_zeros() as usize;
        allowed &= allowed - 1;
        let next = index.wrapping_add_signed(offsets[number & 15] as isize);
        if M::plus(distances[next], number) == distance {
            return Some((number, next));
        }
    }
    None
}
