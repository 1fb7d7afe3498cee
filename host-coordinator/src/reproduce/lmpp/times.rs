//! Table 5: LMPP's time against that of A\*, both measured in this run.

use std::{hint::black_box, time::Instant};

use planning::{
    grid::Cell,
    lmpp::Lmpp,
    moves::MoveSet,
    path::Path,
    search::{AStar, Planner, SearchError},
};

use super::{
    Failed, Laboratory, PAPER, at,
    published::{TABLE_4, TABLE_5},
};
use crate::reproduce::{Row, Value};

/// Each time is the median of so many runs.
const RUNS: usize = 15;

const ELSEWHERE: &str = "another computer, printed in s";

/// What one way of planning took.
#[derive(Clone, Copy)]
struct Cost {
    micros: f64,
    expanded: f64,
}

/// LMPP's cost and that of A\*.
type Pair = [Cost; 2];

/// Table 5 and, over all its locations, medians of times and expanded nodes.
pub(super) fn table_5(laboratory: &mut Laboratory) -> Result<Vec<Row>, Failed> {
    let mut rows = Vec::new();
    let (mut to_all, mut to_nearest) = (Vec::new(), Vec::new());
    for (location, [lmpp_s, astar_s]) in TABLE_4.into_iter().zip(TABLE_5) {
        let from = laboratory.cell(location)?;
        let survey = laboratory.as_drawn.survey(from)?;
        let piles: Vec<_> = survey.lengths().map(|(pile, _)| pile).collect();
        let nearest: Vec<_> = survey.nearest().map(|(pile, _)| pile).into_iter().collect();
        let [lmpp, astar] = measure(laboratory, from, &piles)?;
        for (column, printed, ours, note) in [
            ("LMPP, us", lmpp_s, lmpp.micros, ELSEWHERE),
            ("A*, us", astar_s, astar.micros, ELSEWHERE),
            ("LMPP / A*", lmpp_s / astar_s, lmpp.micros / astar.micros, "to every pile that doors lead to"),
        ] {
            let row = PAPER.compared("5", at(location), column, Value::Number(printed), Value::Number(ours));
            rows.push(row.uncompared(note));
        }
        to_all.push([lmpp, astar]);
        to_nearest.push(measure(laboratory, from, &nearest)?);
    }
    rows.extend(medians("to every pile that doors lead to", &to_all));
    rows.extend(medians("to the nearest pile alone", &to_nearest));
    for (moves, name) in [(MoveSet::Eight, "8 neighbours"), (MoveSet::Sixteen, "16 neighbours")] {
        rows.extend(recall(laboratory, moves, name)?);
    }
    Ok(rows)
}

/// Cells between two starts of [`recall`], row by row: some two hundred of them all over the map.
const APART: usize = 41;

/// One way at a time from all over the map to every pile: how much sooner it is recalled by LMPP than found
/// by A\*, and how much longer than the shortest it is.
fn recall(laboratory: &mut Laboratory, moves: MoveSet, name: &str) -> Result<Vec<Row>, Failed> {
    let Laboratory { site, workspace, .. } = laboratory;
    let lmpp = Lmpp::new(site.grid.clone(), moves, site.rooms.clone(), site.targets());
    let astar = AStar::new(&site.grid, moves);
    let (mut recalled, mut path) = (Vec::new(), Path::default());
    let mut penalties = Vec::new();
    for from in site.grid.free_cells().step_by(APART) {
        for pile in &site.piles {
            // No chain of doors leads there, as from some rooms of the paper's site.
            let Ok(plan) = lmpp.plan(from, pile.cell, &mut path) else { continue };
            let length = plan.path.length().units();
            let shortest = astar.plan(from, pile.cell, workspace)?.path.length().units();
            penalties.push(if shortest > 0.0 { 100.0 * (length / shortest - 1.0) } else { 0.0 });
            recalled.push((from, pile.cell));
        }
    }
    let ways = recalled.len() as f64;
    let lmpp_us = median_cost(|| plan_each(&lmpp, &recalled, &mut path))?.micros / ways;
    let astar_us = once(|| plan_each(&astar, &recalled, workspace))?.micros / ways;
    let mean = penalties.iter().sum::<f64>() / ways;
    let longest = penalties.iter().copied().fold(0.0, f64::max);
    let row = format!("recall, {name}");
    let note = format!("{} ways from all over the map, mean of each", recalled.len());
    let rows = [
        ("LMPP, us", lmpp_us, &*note),
        ("A*, us", astar_us, &*note),
        ("A* / LMPP", astar_us / lmpp_us, "times sooner"),
        ("longer by, %", mean, "mean, than the shortest way; Algorithm 6 gives no shorter ones"),
        ("longer by at most, %", longest, "of all these ways"),
    ];
    let rows = rows.into_iter().map(|(column, ours, note)| {
        PAPER.compared("5", &*row, column, Value::Missing, Value::Number(ours)).uncompared(note)
    });
    Ok(rows.collect())
}

