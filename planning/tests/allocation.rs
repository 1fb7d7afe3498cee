//! A workspace that has answered some queries answers them again without allocating.
#![allow(clippy::unwrap_used)]

use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::Cell as Counter,
};

use planning::{
    formats::movingai::read_map,
    grid::{Cell, Grid},
    moves::MoveSet,
    search::{AStar, Dijkstra, Jps, Planner},
};

/// Counts what each thread asks for.
struct Counting;

thread_local! {
    static ALLOCATIONS: Counter<usize> = const { Counter::new(0) };
}

// SAFETY: all is done by the system's allocator; the counter has no destructor and allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller keeps the promises of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the memory came from `System`.
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// How often a planner allocates in all queries between some cells when it has answered them before.
fn allocations<P: Planner>(planner: &P, cells: &[Cell]) -> usize {
    let mut workspace = P::Workspace::default();
    let mut round = || {
        let before = ALLOCATIONS.get();
        for (&from, &to) in cells.iter().flat_map(|from| cells.iter().map(move |to| (from, to))) {
            assert!(planner.plan(from, to, &mut workspace).is_ok());
        }
        ALLOCATIONS.get() - before
    };
    assert!(round() > 0, "the first round is counted");
    round()
}

#[test]
fn no_search_allocates_after_its_first_queries() {
    let grid: Grid = read_map(include_str!("data/bench/arena2.map")).unwrap();
    let mut workspace = Default::default();
    let start = grid.free_cells().nth(grid.len() / 4).unwrap();
    let ways = Dijkstra::new(&grid, MoveSet::Eight).ways(start, &[], &mut workspace).unwrap();
    let cells: Vec<_> = grid.free_cells().filter(|&cell| ways.leads_to(cell)).step_by(4999).collect();
    assert!(cells.len() > 3);
    for moves in [MoveSet::Eight, MoveSet::Sixteen] {
        assert_eq!(allocations(&AStar::new(&grid, moves), &cells), 0);
        assert_eq!(allocations(&Dijkstra::new(&grid, moves), &cells), 0);
        assert_eq!(allocations(&Jps::new(grid.clone(), moves), &cells), 0);
    }
}
