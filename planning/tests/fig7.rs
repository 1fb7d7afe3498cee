//! Every length that LMPP prints (Tables 6, 10 and 14, Test 3), as exact counts of moves.
//!
//! The paper's runs differ in which doors a robot was offered; `sites/lmpp-fig7/README.md` says how
//! far to trust the map.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;

use planning::{
    congestion::avoided,
    formats::movingai::read_map,
    grid::{Cell, Grid},
    lmpp::Lmpp,
    memory::{DoorSets, Target},
    moves::{Length, MoveSet},
    rooms::{Door, DoorId, Rooms, Subareas},
    search::{AStar, Planner, Workspace},
};

const MAP: &str = include_str!("../../sites/lmpp-fig7/fig7.map");
const SUBAREAS: &str = include_str!("../../sites/lmpp-fig7/subareas.txt");

/// Coordinates in the paper's frame: from 1, y up.
type Point = (i32, i32);

const DOORS: [(u16, Point, [char; 2]); 7] = [
    (1, (24, 70), ['A', 'K']),
    (2, (26, 70), ['B', 'K']),
    (3, (70, 55), ['K', 'H']),
    (4, (75, 70), ['D', 'H']),
    (5, (33, 30), ['H', 'J']),
    (6, (27, 28), ['J', 'L']),
    (7, (55, 70), ['C', 'K']),
];

/// Table 12.
const CONGESTION: [(u16, f64); 7] =
    [(1, 0.45), (2, 0.12), (3, 0.09), (4, 0.77), (5, 0.09), (6, 0.35), (7, 0.05)];

/// Table 3's places as they act, and whether the pile is idle (in Q1).
const PILES: [(u16, Point, bool); 13] = [
    (1, (1, 100), true),
    (2, (50, 70), true),
    (3, (68, 100), false),
    (4, (100, 100), true),
    (5, (1, 70), false),
    (6, (100, 70), false),
    (7, (1, 50), true),
    (8, (40, 50), true),
    (9, (100, 29), false),
    (10, (1, 1), true),
    (11, (20, 1), false),
    (12, (100, 1), true),
    (13, (67, 20), true),
];

fn cell((x, y): Point) -> Cell {
    Cell { x: x - 1, y: 100 - y }
}

fn grid() -> Grid {
    read_map(MAP).unwrap()
}

fn rooms() -> Rooms {
    let subareas = Subareas::read(SUBAREAS, &grid()).unwrap();
    let joins = |names: [char; 2]| names.map(|name| subareas.named(name).unwrap());
    let doors = DOORS.map(|(id, at, names)| Door { id: DoorId(id), cell: cell(at), joins: joins(names) });
    Rooms::new(subareas, doors.to_vec(), 5).unwrap()
}

fn piles() -> Vec<Target> {
    PILES.map(|(id, at, _)| Target { id, cell: cell(at) }).to_vec()
}

/// Tests 1 and 5: each subarea has its own doors.
fn as_drawn() -> Lmpp {
    Lmpp::new(grid(), MoveSet::Sixteen, rooms(), piles())
}

/// Tests 3 and 4: a robot in the hall may make straight for doors 1 and 2, door 4 is linked to
/// them, and a robot in the corridor is offered doors 3 and 7 only.
fn as_run() -> Lmpp {
    let rooms = rooms();
    let mut sets = DoorSets::of(&rooms);
    let named = |name| rooms.subareas().named(name).unwrap();
    sets.exits.get_mut(&named('H')).unwrap().extend([DoorId(1), DoorId(2)]);
    sets.exits.insert(named('K'), BTreeSet::from([DoorId(3), DoorId(7)]));
    sets.pairs.extend([(DoorId(1), DoorId(4)), (DoorId(2), DoorId(4))]);
    Lmpp::with_door_sets(grid(), MoveSet::Sixteen, rooms, piles(), sets)
}

const fn length(straight: u32, diagonal: u32, knight: u32) -> Length {
    Length { straight, diagonal, knight }
}

