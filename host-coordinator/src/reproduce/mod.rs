//! The papers' tables and experiments, computed again and compared with what is printed: a module a
//! paper.
//!
//! | module | one idea |
//! |---|---|
//! | [`row`] | one number beside ours, and the verdict |
//! | [`figure`] | what an experiment draws, as plain data |
//! | [`render`] | figures as PNG and SVG |
//! | [`lmpp`], [`access`], [`mecanum`], [`igwo`] | a paper each: its tables and figures |
//!
//! To add a paper, write its module with a [`Paper`] and name it in [`PAPERS`].

pub mod access;
pub mod figure;
pub mod igwo;
pub mod lmpp;
pub mod mecanum;
pub mod render;
pub mod row;

use planning::search::SearchError;

use self::figure::Figure;
pub use self::row::{Printed, Row, Value, Verdict};
use crate::{diagnostics::Diagnostics, site::OutsideMap};

/// Every paper that is reproduced.
pub const PAPERS: &[Paper] = &[lmpp::PAPER, access::PAPER, mecanum::PAPER, igwo::PAPER];

/// A paper, and how its tables and figures are computed.
#[derive(Debug)]
pub struct Paper {
    /// Its short name, such as `LMPP`; in small letters on the command line.
    pub name: &'static str,
    /// Its tables and experiments that are compared, as [`Row::table`] names them.
    pub tables: &'static [&'static str],
    /// The rows of one of [`Self::tables`].
    pub rows: fn(&str) -> Result<Vec<Row>, Failed>,
    /// What its experiments draw.
    pub figures: fn() -> Result<Vec<Figure>, Failed>,
}

/// Why a table or a figure can't be computed.
#[derive(Debug, thiserror::Error)]
pub enum Failed {
    /// No such paper is reproduced.
    #[error("paper `{name}` is not reproduced: give one of {known}")]
    NoSuchPaper {
        /// What was asked for.
        name: String,
        /// What there is.
        known: String,
    },
    /// No such table is reproduced.
    #[error("table {table} is not reproduced: there are {known}")]
    NoSuchTable {
        /// What was asked for.
        table: String,
        /// What there is.
        known: String,
    },
    /// The program was built with a faulty site.
    #[error(transparent)]
    Site(#[from] Diagnostics),
    /// A printed location is not on the map.
    #[error("a location that the paper prints is not on the map: {0}")]
    Outside(#[from] OutsideMap),
    /// There is no path between locations that the paper prints.
    #[error("no path between locations that the paper prints: {0}")]
    Search(#[from] SearchError),
}

/// The papers and tables that are asked for, all where none is named; case does not matter.
///
/// # Errors
/// [`Failed::NoSuchPaper`], [`Failed::NoSuchTable`].
pub fn chosen(
    paper: Option<&str>,
    table: Option<&str>,
) -> Result<Vec<(&'static Paper, Vec<&'static str>)>, Failed> {
    let is = |asked: Option<&str>, name: &str| asked.is_none_or(|asked| asked.eq_ignore_ascii_case(name));
    let papers: Vec<_> = PAPERS.iter().filter(|known| is(paper, known.name)).collect();
    if papers.is_empty() {
        let known = PAPERS.iter().map(|paper| paper.name.to_lowercase()).collect::<Vec<_>>().join(", ");
        return Err(Failed::NoSuchPaper { name: paper.unwrap_or_default().into(), known });
    }
    let of = |paper: &'static Paper| -> Vec<_> {
        paper.tables.iter().copied().filter(|name| is(table, name)).collect()
    };
    let all = papers.iter().map(|&paper| (paper, of(paper)));
    let found: Vec<_> = all.filter(|(_, tables)| !tables.is_empty()).collect();
    if found.is_empty() {
        let known = papers.iter().map(|paper| format!("{} {}", paper.name, paper.tables.join(", ")));
        let known = known.collect::<Vec<_>>().join("; ");
        return Err(Failed::NoSuchTable { table: table.unwrap_or_default().into(), known });
    }
    Ok(found)
}
