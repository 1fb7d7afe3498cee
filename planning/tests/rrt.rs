//! What must hold of trees that explore by chance, on every map.
#![allow(clippy::unwrap_used)]

use std::num::NonZeroU32;

use planning::{
    grid::{Cell, Grid},
    moves::MoveSet,
    rrt::{ImprovedAStar, ImprovedWorkspace, Rrt, RrtError, Tree, keep_necessary_nodes, sees},
    search::{AStar, Planner, SearchError, Workspace},
};
use proptest::{prelude::*, sample::Index};

/// A map of random cells, down to one row or column.
fn maps() -> impl Strategy<Value = Grid> {
    (1u32..24, 1u32..24).prop_flat_map(|(width, height)| {
        prop::collection::vec(prop::bool::weighted(0.75), (width * height) as usize).prop_map(move |cells| {
            let mut grid = Grid::blocked(width, height).unwrap();
            for (index, free) in cells.into_iter().enumerate() {
                grid.set(grid.cell(index), free);
            }
            grid
        })
    })
}

fn trees() -> impl Strategy<Value = Rrt> {
    (1u32..30, 0.0..1.0).prop_map(|(branch, goal_bias)| Rrt {
        branch: NonZeroU32::new(branch).unwrap(),
        goal_bias,
        samples: 2_000,
    })
}

/// Open but for a wall with one door of three cells.
fn one_door(side: u32) -> Grid {
    let mut grid = Grid::blocked(side, side).unwrap();
    for cell in (0..grid.len()).map(|index| grid.cell(index)).collect::<Vec<_>>() {
        grid.set(cell, cell.x != side as i32 / 2 || (1..=3).contains(&cell.y));
    }
    grid
}

