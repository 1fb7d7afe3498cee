//! Table 7 and the choices of Tests 3 and 4, by both readings of eq. 9.

use protocol::PileId;

use super::{
    AS_RUN, Failed, Laboratory, PAPER, at, inputs, lengths,
    published::{
        Q_THRESHOLD, TABLE_7, TABLE_8, TABLE_9, TABLE_10, TEST_3_CHOICES, TEST_3_START, TEST_4_CHOICES,
        TEST_4_REACHES,
    },
};
use crate::{
    reproduce::{Row, Value, Verdict},
    selection::{Choice, PileStage, Rule, choose},
};

/// Table 7: how many piles each threshold lets be searched.
pub(super) fn table_7(laboratory: &mut Laboratory) -> Result<Vec<Row>, Failed> {
    let mut rows = Vec::new();
    for (threshold, idle, all) in TABLE_7 {
        let [ours_idle, ours_busy] = searched(laboratory, threshold)?;
        for (column, printed, ours) in [("Q1", idle, ours_idle), ("Q1 + Q2", all, ours_idle + ours_busy)] {
            let row = format!("q_th {threshold}");
            rows.push(PAPER.compared("7", row, column, Value::printed(printed), Value::Number(ours)));
        }
    }
    Ok(rows)
}

/// How many idle and how many almost charged piles a threshold lets be searched.
pub(super) fn searched(laboratory: &mut Laboratory, threshold: f64) -> Result<[f64; 2], Failed> {
    let piles = question(laboratory, TEST_3_START, &[], 0.0, threshold, Rule::PaperLiteral)?.explanations;
    let count = |stage| piles.iter().filter(|pile| pile.stage == stage).count() as f64;
    Ok([count(PileStage::Idle), count(PileStage::AlmostCharged)])
}

/// The pile that is chosen in Tests 3 and 4, if any.
pub(super) fn chosen(
    laboratory: &mut Laboratory,
    location: [i32; 2],
    probabilities: &[f64],
    reach: u32,
    rule: Rule,
) -> Result<Option<PileId>, Failed> {
    Ok(question(laboratory, location, probabilities, reach.into(), Q_THRESHOLD, rule)?.chosen)
}

/// Table 8 and Test 3, whose input it is: one location, six sets of probabilities.
pub(super) fn table_8(laboratory: &mut Laboratory) -> Result<Vec<Row>, Failed> {
    let mut rows: Vec<_> = (1..)
        .zip(&TABLE_8)
        .map(|(condition, p)| inputs::probabilities("8", format!("condition ({condition})"), p, "Test 3"))
        .collect();
    rows.extend(lengths::test_3(laboratory)?);
    for (reach, choices) in TEST_3_CHOICES {
        for ((condition, p), printed) in (1..).zip(&TABLE_8).zip(choices) {
            let row = format!("Test 3, condition ({condition}), reach {reach}");
            let mut choices = choice(laboratory, "8", &row, TEST_3_START, p, reach, Some(printed))?;
            if (reach, condition) == (80, 2) {
                let misprint = "the text gives s12 the largest p, 0.34; that is s10";
                choices.iter_mut().for_each(|row| row.add_note(misprint));
            }
            rows.extend(choices);
        }
    }
    Ok(rows)
}

/// Table 9 and Test 4, whose input it is: six locations, one set of probabilities.
pub(super) fn table_9(laboratory: &mut Laboratory) -> Result<Vec<Row>, Failed> {
    let mut rows = vec![inputs::probabilities("9", "all locations".into(), &TABLE_9, "Test 4")];
    for ((location, _), choices) in TABLE_10.into_iter().zip(TEST_4_CHOICES) {
        for (reach, printed) in TEST_4_REACHES.into_iter().zip(choices) {
            let row = format!("Test 4, {}, reach {reach}", at(location));
            rows.extend(choice(laboratory, "9", &row, location, &TABLE_9, reach, printed)?);
        }
    }
    Ok(rows)
}

/// One choice by both readings.
fn choice(
    laboratory: &mut Laboratory,
    table: &'static str,
    row: &str,
    location: [i32; 2],
    probabilities: &[f64],
    reach: u32,
    printed: Option<u16>,
) -> Result<Vec<Row>, Failed> {
    let mut rows = Vec::new();
    for (rule, column) in [(Rule::PaperLiteral, "eq. 9 as printed"), (Rule::Corrected, "corrected")] {
        let ours = question(laboratory, location, probabilities, reach.into(), Q_THRESHOLD, rule)?;
        let published = pile(printed.map(PileId));
        let mut row = PAPER.compared(table, row, column, published, pile(ours.chosen));
        if row.verdict == Verdict::Differs {
            explain(&mut row, &ours, reach.into(), printed.map(PileId));
        }
        rows.push(row.noted(AS_RUN));
    }
    Ok(rows)
}

/// Notes why a choice differs from what is printed.
fn explain(row: &mut Row, ours: &Choice, reach: f64, printed: Option<PileId>) {
    let found = |wanted: Option<PileId>| ours.explanations.iter().find(|pile| Some(pile.pile) == wanted);
    if let Some(printed) = found(printed) {
        if printed.stage != PileStage::Idle
            && found(ours.chosen).is_some_and(|pile| pile.stage == PileStage::Idle)
        {
            row.add_note(&format!(
                "s{} is occupied; eq. 9 takes idle piles while one is in reach",
                printed.pile
            ));
        }
        if let Some(distance) = printed.distance.filter(|&distance| distance > reach) {
            row.add_note(&format!("s{} is {distance:.2} away, beyond the reach", printed.pile));
        }
    }
    if let Some((pile, distance)) = found(ours.chosen).and_then(|pile| Some((pile.pile, pile.distance?)))
        && distance > reach
    {
        row.add_note(&format!("eq. 9 as printed ranks s{pile}, {distance:.2} away, beyond the reach"));
    }
}

fn question(
    laboratory: &mut Laboratory,
    location: [i32; 2],
    probabilities: &[f64],
    reach: f64,
    q_threshold: f64,
    rule: Rule,
) -> Result<Choice, Failed> {
    let from = laboratory.cell(location)?;
    let survey = laboratory.as_run.survey(from)?;
    let candidates = laboratory.site.candidates(&survey, probabilities, rule);
    Ok(choose(&candidates, reach, q_threshold, rule))
}

fn pile(pile: Option<PileId>) -> Value {
    Value::Text(pile.map_or("none".into(), |pile| format!("s{pile}")))
}
