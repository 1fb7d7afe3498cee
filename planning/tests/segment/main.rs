//! Derived subareas and doors: how good they are on maps whose rooms are known, and that no way is lost.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod known;

use std::collections::BTreeMap;

use planning::{
    grid::{Cell, Grid},
    lmpp::Lmpp,
    memory::Target,
    moves::MoveSet,
    rooms::{Rooms, Subareas},
    search::{AStar, Planner, Workspace},
    segment::{Options, segment},
};
use proptest::prelude::*;

use known::Known;

/// Those of `chargehand map` for a MovingAI map, and for cells of 5 cm.
const OPTIONS: Options = Options { door_width: 10, room_area: 30, clutter_area: 16, reach: 5 };
const OF_5_CM: Options = Options { door_width: 32, room_area: 800, clutter_area: 200, reach: 20 };

/// For each known room, the intersection over union with the derived subarea that covers most of it.
fn overlaps(known: &Known, derived: &Rooms) -> Vec<f64> {
    let (mut rooms, mut areas, mut both) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
    for cell in known.grid.free_cells() {
        let Some(room) = known.room(cell) else { continue };
        let area = derived.find_subarea(cell).unwrap();
        *rooms.entry(room).or_insert(0.0) += 1.0;
        *areas.entry(area).or_insert(0.0) += 1.0;
        *both.entry((room, area)).or_insert(0.0) += 1.0;
    }
    let best = |room| {
        let shared = both.iter().filter(|((of, _), _)| *of == room);
        shared.map(|((_, area), shared)| shared / (rooms[&room] + areas[area] - shared)).fold(0.0, f64::max)
    };
    rooms.keys().map(|&room| best(room)).collect()
}

/// How many of the known doors have a derived one within 5 cells of their line, and how many of the
/// derived have such a known one, as shares of 1.
fn recall_and_precision(known: &[Vec<Cell>], derived: &Rooms) -> (f64, f64) {
    let derived: Vec<Cell> = derived.doors().iter().map(|door| door.cell).collect();
    let is_near = |a: &Cell, b: &Cell| a.x.abs_diff(b.x).max(a.y.abs_diff(b.y)) <= 5;
    let meet = |line: &[Cell], door: &Cell| line.iter().any(|cell| is_near(cell, door));
    let found = known.iter().filter(|line| derived.iter().any(|door| meet(line, door))).count();
    let right = derived.iter().filter(|door| known.iter().any(|line| meet(line, door))).count();
    (found as f64 / known.len() as f64, right as f64 / derived.len().max(1) as f64)
}

/// Divides the map without the doors of its plan, prints the measures and returns them: mean overlap of the rooms, recall and precision of the doors.
fn evaluate(name: &str, known: &Known, options: Options) -> (f64, f64, f64) {
    let derived = segment(&known.grid, options, &[]);
    let overlaps = overlaps(known, &derived);
    let mean = overlaps.iter().sum::<f64>() / overlaps.len() as f64;
    let (recall, precision) = recall_and_precision(&known.doors, &derived);
    println!(
        "{name}: {} rooms known, {} derived, mean intersection over union {mean:.3}; {} doors known, {} \
         derived, recall {recall:.3}, precision {precision:.3} within 5 cells",
        overlaps.len(),
        derived.subareas().iter().count(),
        known.doors.len(),
        derived.doors().len(),
    );
    (mean, recall, precision)
}

#[test]
fn most_rooms_and_doors_of_fig_7_are_found_as_they_are_drawn() {
    let (mean, recall, precision) = evaluate("fig7", &known::fig7(), OPTIONS);
    assert!(mean > 0.75 && recall > 0.8 && precision > 0.5);
}

#[test]
fn nearly_all_rooms_and_doors_of_a_furnished_office_are_found() {
    let office = known::office500();
    assert_eq!((office.count(), office.doors.len()), (196, 286));
    let (mean, recall, precision) = evaluate("office500", &office, OPTIONS);
    assert!(mean > 0.9 && recall > 0.9 && precision > 0.9);
}

#[test]
fn rooms_and_doors_of_buildings_that_nothing_was_tuned_on_are_found() {
    let (mean, recall, precision) = evaluate("office of Open-RMF", &known::rmf_office(), OF_5_CM);
    assert!(mean > 0.9 && recall > 0.9 && precision > 0.9);
    let rooms = known::rmf_hotel_rooms();
    let (mean, recall, precision) = evaluate("hotel of Open-RMF, L2", &rooms, OF_5_CM);
    assert!(mean > 0.7 && recall > 0.8 && precision > 0.9);
}

#[test]
fn doors_wider_than_asked_for_are_none_and_are_found_when_asked_for() {
    let lobby = known::rmf_hotel_lobby();
    let (mean, recall, precision) = evaluate("hotel of Open-RMF, L1", &lobby, OF_5_CM);
    assert!(mean > 0.5 && recall < 0.5 && precision > 0.9);
    let wide = Options { door_width: 60, ..OF_5_CM };
    let (mean, recall, precision) = evaluate("hotel of Open-RMF, L1, doors of up to 3 m", &lobby, wide);
    assert!(mean > 0.9 && recall > 0.8 && precision > 0.8);
}

#[test]
fn a_hall_of_screens_is_one_room_unless_its_wide_openings_are_to_be_doors() {
    let hall = known::access_fig3();
    let (mean, ..) = evaluate("access-fig3", &hall, OPTIONS);
    assert!(mean < 0.2, "one room of nine");
    let wide = Options { door_width: 50, ..OPTIONS };
    let (mean, ..) = evaluate("access-fig3, doors of up to 50 cells", &hall, wide);
    assert!(mean > 0.6);
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
