//! Derived subareas and doors: how good they are on maps whose rooms are known, and that no way is lost.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::collections::BTreeMap;

use planning::{
    formats::movingai::read_map,
    grid::{Cell, Grid},
    lmpp::Lmpp,
    memory::Target,
    moves::MoveSet,
    rooms::{Rooms, Subareas},
    search::{AStar, Planner, Workspace},
    segment::{Options, segment},
};
use proptest::prelude::*;

const OPTIONS: Options = Options { door_width: 10, room_area: 30, clutter_area: 16, reach: 5 };

/// For each known room, the intersection over union with the derived subarea that covers most of it.
fn overlaps(grid: &Grid, known: &Subareas, derived: &Rooms) -> BTreeMap<char, f64> {
    let (mut rooms, mut areas, mut both) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
    for cell in grid.free_cells() {
        let (room, area) = (known.find(cell).unwrap(), derived.find_subarea(cell).unwrap());
        *rooms.entry(room).or_insert(0.0) += 1.0;
        *areas.entry(area).or_insert(0.0) += 1.0;
        *both.entry((room, area)).or_insert(0.0) += 1.0;
    }
    let best = |room| {
        let shared = both.iter().filter(|((of, _), _)| *of == room);
        shared.map(|((_, area), shared)| shared / (rooms[&room] + areas[area] - shared)).fold(0.0, f64::max)
    };
    rooms.keys().map(|&room| (known.name(room).unwrap(), best(room))).collect()
}

#[test]
fn most_rooms_of_fig_7_are_found_as_they_are_drawn() {
    let grid = read_map(include_str!("../../sites/lmpp-fig7/fig7.map")).unwrap();
    let known = Subareas::read(include_str!("../../sites/lmpp-fig7/subareas.txt"), &grid).unwrap();
    let overlaps = overlaps(&grid, &known, &segment(&grid, OPTIONS, &[]));
    let mean = overlaps.values().sum::<f64>() / overlaps.len() as f64;
    println!("mean intersection over union {mean:.3}: {overlaps:.3?}");
    assert!(mean > 0.5, "{mean}: {overlaps:?}");
}

/// Rooms in rows and columns with doors in their walls, and some obstacles.
fn building() -> impl Strategy<Value = Grid> {
    let sizes = (1..4_i32, 1..4_i32, 5..12_i32);
    let doors = prop::collection::vec((0..9_i32, 1..4_i32, prop::bool::weighted(0.8)), 32);
    (sizes, doors, prop::collection::vec((0..40_i32, 0..40_i32), 0..30)).prop_map(
        |((columns, rows, side), doors, obstacles)| {
            let pitch = side + 1;
            let mut grid = Grid::blocked((columns * pitch) as u32, (rows * pitch) as u32).unwrap();
            for index in 0..grid.len() {
                let cell = grid.cell(index);
                let (wall_x, wall_y) = (cell.x % pitch == side, cell.y % pitch == side);
                let room = (cell.y / pitch * columns + cell.x / pitch) as usize * 2;
                let (at, width, is_door) = doors[(room + usize::from(wall_y)) % doors.len()];
                let along = if wall_x { cell.y % pitch } else { cell.x % pitch };
                let opening = is_door && (at..at + width).contains(&along);
                grid.set(cell, !(wall_x && wall_y) && (!(wall_x || wall_y) || opening));
            }
            obstacles.into_iter().for_each(|(x, y)| grid.set(Cell { x, y }, false));
            grid
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn by_derived_doors_a_way_is_found_wherever_there_is_one(
        grid in building(), ends in prop::collection::vec(any::<prop::sample::Index>(), 4),
    ) {
        let free: Vec<Cell> = grid.free_cells().collect();
        prop_assume!(!free.is_empty());
        let rooms = segment(&grid, OPTIONS, &[]);
        // That they are valid, making them again from their picture shows.
        let subareas = Subareas::read(&rooms.subareas().picture(), &grid).unwrap();
        prop_assert_eq!(Rooms::new(subareas, rooms.doors().to_vec(), OPTIONS.reach), Ok(rooms.clone()));
        let target = *ends[0].get(&free);
        let targets = vec![Target { id: 1, cell: target }];
        let lmpp = Lmpp::new(grid.clone(), MoveSet::Eight, rooms, targets);
        let mut workspace = Workspace::default();
        for start in ends.iter().skip(1).map(|end| *end.get(&free)) {
            let found = lmpp.survey(start).unwrap().length_to(1).is_some();
            let is_there = AStar::new(&grid, MoveSet::Eight).plan(start, target, &mut workspace).is_ok();
            prop_assert_eq!(found, is_there, "from {} to {}", start, target);
        }
    }
}
