//! Tables 6, 10, 13 and 14, and the distances of Test 3: lengths of paths.

use planning::{
    congestion::avoided,
    grid::Cell,
    lmpp::{Lmpp, Route},
    search::{AStar, Planner},
};

use super::{
    AS_DRAWN, AS_RUN, Failed, Laboratory, PAPER, at,
    published::{
        DELAY_S, Q_THRESHOLD, SPEED, TABLE_4, TABLE_6, TABLE_10, TABLE_11, TABLE_13, TABLE_13_AVERAGE,
        TABLE_14, TEST_3_DISTANCES, TEST_3_START, THETA,
    },
};
use crate::{
    reproduce::{Row, Value},
    selection::{PileStage, Rule, choose},
};

/// Table 6: from each location to the nearest of all piles.
pub(super) fn table_6(laboratory: &mut Laboratory) -> Result<Vec<Row>, Failed> {
    let mut rows = Vec::new();
    for (location, [by_astar, by_lmpp]) in TABLE_4.into_iter().zip(TABLE_6) {
        let from = laboratory.cell(location)?;
        let Laboratory { site, as_drawn, workspace, .. } = &mut *laboratory;
        let search = AStar::new(&site.grid, site.moves);
        let to_pile = |cell: Cell| Some(search.plan(from, cell, workspace).ok()?.path.length());
        let nearest = site.piles.iter().map(|pile| pile.cell).filter_map(to_pile);
        let nearest = Value::number(nearest.min().map(|length| length.units()));
        rows.push(PAPER.compared("6", at(location), "A*", Value::printed(by_astar), nearest));
        let nearest = as_drawn.survey(from)?.nearest();
        let nearest = Value::number(nearest.map(|(_, length)| length.units()));
        rows.push(
            PAPER.compared("6", at(location), "LMPP", Value::printed(by_lmpp), nearest).noted(AS_DRAWN),
        );
    }
    Ok(rows)
}

/// Table 10: the farthest and nearest idle and occupied piles in Test 4.
pub(super) fn table_10(laboratory: &mut Laboratory) -> Result<Vec<Row>, Failed> {
    let rows =
        TABLE_10.map(|(location, printed)| distances(laboratory, "10", &at(location), location, printed));
    Ok(rows.into_iter().collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
}

/// The distances of Test 3.
pub(super) fn test_3(laboratory: &mut Laboratory) -> Result<Vec<Row>, Failed> {
    let row = format!("Test 3, {}", at(TEST_3_START));
    let mut rows = distances(laboratory, "8", &row, TEST_3_START, TEST_3_DISTANCES)?;
    if let Some(row) = rows.last_mut() {
        row.add_note("printed as a second max D(Q2)");
    }
    Ok(rows)
}

fn distances(
    laboratory: &mut Laboratory,
    table: &'static str,
    row: &str,
    location: [i32; 2],
    printed: [&str; 4],
) -> Result<Vec<Row>, Failed> {
    let from = laboratory.cell(location)?;
    let survey = laboratory.as_run.survey(from)?;
    let candidates = laboratory.site.candidates(&survey, &[], Rule::PaperLiteral);
    let piles = choose(&candidates, 0.0, Q_THRESHOLD, Rule::PaperLiteral).explanations;
    let of = |stage| piles.iter().filter(move |pile| pile.stage == stage).filter_map(|pile| pile.distance);
    let max = |stage| of(stage).reduce(f64::max);
    let min = |stage| of(stage).reduce(f64::min);
    let (idle, occupied) = (PileStage::Idle, PileStage::AlmostCharged);
    let ours = [max(idle), min(idle), max(occupied), min(occupied)];
    let columns = ["max D(Q1)", "min D(Q1)", "max D(Q2)", "min D(Q2)"];
    let compared = |((column, printed), ours)| {
        PAPER.compared(table, row, column, Value::printed(printed), Value::number(ours)).noted(AS_RUN)
    };
    Ok(columns.into_iter().zip(printed).zip(ours).map(compared).collect())
}

/// Table 14: to the nearest of all piles, without and with avoidance of congested doors.
pub(super) fn table_14(laboratory: &mut Laboratory) -> Result<Vec<Row>, Failed> {
    let mut rows = Vec::new();
    for ((location, printed), routes) in TABLE_11.into_iter().zip(TABLE_14).zip(test_5(laboratory)?) {
        for ((column, printed), route) in [WITHOUT, WITH].into_iter().zip(printed).zip(routes) {
            let ours = Value::number(route.map(|route| route.path.length().units()));
            rows.push(
                PAPER.compared("14", at(location), column, Value::printed(printed), ours).noted(AS_DRAWN),
            );
        }
    }
    Ok(rows)
}

/// Table 13: the time for the lengths of Table 14, with a delay in every congested door.
pub(super) fn table_13(laboratory: &mut Laboratory) -> Result<Vec<Row>, Failed> {
    let routes = test_5(laboratory)?;
    let congested = avoided(laboratory.site.congestion.iter().copied(), THETA);
    let seconds = |route: &Route| {
        let delays = route.doors.iter().filter(|door| congested.contains(door)).count();
        route.path.length().units() / SPEED + DELAY_S * delays as f64
    };
    let mut rows = Vec::new();
    let mut sums = [Some(0.0), Some(0.0)];
    for ((location, printed), [without, with]) in TABLE_11.into_iter().zip(TABLE_13).zip(&routes) {
        for (((column, printed), route), sum) in
            [WITH, WITHOUT].into_iter().zip(printed).zip([with, without]).zip(&mut sums)
        {
            let ours = route.as_ref().map(seconds);
            *sum = sum.zip(ours).map(|(sum, ours)| sum + ours);
            let row =
                PAPER.compared("13", at(location), column, Value::printed(printed), Value::number(ours));
            rows.push(row.noted(AS_DRAWN));
        }
    }
    for ((column, printed), sum) in [WITH, WITHOUT].into_iter().zip(TABLE_13_AVERAGE).zip(sums) {
        let mean = Value::number(sum.map(|sum| sum / TABLE_11.len() as f64));
        rows.push(PAPER.compared("13", "average", column, Value::printed(printed), mean).noted(AS_DRAWN));
    }
    Ok(rows)
}

const WITHOUT: &str = "theta >= 1";
const WITH: &str = "0 < theta < 1";

/// Test 5: the routes to the nearest pile from each location of Table 11, without and with
/// avoidance.
pub(super) fn test_5(laboratory: &mut Laboratory) -> Result<Vec<[Option<Route>; 2]>, Failed> {
    let avoiding = laboratory.site.lmpp(THETA);
    let mut routes = Vec::new();
    for location in TABLE_11 {
        let from = laboratory.cell(location)?;
        let nearest = |lmpp: &Lmpp| -> Result<Option<Route>, Failed> {
            let survey = lmpp.survey(from)?;
            Ok(survey.nearest().and_then(|(pile, _)| survey.route_to(pile)))
        };
        routes.push([nearest(&laboratory.as_drawn)?, nearest(&avoiding)?]);
    }
    Ok(routes)
}
