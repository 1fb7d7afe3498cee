//! What must hold on every map: LMPP is never shorter than A*, and closed doors are never passed.
#![allow(clippy::unwrap_used)]

use std::collections::{BTreeMap, BTreeSet};

use planning::{
    formats::movingai::read_map,
    grid::{Cell, Grid},
    lmpp::Lmpp,
    memory::Target,
    moves::{Length, MoveSet},
    rooms::{Door, DoorId, Rooms, SubareaId, Subareas},
    search::{AStar, Planner, Workspace},
};
use proptest::{prelude::*, sample::Index};

fn move_sets() -> impl Strategy<Value = MoveSet> {
    prop::sample::select(vec![MoveSet::Eight, MoveSet::Sixteen])
}

/// A floor of rooms, `columns` by `rows`, with walls one cell thick and doors of one cell.
#[derive(Debug)]
struct Floor {
    grid: Grid,
    rooms: Rooms,
    piles: Vec<Target>,
}

const ROOM: i32 = 7;

/// Every wall between two rooms has a door or not; a door's cell belongs to one of the two.
fn floors() -> impl Strategy<Value = Floor> {
    (1i32..4, 1i32..4).prop_flat_map(|(columns, rows)| {
        let doors =
            prop::collection::vec((prop::bool::weighted(0.8), 0..ROOM), (2 * columns * rows) as usize);
        let piles = prop::collection::vec(any::<Index>(), 1..6);
        let tables = prop::collection::vec(any::<Index>(), 0..20);
        (doors, piles, tables)
            .prop_map(move |(doors, piles, tables)| floor(columns, rows, &doors, &piles, &tables))
    })
}

fn floor(columns: i32, rows: i32, doors: &[(bool, i32)], piles: &[Index], tables: &[Index]) -> Floor {
    let side = ROOM + 1;
    let mut grid = Grid::blocked((columns * side) as u32, (rows * side) as u32).unwrap();
    let mut names = vec!['@'; grid.len()];
    let mut free = |cell: Cell, room: i32, grid: &mut Grid| {
        grid.set(cell, true);
        names[grid.index(cell).unwrap()] = char::from(b'a' + room as u8);
    };
    let mut placed = Vec::new();
    let mut doors = doors.iter();
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let room = row * columns + column;
        let corner = Cell { x: column * side, y: row * side };
        for (dx, dy) in (0..ROOM).flat_map(|dy| (0..ROOM).map(move |dx| (dx, dy))) {
            free(corner.offset(dx, dy), room, &mut grid);
        }
        let mut door = |there: bool, next: i32, dx: i32, dy: i32| {
            let &(open, at) = doors.next().unwrap();
            if there && open {
                let cell = corner.offset(if dx == 0 { at } else { dx }, if dy == 0 { at } else { dy });
                free(cell, room, &mut grid);
                placed.push((cell, [room, next]));
            }
        };
        door(column + 1 < columns, room + 1, ROOM, 0);
        door(row + 1 < rows, room + columns, 0, ROOM);
    }
    // Tables stand in the rooms' middles, so that doors stay free.
    for table in tables {
        let room = table.index((columns * rows) as usize) as i32;
        let spot = table.index(9) as i32;
        let cell = Cell { x: room % columns * side + 2 + spot % 3, y: room / columns * side + 2 + spot / 3 };
        grid.set(cell, false);
        names[grid.index(cell).unwrap()] = '@';
    }
    let text: Vec<String> = names.chunks(grid.width() as usize).map(|row| row.iter().collect()).collect();
    let subareas = Subareas::read(&text.join("\n"), &grid).unwrap();
    let named = |room: i32| -> SubareaId { subareas.named(char::from(b'a' + room as u8)).unwrap() };
    let doors = (1..)
        .zip(placed)
        .map(|(id, (cell, joins))| Door { id: DoorId(id), cell, joins: joins.map(named) })
        .collect();
    let cells: Vec<Cell> = grid.free_cells().collect();
    let piles =
        (1..).zip(piles).map(|(id, place)| Target { id, cell: cells[place.index(cells.len())] }).collect();
    let rooms = Rooms::new(subareas, doors, 2).unwrap();
    Floor { grid, rooms, piles }
}

