//! The assignment of 100 robots to 100 piles, beside the crate `lapjv`.

use std::hint::black_box;

use planning::assign::{Assignment, PairCost};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::Serialize;

use crate::clock::Clock;
use crate::statistics::{Summary, median};

/// Robots, and piles.
const SIDE: usize = 100;
/// So many matrices are solved, and rows changed.
const MATRICES: usize = 200;
/// And each so often.
const REPEATS: usize = 5;
/// Costs are below it, as metres on a large floor to a tenth.
const COSTS: PairCost = 10_000;

/// What assigning takes, in microseconds.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct AssignmentReport {
    pub side: usize,
    pub solve: Summary,
    pub lapjv: Summary,
    pub changed_row: Summary,
    pub changed_column: Summary,
    /// Matrices whose cost is not what `lapjv` finds, and changes not what a fresh solution costs.
    pub off: usize,
}

/// Measures matrices of random costs.
pub fn measure() -> AssignmentReport {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let mut assignment = Assignment::default();
    let mut changed = Assignment::default();
    let mut times = [const { Vec::new() }; 4];
    let mut off = 0;
    for _ in 0..MATRICES {
        let mut costs: Vec<PairCost> = (0..SIDE * SIDE).map(|_| random.random_range(0..COSTS)).collect();
        let matrix =
            lapjv::Matrix::from_shape_fn((SIDE, SIDE), |(row, column)| f64::from(costs[row * SIDE + column]));
        let mut line = || (0..SIDE).map(|_| random.random_range(0..COSTS)).collect::<Vec<PairCost>>();
        let (row, column) = (line(), line());
        let (row_number, column_number) = (random.random_range(0..SIDE), random.random_range(0..SIDE));

        times[0].push(repeat(|| {
            Clock::Wall
                .time(|| assignment.solve(SIDE, SIDE, |row, column| Some(costs[row * SIDE + column])))
                .0
        }));
        let mut theirs = f64::NAN;
        times[1].push(repeat(|| {
            let (micros, solved) = Clock::Wall.time(|| lapjv::lapjv(black_box(&matrix)));
            theirs = solved.map_or(f64::NAN, |(of_row, _)| lapjv::cost(&matrix, &of_row));
            micros
        }));
        off += usize::from(theirs != assignment.cost() as f64);
        times[2].push(repeat(|| {
            changed.clone_from(&assignment);
            Clock::Wall.time(|| changed.set_row(row_number, |column| Some(row[column]))).0
        }));
        costs[row_number * SIDE..][..SIDE].copy_from_slice(&row);
        off += usize::from(changed.cost() != fresh(&costs));
        assignment.clone_from(&changed);
        times[3].push(repeat(|| {
            changed.clone_from(&assignment);
            Clock::Wall.time(|| changed.set_column(column_number, |row| Some(column[row]))).0
        }));
        (0..SIDE).for_each(|row| costs[row * SIDE + column_number] = column[row]);
        off += usize::from(changed.cost() != fresh(&costs));
    }
    let [solve, lapjv, changed_row, changed_column] = times.map(|times| Summary::of(&times));
    AssignmentReport { side: SIDE, solve, lapjv, changed_row, changed_column, off }
}

/// What a fresh solution costs.
fn fresh(costs: &[PairCost]) -> u64 {
    let mut assignment = Assignment::default();
    assignment.solve(SIDE, SIDE, |row, column| Some(costs[row * SIDE + column]));
    assignment.cost()
}

/// The median of what some repetitions take.
fn repeat(mut work: impl FnMut() -> f64) -> f64 {
    median(&[(); REPEATS].map(|()| work()))
}
