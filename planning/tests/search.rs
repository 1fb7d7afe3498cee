//! What every planner of shortest paths must do on every map: find what Dijkstra finds.
#![allow(clippy::unwrap_used)]

use planning::{
    grid::{Cell, Grid},
    moves::{Length, MoveSet},
    search::{AStar, Dijkstra, Jps, Planner, SearchError, Workspace, jps},
};
use proptest::{prelude::*, sample::Index};

fn move_sets() -> impl Strategy<Value = MoveSet> {
    prop::sample::select(vec![MoveSet::Eight, MoveSet::Sixteen])
}

/// Sides down to one cell, some of several words, and some ending at a word's border.
fn sides() -> impl Strategy<Value = (u16, u16)> {
    prop_oneof![
        6 => (1u16..24, 1u16..24),
        2 => (62u16..67, 1u16..24),
        2 => (1u16..24, 62u16..67),
        1 => (Just(1u16), 1u16..200),
        1 => (1u16..200, Just(1u16)),
        1 => (120u16..200, 60u16..70),
    ]
}

/// Random clutter, from open floors to places that are mostly walls.
fn clutter() -> impl Strategy<Value = Grid> {
    (sides(), prop::sample::select(vec![0.02, 0.1, 0.25, 0.4]), any::<u64>()).prop_map(
        |((width, height), blocked, seed)| {
            use rand::{RngExt as _, SeedableRng as _};
            let mut random = rand_pcg::Pcg64Mcg::seed_from_u64(seed);
            let mut grid = Grid::open(width, height);
            for index in 0..grid.len() {
                let free = !random.random_bool(blocked);
                grid.set(grid.cell(index), free);
            }
            grid
        },
    )
}

/// Walls from side to side, each with no door or some of one cell.
fn rooms() -> impl Strategy<Value = Grid> {
    let walls = prop::collection::vec(
        (any::<bool>(), any::<Index>(), prop::collection::vec(any::<Index>(), 0..3)),
        0..8,
    );
    (sides(), walls).prop_map(|((width, height), walls)| {
        let mut grid = Grid::open(width, height);
        for (upright, place, doors) in walls {
            let (wide, long) = if upright { (width, height) } else { (height, width) };
            let at = place.index(wide as usize) as i32;
            let cell = |along: i32| if upright { Cell { x: at, y: along } } else { Cell { x: along, y: at } };
            (0..i32::from(long)).for_each(|along| grid.set(cell(along), false));
            doors.iter().for_each(|door| grid.set(cell(door.index(long as usize) as i32), true));
        }
        grid
    })
}

fn maps() -> impl Strategy<Value = Grid> {
    prop_oneof![clutter(), rooms()]
}

/// Two cells, now and then just outside.
fn ends(grid: &Grid, [from, to]: [Index; 2]) -> (Cell, Cell) {
    let cell = |index: Index| {
        let index = index.index(grid.len() + 1);
        if index == grid.len() { Cell { x: -1, y: 0 } } else { grid.cell(index) }
    };
    (cell(from), cell(to))
}

/// What a plan answers, after a look at whether its path is one.
fn length<P: Planner>(
    planner: &P,
    (grid, moves): (&Grid, MoveSet),
    (from, to): (Cell, Cell),
    workspace: &mut P::Workspace,
) -> Result<Length, SearchError> {
    let plan = planner.plan(from, to, workspace)?;
    assert_eq!((plan.path.start(), plan.path.end()), (from, to));
    assert!(plan.path.is_walkable(grid, moves), "{:?} cannot be walked", plan.path);
    assert_eq!(plan.path.steps().map(Length::of).sum::<Length>(), plan.path.length());
    let turns = plan.path.waypoints().len() as u64;
    assert!(turns <= u64::from(plan.expanded) * 3 + 2, "{} nodes for {turns} waypoints", plan.expanded);
    assert!(u64::from(plan.expanded) <= 4 * grid.len() as u64, "{} nodes", plan.expanded);
    Ok(plan.path.length())
}

