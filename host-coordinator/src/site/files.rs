//! The map and the picture of the subareas that a site names.

use std::{fmt::Display, io, path::Path};

use planning::{
    formats::movingai::{self, MapProblem},
    grid::Grid,
    rooms::{Subareas, SubareasError},
};

use crate::diagnostics::Diagnostic;

/// Reads `text`, the content of the map `file`.
///
/// # Errors
/// The first mistake, with its line.
pub fn read_map(file: &Path, text: io::Result<String>) -> Result<Grid, Diagnostic> {
    let text = readable(file, text, "a MovingAI octile map")?;
    movingai::read_map(&text).map_err(|error| match error.problem {
        MapProblem::Header { expected, found } => {
            Diagnostic::new(file, error.line, format!("`{found}`"), format!("`{expected}`"))
        }
        problem => mistake(file, error.line, &problem),
    })
}

/// Reads `text`, the content of `file`: the picture of `grid`'s subareas.
pub(super) fn read_subareas(
    file: &Path,
    text: io::Result<String>,
    grid: &Grid,
) -> Result<Subareas, Diagnostic> {
    let text = readable(file, text, "a letter for every cell of the map")?;
    Subareas::read(&text, grid).map_err(|error| {
        let (SubareasError::Rows { line, .. }
        | SubareasError::Ragged { line, .. }
        | SubareasError::Terrain { line, .. }
        | SubareasError::TooMany { line }) = error;
        mistake(file, line, &error)
    })
}

fn readable(file: &Path, text: io::Result<String>, expected: &str) -> Result<String, Diagnostic> {
    text.map_err(|error| Diagnostic::new(file, None, format!("cannot be read ({error})"), expected))
}

/// A reader's error, which says `problem: expected ...`, perhaps after the line.
fn mistake(file: &Path, line: usize, error: &dyn Display) -> Diagnostic {
    let error = error.to_string();
    let error = error.strip_prefix(&format!("line {line}: ")).unwrap_or(&error);
    let (problem, expected) = error.split_once(": expected ").unwrap_or((error, "fewer"));
    Diagnostic::new(file, line, problem, expected)
}
