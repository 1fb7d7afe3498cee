//! A* finds MovingAI's optimal lengths: octile costs, no corner cutting.
#![allow(clippy::unwrap_used)]

use planning::{
    formats::movingai::read_map,
    grid::Cell,
    moves::MoveSet,
    search::{AStar, Planner, Workspace},
};

#[test]
fn a_star_finds_the_optimal_length_of_every_query() {
    let grid = read_map(include_str!("data/arena2.map")).unwrap();
    let mut workspace = Workspace::default();
    let mut queries = 0;
    for line in include_str!("data/arena2.map.scen").lines().skip(1) {
        let fields: Vec<&str> = line.split_whitespace().collect();
        let [from_x, from_y, to_x, to_y] = [4, 5, 6, 7].map(|field| fields[field].parse::<i32>().unwrap());
        let optimal: f64 = fields[8].parse().unwrap();
        let (from, to) = (Cell { x: from_x, y: from_y }, Cell { x: to_x, y: to_y });
        let found = AStar::new(&grid, MoveSet::Eight).plan(from, to, &mut workspace).unwrap();
        let length = found.path.length().units();
        assert!((length - optimal).abs() < 0.01, "{line}: found {length}");
        assert!(found.path.is_walkable(&grid, MoveSet::Eight), "{line}");
        queries += 1;
    }
    assert_eq!(queries, 114);
}
