//! Tables 8, 9, 11 and 12: what the paper's tests were given.

use super::{
    Failed, Laboratory, PAPER, at,
    published::{TABLE_11, TABLE_12},
};
use crate::reproduce::{Row, Value};

/// One set of probabilities of Tables 8 and 9.
pub(super) fn probabilities(table: &'static str, row: String, probabilities: &[f64], test: &str) -> Row {
    let sum = rounded(probabilities.iter().sum());
    let note = format!("an input of {test}; eq. 5 makes them sum to 1");
    PAPER.compared(table, row, "sum of p", Value::Number(sum), Value::Missing).uncompared(note)
}

/// Table 11: the locations of Test 5.
pub(super) fn table_11(laboratory: &mut Laboratory) -> Result<Vec<Row>, Failed> {
    let mut rows = Vec::new();
    for (number, location) in (1..).zip(TABLE_11) {
        let cell = laboratory.cell(location)?;
        let rooms = &laboratory.site.rooms;
        let subarea = rooms.find_subarea(cell).and_then(|subarea| rooms.subareas().name(subarea));
        let ours = subarea.map_or(Value::Missing, |name| Value::Text(format!("subarea {name}")));
        let note = "an input of Tables 13 and 14";
        let row = PAPER.compared("11", number.to_string(), "location", Value::Text(at(location)), ours);
        rows.push(row.uncompared(note));
    }
    Ok(rows)
}

/// Table 12: the congestion of the doors, which the site file repeats.
pub(super) fn table_12(laboratory: &mut Laboratory) -> Result<Vec<Row>, Failed> {
    let congestion = &laboratory.site.congestion;
    let mut rows = Vec::new();
    for (number, printed) in (1..).zip(TABLE_12) {
        let of_door = congestion.iter().find(|(door, _)| door.0 == number);
        let ours = Value::number(of_door.map(|&(_, congestion)| congestion));
        let mut row =
            PAPER.compared("12", format!("door {number}"), "congestion", Value::printed(printed), ours);
        row.add_note("an input of Tables 13 and 14, as the site file has it");
        rows.push(row);
    }
    let sum = rounded(congestion.iter().map(|&(_, congestion)| congestion).sum());
    let note = "eq. 11 makes them sum to 1";
    rows.push(PAPER.compared("12", "all doors", "sum", Value::Number(sum), Value::Missing).uncompared(note));
    Ok(rows)
}

/// Without the last digits, in which a sum of decimal fractions is never exact.
fn rounded(sum: f64) -> f64 {
    (sum * 1e6).round() / 1e6
}
