//! Access Tables 1 to 5, Figs. 2 and 6 and Experiments 1 to 4.
//!
//! Experiments 1 and 2 run on a map that is drawn to the text (`depot`), with the coordinator's own answers
//! (`scenario`), 3 and 4 on the map of
//! `sites/access-fig3` (`stations`), whose README says how far to trust it. Table 2 holds symbols only.

mod depot;
mod published;
mod scenario;
mod stations;

use super::{Failed, Paper, Row, Value, figure::Figure};

/// The paper.
pub const PAPER: Paper = Paper {
    name: "Access",
    tables: &["1", "Experiment 1", "Experiment 2", "3", "Experiment 3", "4", "Fig. 6", "5"],
    rows,
    figures,
};

/// Computes one table or experiment; none has another name than [`PAPER`] says.
///
/// # Errors
/// Only if a built-in map is faulty.
pub fn rows(table: &str) -> Result<Vec<Row>, Failed> {
    match table {
        "1" => Ok(table_1()),
        "Experiment 1" => depot::experiment_1(),
        "Experiment 2" => depot::experiment_2(),
        "3" => stations::table_3(),
        "Experiment 3" => stations::experiment_3(),
        "4" => stations::table_4(),
        "Fig. 6" => stations::fig_6(),
        "5" => stations::table_5(),
        _ => Ok(Vec::new()),
    }
}

/// What the four experiments draw.
///
/// # Errors
/// Only if a built-in map is faulty.
pub fn figures() -> Result<Vec<Figure>, Failed> {
    let mut figures = depot::figures()?;
    figures.extend(stations::figures()?);
    Ok(figures)
}

/// Table 1: the priorities of tasks.
fn table_1() -> Vec<Row> {
    let row = |(task, priority)| {
        PAPER
            .compared("1", task, "priority", Value::printed(priority), Value::Missing)
            .uncompared("an input of eq. 4; what the task takes is printed as a symbol only")
    };
    published::TABLE_1.map(row).into()
}
