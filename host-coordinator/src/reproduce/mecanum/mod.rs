//! Mecanum Tables I to IV, and the drive that III.C.2 is about.
//!
//! The paper's maps are lost with its figures, its times hold a delay for each node, and its lengths an
//! unknown unit. So its numbers stand beside medians over maps drawn to the text (`maps`), not
//! compared; what is compared is what must hold on any map: what the text says of the numbers, and
//! whether the printed ratios are those of the printed numbers.

mod drive;
mod figures;
mod maps;
mod measure;
mod published;
mod tables;

use super::{Failed, Paper, Row, Value};

/// The paper.
pub const PAPER: Paper =
    Paper { name: "Mecanum", tables: &["I", "II", "III", "III.C.2", "IV"], rows, figures: figures::figures };

/// Computes one table; none has another name than [`PAPER`] says.
///
/// # Errors
/// Only if the built-in site is faulty.
pub fn rows(table: &str) -> Result<Vec<Row>, Failed> {
    match table {
        "I" => tables::table_i(),
        "II" => tables::table_ii(),
        "III" => tables::table_iii(),
        "III.C.2" => tables::smoothing(),
        "IV" => tables::table_iv(),
        _ => Ok(Vec::new()),
    }
}

/// A row that has nothing to compare, and why.
fn uncompared(
    table: &'static str,
    row: &str,
    column: &str,
    published: Value,
    ours: Value,
    note: &str,
) -> Row {
    PAPER.compared(table, row, column, published, ours).uncompared(note)
}
