//! An index finds what A* finds, on every kind of map and with a core of any size.

use std::collections::BTreeSet;

use proptest::{collection::vec, prelude::*, sample::Index as Place};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::*;
use crate::{
    moves::MoveSet,
    search::{self, AStar},
};

/// The free cells of a map that `free` says.
fn map(width: i32, height: i32, free: impl Fn(Cell) -> bool) -> Grid {
    let mut grid = Grid::blocked(width as u32, height as u32).unwrap();
    for index in 0..grid.len() {
        let cell = grid.cell(index);
        grid.set(cell, free(cell));
    }
    grid
}

/// Sides that include one cell, and words' borders.
fn sides() -> impl Strategy<Value = i32> {
    prop_oneof![1i32..40, 60i32..68, 124i32..131]
}

/// From open to closed, down to one row or column.
fn clutter() -> impl Strategy<Value = Grid> {
    (sides(), sides(), 0.0..0.5, any::<u64>()).prop_map(|(width, height, blocked, seed)| {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let free: Vec<bool> = (0..width * height).map(|_| !random.random_bool(blocked)).collect();
        map(width, height, |Cell { x, y }| free[(y * width + x) as usize])
    })
}

/// Rooms of one size with doors of one cell in most walls.
fn rooms() -> impl Strategy<Value = Grid> {
    (1i32..17, 2i32..8).prop_flat_map(|(size, rooms)| {
        let doors = vec((prop::bool::weighted(0.85), 0..size), (2 * rooms * rooms) as usize);
        doors.prop_map(move |doors| {
            let wall = |at: i32| at % (size + 1) == size;
            let door = |room: i32, other: i32, at: i32, side: usize| {
                let (open, place) = doors[2 * (room * rooms + other) as usize + side];
                open && at % (size + 1) == place
            };
            let length = rooms * (size + 1) - 1;
            map(length, length, |Cell { x, y }| match (wall(x), wall(y)) {
                (true, true) => false,
                (true, false) => door(x / (size + 1), y / (size + 1), y, 0),
                (false, true) => door(x / (size + 1), y / (size + 1), x, 1),
                (false, false) => true,
            })
        })
    })
}

/// Corridors of one width along a tree, with walls of one cell and a few openings more.
fn mazes() -> impl Strategy<Value = Grid> {
    (1i32..9, 2i32..9).prop_flat_map(|(width, side)| {
        vec((any::<bool>(), prop::bool::weighted(0.1)), (side * side) as usize).prop_map(move |choices| {
            let length = side * (width + 1) - 1;
            // Every room opens to the left or up: a tree.
            map(length, length, |Cell { x, y }| {
                let (column, row) = (x / (width + 1), y / (width + 1));
                let opens = |column: i32, row: i32, left: bool| {
                    let (choice, both) = choices[(row * side + column) as usize];
                    both || column == 0 && !left || row == 0 && left || choice == left
                };
                match (x % (width + 1) == width, y % (width + 1) == width) {
                    (true, true) => false,
                    (true, false) => column + 1 < side && opens(column + 1, row, true),
                    (false, true) => row + 1 < side && opens(column, row + 1, false),
                    (false, false) => true,
                }
            })
        })
    })
}

/// Open ground with round lakes and slanted walls.
fn terrain() -> impl Strategy<Value = Grid> {
    let lake = (0i32..90, 0i32..90, 1i32..12);
    let wall = (0i32..90, 0i32..90, 1i32..50, any::<bool>(), any::<bool>());
    (vec(lake, 0..9), vec(wall, 0..9)).prop_map(|(lakes, walls)| {
        let mut blocked = BTreeSet::new();
        for (x, y, length, falls, thick) in walls {
            for along in 0..length {
                let cell = Cell { x: x + along, y: if falls { y - along } else { y + along } };
                blocked.insert(cell);
                blocked.extend(thick.then_some(cell.offset(1, 0)));
            }
        }
        map(90, 90, |cell| {
            let in_lake = |&(x, y, radius): &(i32, i32, i32)| {
                (cell.x - x).pow(2) + (cell.y - y).pow(2) <= radius * radius
            };
            !blocked.contains(&cell) && !lakes.iter().any(in_lake)
        })
    })
}

/// Shelves in rows.
fn warehouses() -> impl Strategy<Value = Grid> {
    (1i32..4, 1i32..12, 1i32..5, 1i32..5).prop_map(|(deep, long, aisle, gap)| {
        map(70, 66, |Cell { x, y }| x % (long + gap) < gap || y % (deep + aisle) < aisle)
    })
}

fn maps() -> impl Strategy<Value = Grid> {
    prop_oneof![clutter(), rooms(), mazes(), terrain(), warehouses()]
}

fn move_sets() -> impl Strategy<Value = MoveSet> {
    prop::sample::select(vec![MoveSet::Eight, MoveSet::Sixteen])
}

/// Budgets from none, so that all is core, to enough, so that none is.
fn budgets() -> impl Strategy<Value = u64> {
    prop_oneof![Just(0), 0u64..20_000, Just(3_000_000)]
}

