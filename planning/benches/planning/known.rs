//! Ways to known targets: walking through fields, building them, what they take.

use std::hint::black_box;

use planning::{
    grid::{Cell, Grid},
    memory::Fields,
    moves::MoveSet,
    path::Path,
    search::{Dijkstra, Workspace},
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::Serialize;

use crate::clock::Clock;
use crate::doors::{self, DoorsReport};
use crate::maps::Map;
use crate::statistics::{Summary, median};

/// Piles on each map, as on the paper's.
const PILES: usize = 13;
const SEED: u64 = 13;
const PASSES: usize = 5;
const BUILDS: usize = 3;

/// What known targets take on one map.
#[derive(Debug, Serialize)]
pub struct KnownReport {
    pub piles: usize,
    /// The length of the way to a pile, in microseconds.
    pub length: Summary,
    /// The way to a pile with waypoints.
    pub walk: Summary,
    /// The nearest pile and the way to it with waypoints.
    pub nearest: Summary,
    /// Answers that are not what Dijkstra's algorithm finds.
    pub off: usize,
    /// For each free cell and pile.
    pub build_ns: f64,
    pub bytes_a_pile: usize,
    /// Everything: all fields, the map, the list of piles.
    pub bytes: usize,
    /// Doors that close, where the map has any.
    pub doors: Option<DoorsReport>,
}

/// Measures 13 piles, with the starts of the map's queries.
pub fn measure(map: &Map) -> KnownReport {
    let starts: Vec<Cell> = map.queries.iter().map(|query| query.from).collect();
    let start = starts.first().copied().unwrap_or_default();
    let piles = choose(&reachable(&map.grid, start), PILES, SEED);
    let mut micros = Vec::new();
    let mut fields = Fields::build(map.grid.clone(), MoveSet::Eight, &piles);
    for _ in 0..BUILDS {
        let grid = map.grid.clone();
        let (took, built) = Clock::Thread.time(|| Fields::build(grid, MoveSet::Eight, &piles));
        micros.push(took);
        fields = built;
    }
    let cells = (map.grid.free_cells().count() * piles.len()) as f64;
    let mut path = Path::default();
    let pile = |query: usize| query % piles.len();
    let bytes = fields.bytes();
    KnownReport {
        piles: piles.len(),
        length: time(&starts, |query, from| fields.length(from, pile(query)).is_some()),
        walk: time(&starts, |query, from| fields.walk(from, pile(query), &mut path)),
        nearest: time(&starts, |_, from| {
            fields.nearest(from).is_some_and(|(pile, _)| fields.walk(from, pile, &mut path))
        }),
        off: count_off(&fields, &starts),
        build_ns: median(&micros) * 1e3 / cells,
        bytes_a_pile: (bytes.distances + bytes.runs) / piles.len().max(1),
        bytes: bytes.total(),
        doors: doors::measure(&mut fields),
    }
}

/// The free cells that can be reached from `start`.
pub fn reachable(grid: &Grid, start: Cell) -> Vec<Cell> {
    let ways = Fields::build(grid.clone(), MoveSet::Eight, &[start]);
    grid.free_cells().filter(|&cell| ways.length(cell, 0).is_some()).collect()
}

/// `count` different ones of `cells` by chance; fewer if there are no more.
pub fn choose(cells: &[Cell], count: usize, seed: u64) -> Vec<Cell> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut left = cells.to_vec();
    (0..count.min(left.len())).map(|_| left.swap_remove(random.random_range(0..left.len()))).collect()
}

/// The time of each start's query in microseconds: the median of some passes.
fn time(starts: &[Cell], mut query: impl FnMut(usize, Cell) -> bool) -> Summary {
    let mut pass = || -> Vec<f64> {
        let one = |(number, &from): (usize, &Cell)| {
            Clock::Wall.time(|| black_box(query(number, black_box(from)))).0
        };
        starts.iter().enumerate().map(one).collect()
    };
    pass();
    let passes: Vec<_> = (0..PASSES).map(|_| pass()).collect();
    let of_start = |start: usize| median(&passes.iter().map(|pass| pass[start]).collect::<Vec<_>>());
    Summary::of(&(0..starts.len()).map(of_start).collect::<Vec<_>>())
}

/// How many lengths, ways and nearest piles are wrong.
fn count_off(fields: &Fields, starts: &[Cell]) -> usize {
    let mut workspace = Workspace::default();
    let mut path = Path::default();
    let mut off = 0;
    let mut nearest = vec![None; starts.len()];
    for (pile, &target) in fields.targets().iter().enumerate() {
        let Ok(ways) = Dijkstra::new(fields.grid(), MoveSet::Eight).ways(target, &[], &mut workspace) else {
            continue;
        };
        for (&from, nearest) in starts.iter().zip(&mut nearest) {
            let expected = ways.length_to(from);
            let known = fields.length(from, pile);
            let walked = fields.walk(from, pile, &mut path).then(|| path.length());
            let is_way = walked.is_none()
                || ((path.start(), path.end()) == (from, target)
                    && path.is_walkable(fields.grid(), MoveSet::Eight));
            off += usize::from((known, walked) != (expected, expected) || !is_way);
            *nearest = (*nearest).into_iter().chain(expected).min();
        }
    }
    let is_off = |&(&from, &nearest): &(&Cell, &_)| fields.nearest(from).map(|(_, length)| length) != nearest;
    off + starts.iter().zip(&nearest).filter(is_off).count()
}
