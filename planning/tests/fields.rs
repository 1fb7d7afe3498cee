//! What must hold of fields on every map: they are what Dijkstra's algorithm finds, and every way that
//! they give can be gone.
#![allow(clippy::unwrap_used)]

use planning::{
    grid::{Cell, Grid},
    memory::{Fields, FileError, Memory},
    moves::MoveSet,
    path::Path,
    search::{Dijkstra, Planner, SearchError, Workspace},
};
use proptest::{prelude::*, sample::Index};

fn move_sets() -> impl Strategy<Value = MoveSet> {
    prop::sample::select(vec![MoveSet::Eight, MoveSet::Sixteen])
}

/// A map of random cells, from open to almost closed, down to one row or column.
fn maps() -> impl Strategy<Value = Grid> {
    (prop_oneof![1u32..40, 60u32..70], 1u32..24, 0.5..1.0).prop_flat_map(|(width, height, free)| {
        prop::collection::vec(prop::bool::weighted(free), (width * height) as usize).prop_map(move |cells| {
            let mut grid = Grid::blocked(width, height).unwrap();
            for (index, free) in cells.into_iter().enumerate() {
                grid.set(grid.cell(index), free);
            }
            grid
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn fields_are_what_dijkstra_finds_and_their_ways_can_be_gone(
        grid in maps(), moves in move_sets(), targets in prop::collection::vec(any::<Index>(), 0..20),
    ) {
        let targets: Vec<Cell> = targets.into_iter().map(|target| grid.cell(target.index(grid.len()))).collect();
        let fields = Fields::build(grid.clone(), moves, &targets);
        let mut workspace = Workspace::default();
        let mut path = Path::default();
        for (number, &target) in targets.iter().enumerate() {
            let ways = Dijkstra::new(&grid, moves).ways(target, &[], &mut workspace).ok();
            for from in (0..grid.len()).map(|index| grid.cell(index)) {
                let length = ways.as_ref().and_then(|ways| ways.length_to(from));
                prop_assert_eq!(fields.length(from, number), length, "from {} to {}", from, target);
                prop_assert_eq!(fields.walk(from, number, &mut path), length.is_some());
                if let Some(length) = length {
                    prop_assert_eq!((path.start(), path.end(), path.length()), (from, target, length));
                    prop_assert_eq!(path.steps().map(planning::moves::Length::of).sum::<planning::moves::Length>(), length);
                    prop_assert!(path.is_walkable(&grid, moves));
                }
            }
        }
        for from in (0..grid.len()).map(|index| grid.cell(index)) {
            let lengths: Vec<_> = fields.lengths(from).collect();
            let each: Vec<_> = (0..targets.len()).map(|target| fields.length(from, target)).collect();
            prop_assert_eq!(&lengths, &each);
            let nearest = (0..).zip(each).filter_map(|(target, length)| Some((length?, target))).min();
            prop_assert_eq!(fields.nearest(from), nearest.map(|(length, target)| (target, length)));
            for (cells, length) in fields.distances(from).zip(lengths) {
                prop_assert!(length.map_or(cells.is_infinite(), |length| (length.units() - cells).abs() < 1e-6));
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn fields_of_a_map_that_changed_are_as_if_built_of_it(
        grid in maps(), moves in move_sets(), targets in prop::collection::vec(any::<Index>(), 1..5),
        changes in prop::collection::vec(prop::collection::vec((any::<Index>(), any::<bool>()), 1..6), 1..8),
    ) {
        let cell = |index: Index| grid.cell(index.index(grid.len()));
        let cell_at = |index| grid.cell(index);
        let targets: Vec<Cell> = targets.into_iter().map(cell).collect();
        let mut fields = Fields::build(grid.clone(), moves, &targets);
        for changes in changes {
            let repaired = fields.change(changes.into_iter().map(|(index, free)| (cell(index), free)));
            prop_assert!([0, targets.len()].contains(&(repaired.repaired + repaired.rebuilt)));
            let fresh = Fields::build(fields.grid().clone(), moves, &targets);
            for from in (0..grid.len()).map(cell_at) {
                prop_assert_eq!(fields.lengths(from).collect::<Vec<_>>(), fresh.lengths(from).collect::<Vec<_>>(), "from {}", from);
            }
            prop_assert!(fields == fresh, "a move or run differs; {repaired:?}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn fields_are_read_from_bytes_as_they_were_and_go_on_to_change(
        grid in maps(), moves in move_sets(), targets in prop::collection::vec(any::<Index>(), 0..5),
        changes in prop::collection::vec((any::<Index>(), any::<bool>()), 1..6), unaligned in any::<bool>(),
    ) {
        let targets: Vec<Cell> = targets.into_iter().map(|target| grid.cell(target.index(grid.len()))).collect();
        let mut built = Fields::build(grid.clone(), moves, &targets);
        let mut read = Fields::open(grid.clone(), moves, &targets, kept(built.to_bytes(), unaligned)).unwrap();
        prop_assert!(read == built && read.clone() == built);
        let changes: Vec<_> = changes.into_iter().map(|(cell, free)| (grid.cell(cell.index(grid.len())), free)).collect();
        read.change(changes.clone());
        built.change(changes);
        prop_assert!(read == built);
        prop_assert_eq!(read.to_bytes(), built.to_bytes());
    }

    #[test]
    fn bytes_that_were_cut_off_or_changed_are_refused(
        grid in maps(), moves in move_sets(), targets in prop::collection::vec(any::<Index>(), 0..3),
        at in any::<Index>(), bit in 0u32..8, unaligned in any::<bool>(),
    ) {
        let targets: Vec<Cell> = targets.into_iter().map(|target| grid.cell(target.index(grid.len()))).collect();
        let bytes = Fields::build(grid.clone(), moves, &targets).to_bytes();
        let open = |bytes| Fields::open(grid.clone(), moves, &targets, kept(bytes, unaligned));
        let mut cut = bytes.clone();
        cut.truncate(at.index(bytes.len()));
        let is_short = matches!(open(cut), Err(FileError::Foreign | FileError::Length { .. }));
        prop_assert!(is_short);
        let mut longer = bytes.clone();
        longer.push(0);
        let is_long = matches!(open(longer), Err(FileError::Length { .. }));
        prop_assert!(is_long);
        let mut flipped = bytes.clone();
        flipped[at.index(bytes.len())] ^= 1 << bit;
        prop_assert!(open(flipped).is_err());
    }

    #[test]
    fn no_bytes_make_the_reader_panic(
        grid in maps(), moves in move_sets(), mut bytes in prop::collection::vec(any::<u8>(), 0..300),
        like in any::<bool>(),
    ) {
        if like {
            let header = Fields::build(grid.clone(), moves, &[]).to_bytes();
            bytes.iter_mut().zip(header).take(56).for_each(|(to, from)| *to = from);
        }
        prop_assert!(Fields::open(grid, moves, &[], Box::new(bytes)).is_err());
    }
}

/// Bytes in memory, at an address that suits the tables or does not.
fn kept(bytes: Vec<u8>, unaligned: bool) -> Box<dyn Memory> {
    struct Shifted(Vec<u8>, usize);
    impl AsRef<[u8]> for Shifted {
        fn as_ref(&self) -> &[u8] {
            &self.0[self.1..]
        }
    }
    impl AsMut<[u8]> for Shifted {
        fn as_mut(&mut self) -> &mut [u8] {
            &mut self.0[self.1..]
        }
    }
    let mut memory = vec![0; bytes.len() + 8];
    let shift = memory.as_ptr().align_offset(8) + usize::from(unaligned);
    memory.truncate(bytes.len() + shift);
    memory[shift..].copy_from_slice(&bytes);
    Box::new(Shifted(memory, shift))
}

#[test]
fn fields_of_another_map_other_targets_moves_or_version_are_told_apart() {
    let map = |cells| {
        planning::formats::movingai::read_map(&format!("type octile\nheight 1\nwidth 5\nmap\n{cells}\n"))
            .unwrap()
    };
    let (grid, target) = (map("..@.."), [Cell { x: 1, y: 0 }]);
    let bytes = Fields::build(grid.clone(), MoveSet::Eight, &target).to_bytes();
    let error = |grid: &Grid, moves, targets: &[Cell], bytes: &[u8]| {
        Fields::open(grid.clone(), moves, targets, Box::new(bytes.to_vec()))
            .err()
            .map(|error| error.to_string())
    };
    assert_eq!(error(&grid, MoveSet::Eight, &target, &bytes), None);
    let others = |what| Some(format!("fields of {what} than asked for: build them again"));
    assert_eq!(error(&map("....."), MoveSet::Eight, &target, &bytes), others("another map"));
    assert_eq!(error(&Grid::blocked(5, 2).unwrap(), MoveSet::Eight, &target, &bytes), others("another map"));
    assert_eq!(error(&grid, MoveSet::Sixteen, &target, &bytes), others("other moves"));
    assert_eq!(error(&grid, MoveSet::Eight, &[Cell { x: 0, y: 0 }], &bytes), others("other targets"));
    assert_eq!(error(&grid, MoveSet::Eight, &[], &bytes), others("other targets"));
    let mut newer = bytes.clone();
    newer[8] = 3;
    let expected = "fields of version 3: expected 2; build them again";
    assert_eq!(error(&grid, MoveSet::Eight, &target, &newer).unwrap(), expected);
    let mut swapped = bytes.clone();
    swapped[16..24].reverse();
    assert!(error(&grid, MoveSet::Eight, &target, &swapped).unwrap().contains("another order of bytes"));
    assert!(error(&grid, MoveSet::Eight, &target, b"SQLite format 3").unwrap().contains("no fields"));
}

#[test]
fn a_field_as_a_planner_says_what_is_wrong_with_an_end() {
    let grid = planning::formats::movingai::read_map("type octile\nheight 1\nwidth 5\nmap\n..@..\n").unwrap();
    let cell = |x| Cell { x, y: 0 };
    let fields = Fields::build(grid, MoveSet::Eight, &[cell(0), cell(2), cell(4)]);
    let mut path = Path::default();
    let mut plan =
        |from, to| fields.plan(cell(from), cell(to), &mut path).map(|plan| plan.path.length().straight);
    assert_eq!(plan(1, 0), Ok(1));
    assert_eq!(plan(1, 4), Err(SearchError::NoPath { from: cell(1), to: cell(4) }));
    assert_eq!(plan(1, 2), Err(SearchError::Blocked { cell: cell(2) }));
    assert_eq!(plan(2, 4), Err(SearchError::Blocked { cell: cell(2) }));
    assert_eq!(plan(0, 1), Err(SearchError::NoTarget { cell: cell(1) }));
    assert_eq!(plan(5, 0), Err(SearchError::Outside { cell: cell(5), width: 5, height: 1 }));
}