fn length(path: &[Cell]) -> f64 {
    path.iter().zip(&path[1..]).map(|(a, b)| f64::from((a.x - b.x).pow(2) + (a.y - b.y).pow(2)).sqrt()).sum()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn paths_and_their_necessary_nodes_are_free_and_the_latter_never_longer(
        grid in maps(), rrt in trees(), seed: u64, from in any::<Index>(), to in any::<Index>(),
    ) {
        let (from, to) = (grid.cell(from.index(grid.len())), grid.cell(to.index(grid.len())));
        let mut tree = Tree::default();
        let grown = rrt.grow(&grid, from, to, seed, &mut tree);
        for (start, end) in tree.branches() {
            prop_assert!(sees(&grid, start, end));
        }
        let mut workspace = Workspace::default();
        let shortest = AStar::new(&grid, MoveSet::Eight).plan(from, to, &mut workspace).map(|plan| plan.expanded);
        match grown {
            Ok(()) => {
                prop_assert!(shortest.is_ok());
                let path = tree.path();
                let mut kept = path.clone();
                keep_necessary_nodes(&grid, &mut kept);
                for path in [&path, &kept] {
                    prop_assert_eq!((path[0], path[path.len() - 1]), (from, to));
                    prop_assert!(path.windows(2).all(|pair| sees(&grid, pair[0], pair[1])));
                }
                prop_assert!(kept.iter().all(|node| path.contains(node)) && kept.len() <= path.len());
                prop_assert!(length(&kept) <= length(&path) + 1e-9);
                // What was necessary stays so.
                let before = kept.clone();
                keep_necessary_nodes(&grid, &mut kept);
                prop_assert_eq!(kept, before);
            }
            Err(RrtError::Search(error)) => prop_assert_eq!(shortest, Err(error)),
            Err(RrtError::Exhausted { .. }) => {
                let misplaced = matches!(shortest, Err(SearchError::Blocked { .. } | SearchError::Outside { .. }));
                prop_assert!(!misplaced);
            }
        }
    }

    #[test]
    fn a_tree_that_has_grown_elsewhere_grows_the_same(
        maps in prop::collection::vec((maps(), any::<Index>(), any::<Index>(), any::<u64>()), 1..4), rrt in trees(),
    ) {
        let mut reused = Tree::default();
        for (grid, from, to, seed) in maps {
            let (from, to) = (grid.cell(from.index(grid.len())), grid.cell(to.index(grid.len())));
            let mut new = Tree::default();
            let grown = rrt.grow(&grid, from, to, seed, &mut reused);
            prop_assert_eq!(grown, rrt.grow(&grid, from, to, seed, &mut new));
            prop_assert!(reused.branches().eq(new.branches()));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn improved_a_star_finds_a_walkable_path_where_there_is_one_and_never_a_shorter_one_than_a_star(
        grid in maps(), moves in prop::sample::select(vec![MoveSet::Eight, MoveSet::Sixteen]), rrt in trees(),
        seed: u64, ends in prop::collection::vec((any::<Index>(), any::<Index>()), 1..4),
    ) {
        let astar = AStar::new(&grid, moves);
        // Of one sample it mostly gives up, and plans as A* does.
        for rrt in [rrt, Rrt { samples: 1, ..rrt }] {
            let improved = ImprovedAStar::new(&grid, astar, rrt, seed);
            let mut reused = ImprovedWorkspace::default();
            for (from, to) in &ends {
                let (from, to) = (grid.cell(from.index(grid.len())), grid.cell(to.index(grid.len())));
                let mut workspace = Workspace::default();
                let shortest = astar.plan(from, to, &mut workspace).map(|plan| plan.path);
                match (improved.plan(from, to, &mut reused).map(|plan| plan.path), shortest) {
                    (Ok(path), Ok(shortest)) => {
                        prop_assert!(path.is_walkable(&grid, moves));
                        prop_assert_eq!((path.start(), path.end()), (from, to));
                        prop_assert!(path.length() >= shortest.length());
                        let mut new = ImprovedWorkspace::default();
                        prop_assert_eq!(path, improved.plan(from, to, &mut new).unwrap().path);
                    }
                    (path, shortest) => prop_assert_eq!(path.map(|_| ()), shortest.map(|_| ())),
                }
                // Between two nodes no way is longer than columns and rows together.
                let columns_and_rows: u32 = reused
                    .nodes()
                    .windows(2)
                    .map(|pair| pair[0].x.abs_diff(pair[1].x) + pair[0].y.abs_diff(pair[1].y))
                    .sum();
                let nodes = !reused.nodes().is_empty();
                if let (Ok(plan), true) = (improved.plan(from, to, &mut reused), nodes) {
                    prop_assert!(plan.path.length().units() <= f64::from(columns_and_rows) + 1e-9);
                }
            }
        }
    }
}

#[test]
fn a_seed_gives_the_same_tree_on_every_machine() {
    let grid = one_door(40);
    let (from, to) = (Cell { x: 3, y: 35 }, Cell { x: 36, y: 35 });
    let mut tree = Tree::default();
    let found: Vec<_> = (0..4)
        .map(|seed| {
            Rrt::PAPER.grow(&grid, from, to, seed, &mut tree).unwrap();
            let mut path = tree.path();
            let nodes = path.len();
            keep_necessary_nodes(&grid, &mut path);
            (tree.len(), nodes, path.len())
        })
        .collect();
    assert_eq!(found, [(194, 40, 3), (188, 32, 4), (123, 35, 4), (169, 35, 4)]);
}

#[test]
fn goal_bias_makes_a_smaller_tree_where_little_is_in_the_way() {
    let grid = one_door(60);
    let (from, to) = (Cell { x: 5, y: 2 }, Cell { x: 55, y: 3 });
    let nodes = |goal_bias| -> usize {
        let mut tree = Tree::default();
        let grown = (0..20).map(|seed| {
            Rrt { goal_bias, ..Rrt::PAPER }.grow(&grid, from, to, seed, &mut tree).unwrap();
            tree.len()
        });
        grown.sum()
    };
    assert!(nodes(0.7) * 2 < nodes(0.0), "{} and {}", nodes(0.7), nodes(0.0));
}

#[test]
fn a_tree_that_only_aims_at_the_goal_gives_up_at_a_wall_and_does_not_say_there_is_no_way() {
    let grid = one_door(40);
    let (from, to) = (Cell { x: 3, y: 35 }, Cell { x: 36, y: 35 });
    let rrt = Rrt { goal_bias: 1.0, samples: 100, ..Rrt::PAPER };
    let error = rrt.grow(&grid, from, to, 1, &mut Tree::default()).unwrap_err();
    assert_eq!(error, RrtError::Exhausted { from, to, samples: 100 });
    assert!(error.to_string().contains("though there may be one"), "{error}");
}