/// Checks the nearest pile, its length and the doors on the way, and that the path is one.
fn assert_nearest(lmpp: &Lmpp, from: Point, pile: u16, expected: Length, doors: &[u16]) {
    let survey = lmpp.survey(cell(from)).unwrap();
    assert_eq!(survey.nearest(), Some((pile, expected)), "nearest pile from {from:?}");
    let route = survey.route_to(pile).unwrap();
    assert_eq!(route.path.length(), expected, "path from {from:?}");
    assert_eq!(route.path.steps().map(Length::of).sum::<Length>(), expected, "moves from {from:?}");
    assert_eq!(route.doors, doors.iter().map(|&id| DoorId(id)).collect::<Vec<_>>(), "doors from {from:?}");
    assert!(route.path.is_walkable(&grid(), MoveSet::Sixteen), "path from {from:?}");
}

fn assert_printed(expected: Length, printed: &str) {
    let decimals = printed.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    let error = (expected.units() - printed.parse::<f64>().unwrap()).abs();
    // Half a unit of the last digit, and a little for the authors' single precision.
    assert!(error <= 0.51 * 10f64.powi(-(decimals.min(13) as i32)), "{expected:?} is not {printed}");
}

#[test]
fn table_6_lengths_by_a_star_and_by_lmpp() {
    let (grid, lmpp) = (grid(), as_drawn());
    // Start, nearest pile by A*, A*'s length, LMPP's length, LMPP's doors.
    type Row<'a> = (Point, u16, &'a str, Length, &'a str, Length, &'a [u16]);
    let rows: [Row<'_>; 10] = [
        ((92, 13), 12, "14.6011261594915", length(0, 4, 4), "14.6011261594915", length(0, 4, 4), &[]),
        ((10, 64), 5, "39.4721359549996", length(35, 0, 2), "40.7082039324994", length(34, 0, 3), &[1]),
        ((55, 28), 13, "14.6011261594915", length(0, 4, 4), "14.6011261594915", length(0, 4, 4), &[]),
        ((97, 96), 4, "5.06449510224598", length(0, 2, 1), "5.06449510224598", length(0, 2, 1), &[]),
        ((98, 16), 12, "15.4721359549996", length(11, 0, 2), "15.4721359549996", length(11, 0, 2), &[]),
        ((49, 96), 2, "26.2360679774998", length(24, 0, 1), "26.2360679774998", length(24, 0, 1), &[]),
        ((15, 81), 5, "18.0219124314841", length(0, 8, 3), "18.0219124314841", length(0, 8, 3), &[]),
        ((92, 43), 9, "16.2448349897449", length(0, 2, 6), "16.2448349897449", length(0, 2, 6), &[]),
        ((96, 80), 6, "10.9442719099992", length(2, 0, 4), "10.9442719099992", length(2, 0, 4), &[]),
        ((4, 66), 5, "45", length(45, 0, 0), "46.2360679774998", length(44, 0, 1), &[1]),
    ];
    let mut workspace = Workspace::default();
    for (from, pile, printed_astar, by_astar, printed_lmpp, by_lmpp, doors) in rows {
        let shortest = piles()
            .iter()
            .filter_map(|pile| {
                let found =
                    AStar::new(&grid, MoveSet::Sixteen).plan(cell(from), pile.cell, &mut workspace).ok()?;
                Some((found.path.length(), pile.id))
            })
            .min();
        assert_eq!(shortest, Some((by_astar, pile)), "A* from {from:?}");
        assert_printed(by_astar, printed_astar);
        assert_nearest(&lmpp, from, pile, by_lmpp, doors);
        assert_printed(by_lmpp, printed_lmpp);
    }
}

