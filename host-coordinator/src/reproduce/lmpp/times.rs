//! Table 5: LMPP's time against that of A\*, both measured in this run.

use std::{hint::black_box, time::Instant};

use planning::{
    grid::Cell,
    search::{AStar, Planner, SearchError},
};

use super::{
    Failed, Laboratory, at, compared,
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
            let row = compared("5", at(location), column, Value::Number(printed), Value::Number(ours));
            rows.push(row.uncompared(note));
        }
        to_all.push([lmpp, astar]);
        to_nearest.push(measure(laboratory, from, &nearest)?);
    }
    rows.extend(medians("to every pile that doors lead to", &to_all));
    rows.extend(medians("to the nearest pile alone", &to_nearest));
    Ok(rows)
}

/// Microseconds that LMPP and A\* take for the ways from `from` to every pile that doors lead to.
pub(super) fn micros(laboratory: &mut Laboratory, from: Cell) -> Result<[f64; 2], Failed> {
    let piles: Vec<_> = laboratory.as_drawn.survey(from)?.lengths().map(|(pile, _)| pile).collect();
    Ok(measure(laboratory, from, &piles)?.map(|cost| cost.micros))
}

/// Plans the ways from `from` to `piles` by LMPP, with its memory at hand, and by A\*.
fn measure(laboratory: &mut Laboratory, from: Cell, piles: &[u16]) -> Result<Pair, Failed> {
    let Laboratory { site, as_drawn, workspace, .. } = laboratory;
    let lmpp = median_cost(|| {
        let survey = as_drawn.survey(from)?;
        piles.iter().for_each(|&pile| {
            black_box(survey.route_to(pile));
        });
        Ok(survey.expanded())
    })?;
    let cells = site.piles.iter().filter(|pile| piles.contains(&pile.id.0)).map(|pile| pile.cell);
    let astar = median_cost(|| {
        let search = |cell| Ok(AStar::new(&site.grid, site.moves).plan(from, cell, workspace)?.expanded);
        cells.clone().map(search).sum()
    })?;
    Ok([lmpp, astar])
}

/// The median time of `plan`, which returns how many nodes it expanded.
fn median_cost(mut plan: impl FnMut() -> Result<u32, SearchError>) -> Result<Cost, Failed> {
    let mut micros = Vec::new();
    let mut expanded = 0;
    for _ in 0..RUNS {
        let start = Instant::now();
        expanded = plan()?;
        micros.push(start.elapsed().as_nanos() as f64 / 1000.0);
    }
    Ok(Cost { micros: median(micros), expanded: expanded.into() })
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
        compared("5", format!("median, {row}"), column, Value::Missing, Value::Number(ours)).uncompared("")
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
