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

/// How many of the known doors have a derived one within `near` cells, and how many of the derived a
/// known one, as shares of 1.
fn recall_and_precision(known: &[Cell], derived: &Rooms, near: u32) -> (f64, f64) {
    let derived: Vec<Cell> = derived.doors().iter().map(|door| door.cell).collect();
    let met = |these: &[Cell], those: &[Cell]| {
        let is_near = |a: &Cell, b: &Cell| a.x.abs_diff(b.x).max(a.y.abs_diff(b.y)) <= near;
        let met = these.iter().filter(|one| those.iter().any(|other| is_near(one, other))).count();
        met as f64 / these.len() as f64
    };
    (met(known, &derived), met(&derived, known))
}

/// Prints the measures and returns them: mean overlap of the rooms, recall and precision of the doors.
fn evaluate(name: &str, grid: &Grid, known: &Subareas, doors: &[Cell]) -> (f64, f64, f64) {
    let derived = segment(grid, OPTIONS, &[]);
    let overlaps = overlaps(grid, known, &derived);
    let mean = overlaps.values().sum::<f64>() / overlaps.len() as f64;
    let (recall, precision) = recall_and_precision(doors, &derived, 5);
    println!(
        "{name}: {} rooms known, {} derived, mean intersection over union {mean:.3}; {} doors known, {} \
         derived, recall {recall:.3}, precision {precision:.3} within 5 cells",
        known.iter().count(),
        derived.subareas().iter().count(),
        doors.len(),
        derived.doors().len(),
    );
    (mean, recall, precision)
}

#[test]
fn most_rooms_and_doors_of_fig_7_are_found_as_they_are_drawn() {
    let grid = read_map(include_str!("../../sites/lmpp-fig7/fig7.map")).unwrap();
    let known = Subareas::read(include_str!("../../sites/lmpp-fig7/subareas.txt"), &grid).unwrap();
    // Of the site file, which counts from 1 and upwards.
    let doors = [(24, 70), (26, 70), (70, 55), (75, 70), (33, 30), (27, 28), (55, 70)];
    let doors = doors.map(|(x, y)| Cell { x: x - 1, y: 100 - y });
    let (mean, recall, precision) = evaluate("fig7", &grid, &known, &doors);
    assert!(mean > 0.75 && recall > 0.8 && precision > 0.5);
}

#[test]
fn nearly_all_rooms_and_doors_of_a_furnished_office_are_found() {
    let grid = read_map(include_str!("data/bench/office500.map")).unwrap();
    // Made of walls in every 36th row and column, with openings of three cells.
    let is_wall = |place: i32| place % 36 == 0 || place == 499;
    let name = |place: i32| u32::try_from((place - 1) / 36).unwrap();
    let mut picture = String::new();
    let mut doors = Vec::new();
    for y in 0..500 {
        for x in 0..500 {
            let cell = Cell { x, y };
            let room = name(y) * 14 + name(x);
            picture.push(if grid.is_free(cell) { char::from_u32(0x4e00 + room).unwrap() } else { '@' });
            let (along_x, along_y) = (is_wall(y) && !is_wall(x), is_wall(x) && !is_wall(y));
            let middle = |dx, dy| (-1..=1).all(|step| grid.is_free(cell.offset(dx * step, dy * step)));
            if along_x && middle(1, 0) || along_y && middle(0, 1) {
                doors.push(cell);
            }
        }
        picture.push('\n');
    }
    let known = Subareas::read(&picture, &grid).unwrap();
    assert_eq!((known.iter().count(), doors.len()), (196, 286));
    let (mean, recall, precision) = evaluate("office500", &grid, &known, &doors);
    assert!(mean > 0.9 && recall > 0.9 && precision > 0.9);
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
