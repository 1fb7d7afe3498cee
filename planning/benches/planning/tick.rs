//! A tick of the coordinator: 100 robots, 100 piles, who goes where and how.

use std::time::Instant;

use planning::{assign::Assignment, grid::Cell, memory::Fields, moves::MoveSet, path::Path};
use serde::Serialize;

use crate::known::{choose, reachable};
use crate::maps::Map;
use crate::statistics::Summary;

/// Robots, and piles.
const SIDE: usize = 100;
const TICKS: usize = 100;
/// Costs are in so many parts of a cell.
const PARTS: f64 = 1000.0;

/// What a tick takes, in microseconds.
#[derive(Debug, Serialize)]
pub struct TickReport {
    pub map: String,
    pub side: usize,
    /// What each pair costs, from the fields.
    pub matrix: Summary,
    pub assignment: Summary,
    /// The way of each pair, with waypoints.
    pub paths: Summary,
    pub all: Summary,
}

/// Measures a tick on a map; robots are elsewhere in each.
pub fn measure(map: &Map) -> TickReport {
    let start = map.queries.first().map(|query| query.from).unwrap_or_default();
    let cells = reachable(&map.grid, start);
    let piles = choose(&cells, SIDE, 1);
    let fields = Fields::build(map.grid.clone(), MoveSet::Eight, &piles);
    let mut assignment = Assignment::default();
    let mut paths = vec![Path::default(); SIDE];
    let mut costs: Vec<u32> = Vec::new();
    let mut times = [const { Vec::new() }; 4];
    for tick in 0..=TICKS as u64 {
        let robots: Vec<Cell> = choose(&cells, SIDE, 2 + tick);
        let begin = Instant::now();
        costs.clear();
        for &robot in &robots {
            costs.extend(fields.distances(robot).map(|cells| (cells * PARTS) as u32));
        }
        let matrix = begin.elapsed();
        // No way is an infinite one, which became the largest number.
        let cost = |row: usize, column: usize| {
            Some(costs[row * piles.len() + column]).filter(|&cost| cost < u32::MAX)
        };
        assignment.solve(robots.len(), piles.len(), cost);
        let assigned = begin.elapsed();
        let mut walked = 0;
        for ((robot, pile), path) in assignment.pairs().zip(&mut paths) {
            walked += usize::from(fields.walk(robots[robot], pile, path));
        }
        let all = begin.elapsed();
        assert_eq!(walked, robots.len(), "a robot has no way to its pile");
        // The first one warms up.
        if tick > 0 {
            let parts = [matrix, assigned - matrix, all - assigned, all];
            times.iter_mut().zip(parts).for_each(|(times, part)| times.push(part.as_secs_f64() * 1e6));
        }
    }
    let [matrix, assignment, paths, all] = times.map(|times| Summary::of(&times));
    TickReport { map: map.name.clone(), side: SIDE, matrix, assignment, paths, all }
}