/// What Dijkstra's algorithm finds when it looks everywhere.
fn shortest((grid, moves): (&Grid, MoveSet), (from, to): (Cell, Cell)) -> Result<Length, SearchError> {
    let mut workspace = Workspace::default();
    let ways = Dijkstra::new(grid, moves).ways(from, &[], &mut workspace)?;
    match ways.length_to(to) {
        Some(length) => Ok(length),
        None if grid.is_free(to) => Err(SearchError::NoPath { from, to }),
        None if grid.index(to).is_some() => Err(SearchError::Blocked { cell: to }),
        None => Err(SearchError::Outside { cell: to, width: grid.width(), height: grid.height() }),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn all_planners_find_the_shortest_length(grid in maps(), moves in move_sets(), cells in any::<[Index; 2]>()) {
        let (map, ends) = ((&grid, moves), ends(&grid, cells));
        let shortest = shortest(map, ends);
        let mut workspace = Workspace::default();
        prop_assert_eq!(length(&Dijkstra::new(&grid, moves), map, ends, &mut workspace), shortest);
        prop_assert_eq!(length(&AStar::new(&grid, moves), map, ends, &mut workspace), shortest);
        let jps = Jps::new(grid.clone(), moves);
        prop_assert_eq!(length(&jps, map, ends, &mut jps::Workspace::default()), shortest);
    }

    #[test]
    fn a_workspace_that_has_searched_other_maps_finds_the_same(
        maps in prop::collection::vec((maps(), any::<[Index; 2]>()), 1..5), moves in move_sets(),
    ) {
        let mut reused = Workspace::default();
        for (grid, cells) in maps {
            let (from, to) = ends(&grid, cells);
            let (astar, mut new) = (AStar::new(&grid, moves), Workspace::default());
            let [again, new] = [&mut reused, &mut new].map(|workspace| {
                let plan = astar.plan(from, to, workspace)?;
                Ok::<_, SearchError>((plan.path.clone(), plan.expanded))
            });
            prop_assert_eq!(again, new);
        }
    }

    #[test]
    fn ways_to_some_cells_are_those_of_a_search_everywhere(
        grid in maps(), moves in move_sets(), from in any::<Index>(), targets in prop::collection::vec(any::<Index>(), 1..6),
    ) {
        let cell = |index: Index| grid.cell(index.index(grid.len()));
        let (from, targets) = (cell(from), targets.into_iter().map(cell).collect::<Vec<_>>());
        let mut workspace = [Workspace::default(), Workspace::default()];
        let [some, all] = &mut workspace;
        let search = Dijkstra::new(&grid, moves);
        if let (Ok(some), Ok(all)) = (search.ways(from, &targets, some), search.ways(from, &[], all)) {
            prop_assert!(some.expanded() <= all.expanded());
            for cell in grid.free_cells() {
                prop_assert!(some.length_to(cell).is_none_or(|length| Some(length) == all.length_to(cell)));
            }
            for &target in &targets {
                prop_assert_eq!(some.length_to(target), all.length_to(target));
            }
        }
    }
}

/// As dense as maps get, each from one of its cells to all others: among these every way to pass a corner.
#[test]
fn jump_points_are_enough_on_thousands_of_small_dense_maps() {
    use rand::{RngExt as _, SeedableRng as _};
    let mut random = rand_pcg::Pcg64Mcg::seed_from_u64(16);
    let (mut workspace, mut jumps) = (Workspace::default(), jps::Workspace::default());
    for number in 0..4000 {
        let (width, height) = (random.random_range(1..10), random.random_range(1..10));
        let blocked = random.random_range(0.05..0.45);
        let mut grid = Grid::open(width, height);
        (0..grid.len()).for_each(|index| grid.set(grid.cell(index), !random.random_bool(blocked)));
        let moves = [MoveSet::Eight, MoveSet::Sixteen][number % 2];
        let from = grid.cell(random.random_range(0..grid.len()));
        let Ok(ways) = Dijkstra::new(&grid, moves).ways(from, &[], &mut workspace) else { continue };
        let planner = Jps::new(grid.clone(), moves);
        for to in grid.free_cells() {
            let found = length(&planner, (&grid, moves), (from, to), &mut jumps).ok();
            assert_eq!(found, ways.length_to(to), "{moves:?} from {from} to {to}: {grid:?}");
        }
    }
}
