//! Optimal planners find MovingAI's optimal lengths (octile costs, no corner cutting): some queries of
//! each map. `cargo xtask test` has all of them checked by the benchmark, in an optimised build.
#![allow(clippy::unwrap_used)]

use std::{fs, path::Path};

use planning::{
    formats::{movingai::read_map, scen::read_scen},
    grid::Grid,
    indexed::Index,
    moves::MoveSet,
    search::{AStar, Dijkstra, Jps, Planner},
};

const MAPS: [&str; 5] = ["arena2", "brc202d", "maze512-4-0", "office500", "random512-10-0"];

fn read(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/bench");
    fs::read_to_string(folder.join(name)).unwrap()
}

fn grid(map: &str) -> Grid {
    read_map(&read(&format!("{map}.map"))).unwrap()
}

/// Plans `count` queries of the map, evenly spaced, and compares the lengths.
fn check(planner: &impl Planner, map: &str, grid: &Grid, count: usize) {
    let queries = read_scen(&read(&format!("{map}.map.scen"))).unwrap();
    let mut workspace = Default::default();
    for query in queries.iter().step_by(queries.len() / count) {
        let path = planner.plan(query.from, query.to, &mut workspace).unwrap().path;
        let length = path.length().units();
        assert!((length - query.optimal).abs() < 0.01, "{query:?}: found {length}");
        assert_eq!((path.start(), path.end()), (query.from, query.to), "{query:?}");
        assert!(path.is_walkable(grid, MoveSet::Eight), "{query:?}");
    }
}

#[test]
fn a_star_finds_optimal_lengths() {
    for map in MAPS {
        let grid = grid(map);
        check(&AStar::new(&grid, MoveSet::Eight), map, &grid, 20);
    }
}

#[test]
fn dijkstra_finds_optimal_lengths() {
    for map in MAPS {
        let grid = grid(map);
        check(&Dijkstra::new(&grid, MoveSet::Eight), map, &grid, 10);
    }
}

#[test]
fn the_index_finds_optimal_lengths() {
    // In the fast set, only where an index takes little: all maps are checked by the benchmark.
    for map in ["arena2", "maze512-4-0", "office500"] {
        let grid = grid(map);
        check(&Index::build(grid.clone(), MoveSet::Eight), map, &grid, 200);
    }
}

#[test]
fn with_sixteen_neighbours_all_find_what_a_star_finds() {
    let moves = MoveSet::Sixteen;
    for map in ["arena2", "maze512-4-0", "office500"] {
        let grid = grid(map);
        let (jps, index) = (Jps::new(grid.clone(), moves), Index::build(grid.clone(), moves));
        let (mut searched, mut jumped, mut recalled) = Default::default();
        let queries = read_scen(&read(&format!("{map}.map.scen"))).unwrap();
        for query in queries.iter().step_by(queries.len() / 10) {
            let (from, to) = (query.from, query.to);
            let shortest = AStar::new(&grid, moves).plan(from, to, &mut searched).unwrap().path.length();
            assert!(shortest.units() < query.optimal + 1e-6, "{query:?}");
            let paths = [
                jps.plan(from, to, &mut jumped).unwrap().path,
                index.plan(from, to, &mut recalled).unwrap().path,
            ];
            for path in paths {
                assert_eq!(path.length(), shortest, "{query:?}");
                assert!(path.is_walkable(&grid, moves), "{query:?}");
            }
        }
    }
}
