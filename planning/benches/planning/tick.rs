//! A tick of the coordinator: 100 robots, 100 piles, who goes where and how.

use planning::{assign::Assignment, grid::Cell, memory::Fields, moves::MoveSet, path::Path};
use serde::Serialize;

use crate::clock::Clock;
use crate::known::{choose, reachable};
use crate::maps::Map;
use crate::statistics::{Summary, median};

/// Robots, and piles.
const SIDE: usize = 100;
const TICKS: usize = 100;
/// Each is run so often, and of its parts' times the median counts.
const REPEATS: usize = 5;
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
    for tick in 0..TICKS as u64 {
        let robots: Vec<Cell> = choose(&cells, SIDE, 2 + tick);
        let mut repeats = [const { Vec::new() }; 4];
        for _ in 0..REPEATS {
            let (matrix, ()) = Clock::Wall.time(|| {
                costs.clear();
                for &robot in &robots {
                    costs.extend(fields.distances(robot).map(|cells| (cells * PARTS) as u32));
                }
            });
            // No way is an infinite one, which became the largest number.
            let cost = |robot: usize, pile: usize| {
                Some(costs[robot * piles.len() + pile]).filter(|&cost| cost < u32::MAX)
            };
            let (assign, ()) = Clock::Wall.time(|| assignment.solve(robots.len(), piles.len(), cost));
            let (walk, walked) = Clock::Wall.time(|| {
                let pairs = assignment.pairs().zip(&mut paths);
                pairs
                    .filter_map(|((robot, pile), path)| fields.walk(robots[robot], pile, path).then_some(()))
                    .count()
            });
            assert_eq!(walked, robots.len(), "a robot has no way to its pile");
            let parts = [matrix, assign, walk, matrix + assign + walk];
            repeats.iter_mut().zip(parts).for_each(|(repeats, part)| repeats.push(part));
        }
        times.iter_mut().zip(&repeats).for_each(|(times, repeats)| times.push(median(repeats)));
    }
    let [matrix, assignment, paths, all] = times.map(|times| Summary::of(&times));
    TickReport { map: map.name.clone(), side: SIDE, matrix, assignment, paths, all }
}
