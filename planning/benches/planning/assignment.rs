//! The assignment of 100 robots to 100 piles, beside the crate `lapjv`.

use std::hint::black_box;
use std::time::Instant;

use planning::assign::{Assignment, PairCost};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::Serialize;

use crate::statistics::Summary;

/// Robots, and piles.
const SIDE: usize = 100;
/// So many matrices are solved, and rows changed.
const MATRICES: usize = 200;
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
    let mut fresh = Assignment::default();
    let [mut solve, mut lapjv, mut changed_row, mut changed_column] = [const { Vec::new() }; 4];
    let mut off = 0;
    for matrix in 0..=MATRICES {
        let mut costs: Vec<PairCost> = (0..SIDE * SIDE).map(|_| random.random_range(0..COSTS)).collect();
        let theirs =
            lapjv::Matrix::from_shape_fn((SIDE, SIDE), |(row, column)| f64::from(costs[row * SIDE + column]));
        let mut times = [0.0; 4];
        times[0] = micros(|| assignment.solve(SIDE, SIDE, |row, column| Some(costs[row * SIDE + column])));
        let mut total = 0.0;
        let mut found = None;
        times[1] = micros(|| found = lapjv::lapjv(black_box(&theirs)).ok());
        if let Some((of_row, _)) = found {
            total = lapjv::cost(&theirs, &of_row);
        }
        off += usize::from(total != assignment.cost() as f64);
        let mut line: Vec<PairCost> = (0..SIDE).map(|_| random.random_range(0..COSTS)).collect();
        let row = random.random_range(0..SIDE);
        times[2] = micros(|| assignment.set_row(row, |column| Some(line[column])));
        costs[row * SIDE..][..SIDE].copy_from_slice(&line);
        line.rotate_left(1);
        let column = random.random_range(0..SIDE);
        times[3] = micros(|| assignment.set_column(column, |row| Some(line[row])));
        (0..SIDE).for_each(|row| costs[row * SIDE + column] = line[row]);
        fresh.solve(SIDE, SIDE, |row, column| Some(costs[row * SIDE + column]));
        off += usize::from(fresh.cost() != assignment.cost());
        // The first one warms up.
        if matrix > 0 {
            solve.push(times[0]);
            lapjv.push(times[1]);
            changed_row.push(times[2]);
            changed_column.push(times[3]);
        }
    }
    AssignmentReport {
        side: SIDE,
        solve: Summary::of(&solve),
        lapjv: Summary::of(&lapjv),
        changed_row: Summary::of(&changed_row),
        changed_column: Summary::of(&changed_column),
        off,
    }
}

fn micros(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64() * 1e6
}
