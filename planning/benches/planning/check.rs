//! Every query of every map, by every optimal planner: is its length the optimal one, and its path
//! one that a robot can go?

use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use planning::{formats::scen::Query, grid::Grid, moves::MoveSet};

use crate::contestants::{Contestant, Entry, OURS};
use crate::maps::Map;
use crate::{Failure, progress};

/// So far may a length be from the scenario's, whose numbers are rounded.
const TOLERANCE: f64 = 0.01;
/// So many queries does a thread take at a time.
const CHUNK: usize = 64;

/// Runs all of them and says of each planner and map how many there were. With 16 neighbours A* tells the
/// optimal lengths, and Dijkstra's algorithm is compared with it on small random maps only, by the tests.
pub fn all(maps: &[Map]) -> Result<(), Failure> {
    let mut wrong = 0;
    for map in maps {
        for moves in [MoveSet::Eight, MoveSet::Sixteen] {
            let asked = map.asked(moves, usize::MAX);
            let is_checked =
                |entry: &&Entry| entry.moves == moves && !(moves == MoveSet::Sixteen && entry.is_sampled);
            for entry in OURS.iter().filter(is_checked) {
                let complaints = one(map, &asked, entry);
                println!(
                    "{:<16} {:<23} {:>6} queries, {} off the optimum",
                    map.name,
                    entry.name,
                    asked.len(),
                    complaints.len()
                );
                complaints.iter().take(5).for_each(|complaint| println!("  {complaint}"));
                wrong += complaints.len();
            }
        }
    }
    if wrong == 0 {
        Ok(())
    } else {
        Err(Failure(format!("{wrong} answers are wrong: the first of each planner are above")))
    }
}

/// What is wrong with a planner's answers on a map.
fn one(map: &Map, asked: &[(usize, Query)], entry: &Entry) -> Vec<String> {
    let bar = progress::bar(asked.len(), &format!("{}: {}", map.name, entry.name));
    let next = AtomicUsize::new(0);
    let work = || {
        let mut contestant = (entry.make)(&map.grid);
        let mut complaints = Vec::new();
        while let Some(queries) = asked.chunks(CHUNK).nth(next.fetch_add(1, Ordering::Relaxed)) {
            complaints.extend(
                queries.iter().filter_map(|(_, query)| complaint(contestant.as_mut(), &map.grid, query)),
            );
            bar.inc(queries.len() as u64);
        }
        complaints
    };
    let threads = thread::available_parallelism().map_or(1, usize::from);
    let complaints = thread::scope(|scope| {
        let threads: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        let finished = threads.into_iter().map(|thread| thread.join());
        // A planner that panics is wrong, too.
        finished.flat_map(|complaints| complaints.unwrap_or_else(|_| vec!["it panicked".into()])).collect()
    });
    bar.finish_and_clear();
    complaints
}

/// What is wrong with a planner's answer to a query, if anything.
pub fn complaint(contestant: &mut dyn Contestant, grid: &Grid, query: &Query) -> Option<String> {
    let Query { from, to, optimal, .. } = query;
    let Some((answer, walkable)) = contestant.plan_and_walk(grid, *from, *to) else {
        return Some(format!("{from} to {to}: no path, {optimal} expected"));
    };
    if (answer.length - optimal).abs() > TOLERANCE {
        return Some(format!("{from} to {to}: {} long, {optimal} expected", answer.length));
    }
    (!walkable).then(|| format!("{from} to {to}: the path leads through a wall or elsewhere"))
}
