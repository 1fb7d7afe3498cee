//! IGWO's comparisons: Tables I to X and Figs. 3, 4 and 11 to 17.
//!
//! Tables and maps are missing from the text at hand, which prints what changes from one planner to another. So what is measured on a lost map stands as not comparable, and its ratio, or which of two is
//! better, is compared on our own maps (`places`). All is computed from 20 seeds.

mod figures;
mod matters;
mod places;
mod planners;
mod published;
mod sizes;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
mod trials;

use super::{Failed, Paper, Row, Value};

pub use figures::figures;

/// The paper.
pub const PAPER: Paper = Paper {
    name: "IGWO",
    tables: &[
        "I", "II", "III", "IV", "V", "VI", "VII", "VIII", "IX", "X", "Fig. 3", "Fig. 14", "Fig. 15",
        "Fig. 16", "Fig. 17",
    ],
    rows,
    figures,
};

/// Computes one table, or what the text says of a figure; none has another name than [`PAPER`] says.
///
/// # Errors
/// Only if one of the built-in maps is faulty.
pub fn rows(table: &str) -> Result<Vec<Row>, Failed> {
    match table {
        "I" => Ok(planners::table_1()),
        "II" => planners::iterations("II", places::test_maps(), &published::TABLES_II_III),
        "III" => planners::lengths("III", places::test_maps(), &published::TABLES_II_III),
        "IV" => planners::iterations("IV", places::parking_lots(), &published::TABLES_IV_V),
        "V" => planners::lengths("V", places::parking_lots(), &published::TABLES_IV_V),
        "VI" => matters::table_6(),
        "VII" => matters::table_7(),
        "VIII" => planners::table_8(),
        "IX" => planners::table_9(),
        "X" => Ok(planners::table_10()),
        "Fig. 3" => sizes::figure_3(),
        "Fig. 14" => matters::figure_14(),
        "Fig. 15" => matters::weights("Fig. 15", matters::FITNESS_1, "0.5"),
        "Fig. 16" => matters::weights("Fig. 16", matters::FITNESS_2, "0.2"),
        "Fig. 17" => matters::figure_17(),
        _ => Ok(Vec::new()),
    }
}

/// A row of a number that is printed.
fn number(table: &'static str, row: &str, column: &str, published: &str, ours: f64) -> Row {
    PAPER.compared(table, row, column, Value::printed(published), Value::Number(ours))
}

/// A row that says which of two is less, `ours` or `theirs`, and by how much in the note.
fn less(table: &'static str, row: &str, column: &str, ours: f64, theirs: f64) -> Row {
    let published = Value::Text("less".into());
    let which = match ours.total_cmp(&theirs) {
        std::cmp::Ordering::Less => "less",
        std::cmp::Ordering::Equal => "equal",
        std::cmp::Ordering::Greater => "more",
    };
    let row = PAPER.compared(table, row, column, published, Value::Text(which.into()));
    row.noted(&format!("{ours:.2} against {theirs:.2}"))
}

/// What changes from `before` to `after`, in per cent of `before`.
fn percent(before: f64, after: f64) -> f64 {
    100.0 * (after - before) / before
}

/// The note on what is measured on a map that is lost.
const LOST: &str = "lost map; the ratio is compared instead";
/// The same where no ratio is printed.
const LOST_WITHOUT_RATIO: &str = "lost map, and no ratio is printed";