/// Plans some ways; returns how many nodes that expanded.
fn plan_each<P: Planner>(
    planner: &P,
    ways: &[(Cell, Cell)],
    workspace: &mut P::Workspace,
) -> Result<u32, SearchError> {
    ways.iter().map(|&(from, to)| Ok(black_box(planner.plan(from, to, workspace)?).expanded)).sum()
}

/// Microseconds that LMPP and A\* take for the ways from `from` to every pile that doors lead to.
pub(super) fn micros(laboratory: &mut Laboratory, from: Cell) -> Result<[f64; 2], Failed> {
    let piles: Vec<_> = laboratory.as_drawn.survey(from)?.lengths().map(|(pile, _)| pile).collect();
    Ok(measure(laboratory, from, &piles)?.map(|cost| cost.micros))
}

/// Plans the ways from `from` to `piles` by LMPP, with its memory at hand, and by A\*.
fn measure(laboratory: &mut Laboratory, from: Cell, piles: &[u16]) -> Result<Pair, Failed> {
    let Laboratory { site, as_drawn, workspace, .. } = laboratory;
    let cells = site.piles.iter().filter(|pile| piles.contains(&pile.id.0)).map(|pile| pile.cell);
    let ways: Vec<_> = cells.map(|cell| (from, cell)).collect();
    let mut path = Path::default();
    let lmpp = median_cost(|| plan_each(as_drawn, &ways, &mut path))?;
    let astar = median_cost(|| plan_each(&AStar::new(&site.grid, site.moves), &ways, workspace))?;
    Ok([lmpp, astar])
}

/// The median time of `plan`, which returns how many nodes it expanded.
fn median_cost(mut plan: impl FnMut() -> Result<u32, SearchError>) -> Result<Cost, Failed> {
    let costs = (0..RUNS).map(|_| once(&mut plan)).collect::<Result<Vec<_>, _>>()?;
    let expanded = costs.first().map_or(0.0, |cost| cost.expanded);
    Ok(Cost { micros: median(costs.iter().map(|cost| cost.micros).collect()), expanded })
}

/// What `plan` takes, once.
fn once(mut plan: impl FnMut() -> Result<u32, SearchError>) -> Result<Cost, Failed> {
    let start = Instant::now();
    let expanded = plan()?;
    Ok(Cost { micros: start.elapsed().as_nanos() as f64 / 1000.0, expanded: expanded.into() })
}

/// Medians over all locations, with nothing published to compare them with.
fn medians(row: &str, costs: &[Pair]) -> Vec<Row> {
    let median_of = |value: fn(&Pair) -> f64| median(costs.iter().map(value).collect());
    [
        ("LMPP, us", median_of(|[lmpp, _]| lmpp.micros)),
        ("A*, us", median_of(|[_, astar]| astar.micros)),
        ("LMPP / A*, time", median_of(|[lmpp, astar]| lmpp.micros / astar.micros)),
        ("LMPP, nodes", median_of(|[lmpp, _]| lmpp.expanded)),
        ("A*, nodes", median_of(|[_, astar]| astar.expanded)),
    ]
    .into_iter()
    .map(|(column, ours)| {
        PAPER
            .compared("5", format!("median, {row}"), column, Value::Missing, Value::Number(ours))
            .uncompared("")
    })
    .collect()
}

/// The middle of some numbers, or the mean of the two middle ones; 0 of none.
fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    let middle = |index: usize| numbers.get(index).copied().unwrap_or_default();
    let count = numbers.len();
    (middle(count.saturating_sub(1) / 2) + middle(count / 2)) / 2.0
}