/// The shortest chain of paths in M2 from one door to another, the plainest way: every door's length is
/// lowered over every path until nothing changes.
fn chain(lmpp: &Lmpp, from: DoorId, to: DoorId) -> Option<Length> {
    let mut lengths = BTreeMap::from([(from, Length::default())]);
    loop {
        let before = lengths.clone();
        for (&door, &length) in &before {
            for (next, leg, _) in lmpp.banks().from_door(door) {
                let known = lengths.entry(next).or_insert(length + leg.length);
                *known = (*known).min(length + leg.length);
            }
        }
        if lengths == before {
            return lengths.get(&to).copied();
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn lmpp_is_never_shorter_than_a_star_and_as_short_where_doors_are_the_only_way(
        floor in floors(), moves in move_sets(), from in any::<Index>(),
    ) {
        let Floor { grid, rooms, piles } = floor;
        let cells: Vec<Cell> = grid.free_cells().collect();
        let from = cells[from.index(cells.len())];
        let mut workspace = Workspace::default();
        let lmpp = Lmpp::new(grid.clone(), moves, rooms.clone(), piles.clone());
        let survey = lmpp.survey(from).unwrap();
        for pile in piles {
            let shortest = AStar::new(&grid, moves).plan(from, pile.cell, &mut workspace);
            let shortest = shortest.map(|plan| plan.path.length());
            // Doors of one cell in walls of one cell: every path between rooms runs through doors.
            // A robot or pile in a door's cell is in one of its rooms by name only.
            let at_door = rooms.doors().iter().any(|door| door.cell == from || door.cell == pile.cell);
            let Some(route) = survey.route_to(pile.id) else {
                prop_assert!(shortest.is_err() || at_door, "no way from {} to {}", from, pile.cell);
                continue;
            };
            prop_assert!(route.path.is_walkable(&grid, moves));
            prop_assert_eq!((route.path.start(), route.path.end()), (from, pile.cell));
            prop_assert_eq!(survey.length_to(pile.id), Some(route.path.length()));
            let shortest = shortest.unwrap();
            prop_assert!(route.path.length() >= shortest);
            if !at_door {
                prop_assert_eq!(route.path.length(), shortest, "from {} to {}", from, pile.cell);
            }
        }
    }

    #[test]
    fn lmpp_is_never_longer_than_algorithm_6_that_keeps_the_shortest(
        floor in floors(), moves in move_sets(), from in any::<Index>(),
    ) {
        let Floor { grid, rooms, piles } = floor;
        let cells: Vec<Cell> = grid.free_cells().collect();
        let from = cells[from.index(cells.len())];
        let lmpp = Lmpp::new(grid.clone(), moves, rooms.clone(), piles.clone());
        let survey = lmpp.survey(from).unwrap();
        let mut workspace = Workspace::default();
        let mut length = |from, to| {
            AStar::new(&grid, moves).plan(from, to, &mut workspace).ok().map(|plan| plan.path.length())
        };
        let own = rooms.find_subarea(from).unwrap();
        for pile in piles {
            let theirs = rooms.find_subarea(pile.cell).unwrap();
            let by_algorithm_6 = if own == theirs {
                length(from, pile.cell)
            } else {
                let pairs = rooms.doors_of(own).flat_map(|one| rooms.doors_of(theirs).map(move |other| (one, other)));
                let ways = pairs.filter_map(|(one, other)| {
                    Some(length(from, one.cell)? + chain(&lmpp, one.id, other.id)? + length(other.cell, pile.cell)?)
                });
                ways.min()
            };
            let recalled = survey.length_to(pile.id);
            prop_assert!(by_algorithm_6.is_none() || recalled.is_some());
            prop_assert!(recalled <= by_algorithm_6 || by_algorithm_6.is_none(), "{recalled:?}, {by_algorithm_6:?}");
        }
    }

    #[test]
    fn closed_doors_are_never_passed(
        floor in floors(), moves in move_sets(), from in any::<Index>(), closed in prop::collection::btree_set(1u16..9, 0..5),
    ) {
        let Floor { grid, rooms, piles } = floor;
        let cells: Vec<Cell> = grid.free_cells().collect();
        let from = cells[from.index(cells.len())];
        let closed: BTreeSet<_> = closed.into_iter().map(DoorId).collect();
        let mut lmpp = Lmpp::new(grid, moves, rooms.clone(), piles.clone());
        lmpp.close(closed.clone());
        let survey = lmpp.survey(from).unwrap();
        for route in piles.iter().filter_map(|pile| survey.route_to(pile.id)) {
            prop_assert!(route.doors.iter().all(|door| !closed.contains(door)));
            for door in rooms.doors().iter().filter(|door| closed.contains(&door.id) && door.cell != from) {
                prop_assert!(route.path.cells().all(|cell| cell != door.cell), "through door {}", door.id);
            }
        }
        // What is opened again is as if it had never been closed.
        let open = Lmpp::new(lmpp.grid().clone(), moves, rooms, piles.clone());
        lmpp.close(BTreeSet::new());
        let before: Vec<_> = open.survey(from).unwrap().lengths().collect();
        let after: Vec<_> = lmpp.survey(from).unwrap().lengths().collect();
        prop_assert_eq!(before, after);
    }
}

#[test]
fn a_door_in_no_opening_is_refused() {
    let grid = read_map(&format!(
        "type octile\nheight 20\nwidth 41\nmap\n{}",
        "....................@....................\n".repeat(20)
    ))
    .unwrap();
    let text = format!("{}@{}\n", "a".repeat(20), "b".repeat(20)).repeat(20);
    let subareas = Subareas::read(&text, &grid).unwrap();
    let joins = ['a', 'b'].map(|name| subareas.named(name).unwrap());
    let errors = |x, y, joins| {
        let doors = vec![Door { id: DoorId(1), cell: Cell { x, y }, joins }];
        Rooms::new(subareas.clone(), doors, 3)
            .unwrap_err()
            .iter()
            .map(ToString::to_string)
            .collect::<Vec<_>>()
    };
    assert_eq!(errors(10, 10, joins), ["door 1 is in no wall: expected a blocked cell within 3 cells of it"]);
    assert_eq!(
        errors(17, 10, joins),
        ["door 1 does not lead to subarea b: expected an opening to it within 3 cells of the door"]
    );
    // Subarea b is two cells away, but the wall between is unbroken.
    assert_eq!(
        errors(19, 10, joins),
        ["door 1 does not lead to subarea b: expected an opening to it within 3 cells of the door"]
    );
    assert_eq!(
        errors(20, 10, joins),
        ["door 1 is in a wall or outside the map: put it on a free cell of the opening"]
    );
    assert_eq!(
        errors(19, 10, [joins[0]; 2]),
        ["door 1 joins a subarea to itself: name the two that it joins"]
    );
}