fn check(
    index: &Index,
    (from, to): (Cell, Cell),
    workspace: &mut Workspace,
    other: &mut search::Workspace,
) -> Result<(), TestCaseError> {
    let moves = index.subgoals.moves();
    let expected = AStar::new(index.grid(), moves).plan(from, to, other);
    match (index.plan(from, to, workspace), expected) {
        (Ok(plan), Ok(found)) => {
            prop_assert_eq!(plan.path.length(), found.path.length(), "from {} to {}", from, to);
            prop_assert!(plan.path.is_walkable(index.grid(), moves), "{:?}", plan.path);
            prop_assert_eq!((plan.path.start(), plan.path.end()), (from, to));
            prop_assert_eq!(
                plan.path.steps().map(crate::moves::Length::of).sum::<crate::moves::Length>(),
                plan.path.length()
            );
        }
        (Err(error), Err(expected)) => prop_assert_eq!(error, expected),
        (plan, found) => prop_assert!(false, "the index says {plan:?}, A* {found:?}"),
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn the_index_finds_what_a_star_finds(
        grid in maps(), moves in move_sets(), budget in budgets(), ends in vec((any::<Place>(), any::<Place>()), 1..8),
    ) {
        let index = Index::with_budget(grid, moves, budget);
        let mut memory = (Workspace::default(), search::Workspace::default());
        let cell = |place: Place| index.grid().cell(place.index(index.grid().len()));
        for (from, to) in ends {
            check(&index, (cell(from), cell(to)), &mut memory.0, &mut memory.1)?;
        }
    }

    #[test]
    fn a_workspace_goes_from_map_to_map(
        queries in vec((clutter(), move_sets(), budgets(), any::<Place>(), any::<Place>()), 2..6),
    ) {
        let mut memory = (Workspace::default(), search::Workspace::default());
        for (grid, moves, budget, from, to) in queries {
            let ends = [from, to].map(|place| grid.cell(place.index(grid.len())));
            check(&Index::with_budget(grid, moves, budget), (ends[0], ends[1]), &mut memory.0, &mut memory.1)?;
        }
    }

    #[test]
    fn what_sees_is_seen(grid in maps(), moves in move_sets(), from in any::<Place>()) {
        let subgoals = Subgoals::find(&grid, moves);
        if !subgoals.cells().is_empty() {
            let from = from.index(subgoals.cells().len()) as u32;
            let sight = |from: u32| {
                let mut seen = Vec::new();
                subgoals.sight(subgoals.cells()[from as usize], |to, cost| seen.push((to, cost)));
                seen
            };
            for (to, cost) in sight(from) {
                prop_assert!(sight(to).contains(&(from, cost)), "{} and {}", from, to);
            }
        }
    }
}

#[test]
fn every_pair_of_a_small_map_is_as_a_star_says() {
    let rows =
        ["..........", ".@@.@@@.@.", ".@....@.@.", ".@.@@.@...", "...@..@@@.", "@@.@@.....", "...@..@@.@"];
    let grid = map(10, 7, |cell| rows[cell.y as usize].as_bytes()[cell.x as usize] == b'.');
    let mut memory = (Workspace::default(), search::Workspace::default());
    let kinds = [0, 500, u64::MAX]
        .into_iter()
        .flat_map(|budget| [MoveSet::Eight, MoveSet::Sixteen].map(|moves| (budget, moves)));
    for (budget, moves) in kinds {
        let index = Index::with_budget(grid.clone(), moves, budget);
        let cells = || (0..grid.len()).map(|place| grid.cell(place));
        for (from, to) in cells().flat_map(|from| cells().map(move |to| (from, to))) {
            check(&index, (from, to), &mut memory.0, &mut memory.1).unwrap();
        }
    }
}

#[test]
fn what_is_outside_or_blocked_is_said() {
    let index = Index::build(map(3, 1, |cell| cell.x != 1), MoveSet::Eight);
    let mut workspace = Workspace::default();
    let mut error = |from, to| index.plan(from, to, &mut workspace).unwrap_err();
    let at = |x, y| Cell { x, y };
    assert_eq!(error(at(1, 0), at(0, 0)), SearchError::Blocked { cell: at(1, 0) });
    assert_eq!(
        error(at(0, 0), at(i32::MAX, 0)),
        SearchError::Outside { cell: at(i32::MAX, 0), width: 3, height: 1 }
    );
    assert_eq!(
        error(at(0, i32::MIN), at(0, 0)),
        SearchError::Outside { cell: at(0, i32::MIN), width: 3, height: 1 }
    );
    assert_eq!(error(at(0, 0), at(2, 0)), SearchError::NoPath { from: at(0, 0), to: at(2, 0) });
}

#[test]
fn a_map_without_cells_has_an_index() {
    for moves in [MoveSet::Eight, MoveSet::Sixteen] {
        let index = Index::build(Grid::blocked(0, 0).unwrap(), moves);
        assert!(index.plan(Cell::default(), Cell::default(), &mut Workspace::default()).is_err());
    }
}

#[test]
fn a_map_gives_the_same_index_every_time() {
    let grid = map(120, 120, |Cell { x, y }| (x * 7 + y * 13 + x * y) % 9 != 0);
    for moves in [MoveSet::Eight, MoveSet::Sixteen] {
        let index = || format!("{:?}", Index::build(grid.clone(), moves));
        assert_eq!(index(), index());
    }
}
