//! LMPP Tables 5 to 14 and the choices of Tests 3 and 4, on the reconstructed map of Fig. 7.
//!
//! A test's results stand with the table of its inputs: Test 3 with Table 8, Test 4 with
//! Table 9. `sites/lmpp-fig7/README.md` says how far to trust the map.

mod choices;
mod inputs;
mod lengths;
mod published;
mod times;

use std::collections::BTreeSet;

use planning::{
    grid::Cell,
    lmpp::Lmpp,
    memory::DoorSets,
    rooms::DoorId,
    search::{SearchError, Workspace},
};

use super::{Row, Value, Verdict};
use crate::{
    diagnostics::Diagnostics,
    site::{OutsideMap, Site},
};

/// The tables, and how each is computed.
const TABLES: [(u32, Compute); 10] = [
    (5, times::table_5),
    (6, lengths::table_6),
    (7, choices::table_7),
    (8, choices::table_8),
    (9, choices::table_9),
    (10, lengths::table_10),
    (11, inputs::table_11),
    (12, inputs::table_12),
    (13, lengths::table_13),
    (14, lengths::table_14),
];

type Compute = fn(&mut Laboratory) -> Result<Vec<Row>, Failed>;

/// Why a table can't be computed.
#[derive(Debug, thiserror::Error)]
pub enum Failed {
    /// There is no such table.
    #[error("LMPP table {0} is not reproduced: give one of 5 to 14")]
    NoSuchTable(u32),
    /// The program was built with a faulty site.
    #[error(transparent)]
    Site(#[from] Diagnostics),
    /// A printed location is not on the map.
    #[error("a location that the paper prints is not on the map: {0}")]
    Outside(#[from] OutsideMap),
    /// A printed location can't be started from.
    #[error("a location that the paper prints can't be started from: {0}")]
    Search(#[from] SearchError),
}

/// Computes one table, or all.
///
/// # Errors
/// [`Failed::NoSuchTable`], and others only if the built-in site is faulty.
pub fn rows(only: Option<u32>) -> Result<Vec<Row>, Failed> {
    if let Some(table) = only.filter(|&only| TABLES.iter().all(|&(table, _)| table != only)) {
        return Err(Failed::NoSuchTable(table));
    }
    let mut laboratory = Laboratory::new(Site::fig7()?);
    let mut rows = Vec::new();
    for (table, compute) in TABLES {
        if only.is_none_or(|only| only == table) {
            rows.extend(compute(&mut laboratory)?);
        }
    }
    Ok(rows)
}

/// The site and the planners of the paper's five tests.
struct Laboratory {
    site: Site,
    /// Tests 1 and 5: each subarea has the doors that it is drawn with.
    as_drawn: Lmpp,
    /// Tests 3 and 4: the doors that those runs must have used.
    as_run: Lmpp,
    workspace: Workspace,
}

impl Laboratory {
    fn new(site: Site) -> Self {
        let (as_drawn, as_run) = (site.lmpp(1.0), as_run(&site));
        Self { site, as_drawn, as_run, workspace: Workspace::default() }
    }

    /// The cell at a location that the paper prints.
    fn cell(&self, [x, y]: [i32; 2]) -> Result<Cell, Failed> {
        Ok(self.site.cell_at(x, y)?)
    }
}

/// In the runs behind Tests 3 and 4 a robot in the hall made straight for doors 1 and 2, door 4
/// was linked to them, and a robot in the corridor was offered doors 3 and 7 only.
fn as_run(site: &Site) -> Lmpp {
    let mut sets = DoorSets::of(&site.rooms);
    let subareas = site.rooms.subareas();
    if let Some(exits) = subareas.named('H').and_then(|hall| sets.exits.get_mut(&hall)) {
        exits.extend([DoorId(1), DoorId(2)]);
    }
    if let Some(corridor) = subareas.named('K') {
        sets.exits.insert(corridor, BTreeSet::from([DoorId(3), DoorId(7)]));
    }
    sets.pairs.extend([(DoorId(1), DoorId(4)), (DoorId(2), DoorId(4))]);
    Lmpp::with_door_sets(site.grid.clone(), site.moves, site.rooms.clone(), site.targets(), sets)
}

/// A row whose verdict is computed.
fn compared(
    table: u32,
    row: impl Into<String>,
    column: impl Into<String>,
    published: Value,
    ours: Value,
) -> Row {
    let verdict = Verdict::of(&published, &ours);
    let (row, column, note) = (row.into(), column.into(), String::new());
    let mut row = Row { paper: "LMPP", table, row, column, published, ours, verdict, note };
    if row.verdict == Verdict::Exact && row.ours_as_printed() != row.published.to_string() {
        row.add_note("but for the rounding error of a sum");
    }
    row
}

/// A row that has nothing to compare, and why.
fn uncompared(
    table: u32,
    row: impl Into<String>,
    column: impl Into<String>,
    published: Value,
    ours: Value,
    note: impl Into<String>,
) -> Row {
    let row = compared(table, row, column, published, ours);
    Row { verdict: Verdict::NotComparable, note: note.into(), ..row }
}

/// The note on rows of Tests 1 and 5.
const AS_DRAWN: &str = "doors as drawn";
/// The note on rows of Tests 3 and 4.
const AS_RUN: &str = "doors as run";

/// A location as it is printed.
fn at([x, y]: [i32; 2]) -> String {
    format!("({x}, {y})")
}
