//! Runs planners over a map's queries and times each.

use std::hint::black_box;

use indicatif::ProgressBar;
use planning::{formats::scen::Query, moves::MoveSet};

use crate::clock::Clock;
use crate::contestants::{Answer, Contestant, Entry, GRID_PATHFINDING, OURS, PATHFINDING};
use crate::maps::{Map, spaced};
use crate::report::{MapReport, PlannerReport};
use crate::statistics::{Summary, mean, median};
use crate::{check, known, progress};

/// How queries are measured, for the reader of the figures.
pub const METHOD: &str = "\
Each query by itself, in the order of the file, one thread. After a warm-up of 32 queries the file is run three \
times, and of each query's three times the median counts, by the wall's clock; planners that take more than \
500 us a query run it once, by the thread's own clock, as do indexes and fields being built. Means are over \
queries. Peers, A* and Dijkstra are asked at most 200 queries, evenly spaced; ratios are of means over just \
these. With 16 neighbours so many lengths are compared, with A*'s. All lengths over all queries: --check, and \
cargo xtask test.";

/// So many queries at most are asked of whoever is sampled.
const SAMPLE: usize = 200;
const WARM_UP: usize = 32;
/// Who takes longer a query is measured once.
const SLOW_US: f64 = 500.0;
const PASSES: usize = 3;

/// One planner's times and answers.
struct Run {
    name: &'static str,
    /// Numbers of the queries asked.
    asked: Vec<usize>,
    /// For each of them.
    micros: Vec<f64>,
    answers: Vec<Option<Answer>>,
    off: Option<usize>,
    index_seconds: f64,
    index_bytes: Option<usize>,
}

/// Measures all planners on a map.
pub fn measure(map: &Map) -> MapReport {
    let entries: Vec<&Entry> = OURS.iter().chain([&PATHFINDING, &GRID_PATHFINDING]).collect();
    let bar = progress::bar(entries.len(), &map.name);
    let runs: Vec<Run> = entries.iter().map(|entry| run(map, entry, &bar)).collect();
    bar.finish_and_clear();
    let peer = |entry: &Entry| runs.iter().find(|run| run.name == entry.name);
    let report = |run: &Run| {
        let expanded: Vec<f64> =
            run.answers.iter().flatten().filter_map(|answer| answer.expanded.map(f64::from)).collect();
        let ratio = |peer: Option<&Run>| peer.map(|peer| mean(&peer.micros) / mean_over(run, &peer.asked));
        PlannerReport {
            planner: run.name,
            queries: run.asked.len(),
            micros: Summary::of(&run.micros),
            expanded: (!expanded.is_empty()).then(|| mean(&expanded)),
            index_seconds: run.index_seconds,
            index_bytes: run.index_bytes,
            off: run.off,
            times_pathfinding: ratio(peer(&PATHFINDING)),
            times_grid_pathfinding: ratio(peer(&GRID_PATHFINDING)),
        }
    };
    MapReport {
        map: map.name.clone(),
        width: map.grid.width(),
        height: map.grid.height(),
        free_cells: map.grid.free_cells().count(),
        known: known::measure(map),
        planners: runs.iter().map(report).collect(),
    }
}

/// The mean over those of the queries `among` that were asked.
fn mean_over(run: &Run, among: &[usize]) -> f64 {
    let times = run.asked.iter().zip(&run.micros).filter(|(query, _)| among.binary_search(query).is_ok());
    mean(&times.map(|(_, &micros)| micros).collect::<Vec<_>>())
}

fn run(map: &Map, entry: &Entry, bar: &ProgressBar) -> Run {
    bar.set_message(format!("{}: {}", map.name, entry.name));
    let (micros_to_make, mut contestant) = Clock::Thread.time(|| (entry.make)(&map.grid));
    let limit = if entry.is_sampled { SAMPLE } else { usize::MAX };
    let asked: Vec<usize> = spaced(map.queries.len(), limit).collect();
    let queries: Vec<&Query> = asked.iter().filter_map(|&query| map.queries.get(query)).collect();
    let (micros, answers) = time(contestant.as_mut(), &queries);
    let off = entry.is_optimal.then(|| count_off(contestant.as_mut(), map, entry.moves, limit));
    bar.inc(1);
    Run {
        name: entry.name,
        asked,
        micros,
        answers,
        off,
        index_seconds: micros_to_make / 1e6,
        index_bytes: contestant.bytes(),
    }
}

fn count_off(contestant: &mut dyn Contestant, map: &Map, moves: MoveSet, limit: usize) -> usize {
    // What has to be searched first is searched of a sample only.
    let limit = if moves == MoveSet::Sixteen { limit.min(SAMPLE) } else { limit };
    let asked = map.asked(moves, limit);
    asked.iter().filter(|(_, query)| check::complaint(contestant, &map.grid, query).is_some()).count()
}

/// The time of each query in microseconds, and its answer.
fn time(contestant: &mut dyn Contestant, queries: &[&Query]) -> (Vec<f64>, Vec<Option<Answer>>) {
    let warm_up: Vec<&Query> = spaced(queries.len(), WARM_UP).map(|query| queries[query]).collect();
    // The first pass over these brings memory in; the second tells how slow it is.
    pass(contestant, &warm_up, Clock::Thread);
    let is_slow = mean(&pass(contestant, &warm_up, Clock::Thread).0) > SLOW_US;
    let (clock, count) = if is_slow { (Clock::Thread, 1) } else { (Clock::Wall, PASSES) };
    let (first, answers) = pass(contestant, queries, clock);
    let mut passes = vec![first];
    passes.extend((1..count).map(|_| pass(contestant, queries, clock).0));
    let of_query = |query: usize| median(&passes.iter().map(|pass| pass[query]).collect::<Vec<_>>());
    ((0..queries.len()).map(of_query).collect(), answers)
}

fn pass(
    contestant: &mut dyn Contestant,
    queries: &[&Query],
    clock: Clock,
) -> (Vec<f64>, Vec<Option<Answer>>) {
    let mut one = |query: &&Query| {
        clock.time(|| black_box(contestant.plan(black_box(query.from), black_box(query.to))))
    };
    queries.iter().map(&mut one).unzip()
}
