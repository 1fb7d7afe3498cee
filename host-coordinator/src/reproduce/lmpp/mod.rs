//! LMPP Tables 5 to 14 and the choices of Tests 3 and 4, on the reconstructed map of Fig. 7.
//!
//! A test's results stand with the table of its inputs: Test 3 with Table 8, Test 4 with
//! Table 9. `sites/lmpp-fig7/README.md` says how far to trust the map.

mod choices;
mod figures;
mod inputs;
mod lengths;
mod published;
mod times;

use std::collections::BTreeSet;

use planning::{grid::Cell, lmpp::Lmpp, memory::DoorSets, rooms::DoorId, search::Workspace};

use super::{Failed, Paper, Row, figure::Figure};
use crate::site::Site;

/// The paper.
pub const PAPER: Paper =
    Paper { name: "LMPP", tables: &["5", "6", "7", "8", "9", "10", "11", "12", "13", "14"], rows, figures };

/// Computes one table; none has another name than [`PAPER`] says.
///
/// # Errors
/// Only if the built-in site is faulty.
pub fn rows(table: &str) -> Result<Vec<Row>, Failed> {
    let compute: fn(&mut Laboratory) -> Result<Vec<Row>, Failed> = match table {
        "5" => times::table_5,
        "6" => lengths::table_6,
        "7" => choices::table_7,
        "8" => choices::table_8,
        "9" => choices::table_9,
        "10" => lengths::table_10,
        "11" => inputs::table_11,
        "12" => inputs::table_12,
        "13" => lengths::table_13,
        "14" => lengths::table_14,
        _ => return Ok(Vec::new()),
    };
    compute(&mut Laboratory::new(Site::fig7()?))
}

/// What the five tests draw.
///
/// # Errors
/// Only if the built-in site is faulty.
pub fn figures() -> Result<Vec<Figure>, Failed> {
    figures::all(&mut Laboratory::new(Site::fig7()?))
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

/// The note on rows of Tests 1 and 5.
const AS_DRAWN: &str = "doors as drawn";
/// The note on rows of Tests 3 and 4.
const AS_RUN: &str = "doors as run";

/// A location as it is printed.
fn at([x, y]: [i32; 2]) -> String {
    format!("({x}, {y})")
}