#[test]
fn table_14_lengths_with_and_without_door_avoidance() {
    let open = as_drawn();
    let mut avoiding = as_drawn();
    avoiding.close(avoided(CONGESTION.map(|(id, rho)| (DoorId(id), rho)), 0.3));
    assert_eq!(*avoiding.closed(), BTreeSet::from([1, 4, 6].map(DoorId)));
    type Case<'a> = (u16, &'a str, Length, &'a [u16]);
    // Start, without avoidance, with it where that differs.
    let rows: [(Point, Case<'_>, Option<Case<'_>>); 10] = [
        ((70, 13), (13, "7.70820393249937", length(1, 0, 3), &[]), None),
        (
            (40, 64),
            (5, "41.5366310572456", length(32, 2, 3), &[1]),
            Some((2, "41.7082039324994", length(35, 0, 3), &[2])),
        ),
        ((55, 28), (13, "14.6011261594915", length(0, 4, 4), &[]), None),
        ((50, 96), (2, "26", length(26, 0, 0), &[]), None),
        ((67, 32), (13, "12.4721359549996", length(8, 0, 2), &[]), None),
        ((49, 60), (3, "45.1978739119892", length(6, 4, 15), &[7]), None),
        ((15, 81), (5, "18.0219124314841", length(0, 8, 3), &[]), None),
        ((92, 43), (9, "16.2448349897449", length(0, 2, 6), &[]), None),
        ((96, 80), (6, "10.9442719099992", length(2, 0, 4), &[]), None),
        (
            (44, 66),
            (5, "45.0644951022460", length(40, 2, 1), &[1]),
            Some((2, "45.2360679774998", length(43, 0, 1), &[2])),
        ),
    ];
    for (from, without, with) in rows {
        for (lmpp, (pile, printed, expected, doors)) in
            [(&open, without), (&avoiding, with.unwrap_or(without))]
        {
            assert_nearest(lmpp, from, pile, expected, doors);
            assert_printed(expected, printed);
        }
    }
}

#[test]
fn test_3_and_table_10_extremes_of_idle_and_busy_piles() {
    let lmpp = as_run();
    // Start, then pile and length: max Q1, min Q1, max Q2, min Q2.
    type Extreme<'a> = (u16, &'a str, Length);
    let rows: [(Point, [Extreme<'_>; 4]); 7] = [
        (
            (80, 50),
            [
                (1, "103.5848", length(34, 16, 21)),
                (13, "38.88854", length(21, 0, 8)),
                (11, "88.67878", length(31, 6, 22)),
                (9, "29.56512", length(0, 13, 5)),
            ],
        ),
        (
            (92, 43),
            [
                (1, "117.2373", length(32, 16, 28)),
                (13, "38.08203", length(5, 6, 11)),
                (5, "101.5498", length(54, 2, 20)),
                (9, "16.24483", length(0, 2, 6)),
            ],
        ),
        (
            (96, 80),
            [
                (1, "139.9455", length(48, 16, 31)),
                (4, "41.67219", length(20, 9, 4)),
                (11, "126.5805", length(47, 12, 28)),
                (6, "10.94427", length(2, 0, 4)),
            ],
        ),
        (
            (4, 66),
            [
                (10, "160.526", length(57, 40, 21)),
                (8, "101.4831", length(71, 1, 13)),
                (11, "152.1215", length(73, 18, 24)),
                (3, "87.30495", length(56, 0, 14)),
            ],
        ),
        (
            (40, 75),
            [
                (10, "156.9424", length(40, 40, 27)),
                (2, "11.18034", length(0, 0, 5)),
                (11, "148.5379", length(56, 18, 30)),
                (5, "40.18034", length(29, 0, 5)),
            ],
        ),
        (
            (18, 66),
            [
                (10, "146.526", length(43, 40, 21)),
                (8, "87.4831", length(57, 1, 13)),
                (11, "138.1215", length(59, 18, 24)),
                (3, "73.30495", length(42, 0, 14)),
            ],
        ),
        (
            (4, 71),
            [
                (10, "162.8265", length(52, 42, 23)),
                (1, "29.7082", length(23, 0, 3)),
                (11, "154.422", length(68, 20, 26)),
                (5, "3.236068", length(1, 0, 1)),
            ],
        ),
    ];
    for (from, extremes) in rows {
        let survey = lmpp.survey(cell(from)).unwrap();
        let idle = |id| PILES.iter().any(|&(pile, _, idle)| pile == id && idle);
        let lengths = |in_q1: bool| {
            survey.lengths().filter(move |&(id, _)| idle(id) == in_q1).map(|(id, length)| (length, id))
        };
        let ours = [lengths(true).max(), lengths(true).min(), lengths(false).max(), lengths(false).min()];
        for (ours, (pile, printed, expected)) in ours.into_iter().zip(extremes) {
            assert_eq!(ours, Some((expected, pile)), "from {from:?}");
            assert_printed(expected, printed);
        }
    }
}
