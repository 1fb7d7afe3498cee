//! MovingAI's scenarios (`.scen`): queries on a map, each with its optimal length.
//!
//! ```text
//! version 1
//! 0 arena2.map 281 209 99 159 101 162 3.82842712
//! ```
//! A line a query: bucket, map, its width and height, start x and y, goal x and y, and the optimal
//! length with straight moves of 1, diagonal ones of sqrt 2 and no corner cutting. Tabs or blanks
//! part them; lines may end in CR LF. `version 1.0` is the same, and the line may be missing.

use crate::grid::{Cell, MAX_SIDE};

/// One query.
#[derive(Clone, Debug, PartialEq)]
pub struct Query {
    /// The map's file name, as written.
    pub map: String,
    /// The map's columns, as the scenario says.
    pub width: u32,
    /// The map's rows, as the scenario says.
    pub height: u32,
    /// The start.
    pub from: Cell,
    /// The goal.
    pub to: Cell,
    /// The optimal length in cells.
    pub optimal: f64,
}

/// What is wrong with a scenario, and in which line (from 1).
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {problem}")]
pub struct ScenError {
    /// The line, from 1.
    pub line: usize,
    /// What is wrong with it.
    pub problem: ScenProblem,
}

/// What can be wrong with a line of a scenario.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ScenProblem {
    /// A version we do not know.
    #[error("version `{found}`: expected 1")]
    Version {
        /// What stands there, cut short.
        found: String,
    },
    /// A query has too many fields or too few.
    #[error(
        "{found} fields: expected 9, bucket, map, width, height, start x, start y, goal x, goal y and length"
    )]
    Fields {
        /// How many it has.
        found: usize,
    },
    /// A field is no number of its kind.
    #[error("{name} is `{found}`: expected {expected}")]
    Number {
        /// Which field.
        name: &'static str,
        /// What stands there, cut short.
        found: String,
        /// What should.
        expected: &'static str,
    },
    /// A start or goal is outside the map.
    #[error("cell {cell} is outside the map of {width} x {height} cells")]
    Outside {
        /// Which cell.
        cell: Cell,
        /// The map's columns.
        width: u32,
        /// The map's rows.
        height: u32,
    },
}

/// Reads a scenario.
///
/// # Errors
/// [`ScenError`] names the first line that is wrong.
pub fn read_scen(text: &str) -> Result<Vec<Query>, ScenError> {
    let mut queries = Vec::new();
    for (line, text) in (1..).zip(text.lines()) {
        let fields: Vec<&str> = text.split_whitespace().collect();
        let result = match *fields.as_slice() {
            [] => continue,
            ["version", "1" | "1.0"] if line == 1 => continue,
            ["version", found, ..] if line == 1 => Err(ScenProblem::Version { found: cut(found) }),
            _ => query(&fields),
        };
        queries.push(result.map_err(|problem| ScenError { line, problem })?);
    }
    Ok(queries)
}

fn query(fields: &[&str]) -> Result<Query, ScenProblem> {
    let &[_bucket, map, width, height, from_x, from_y, to_x, to_y, optimal] = fields else {
        return Err(ScenProblem::Fields { found: fields.len() });
    };
    let (width, height) = (side("width", width)?, side("height", height)?);
    let cell = |x, y| {
        let cell = Cell { x, y };
        // A side fits 16 bits.
        if x < width as i32 && y < height as i32 {
            Ok(cell)
        } else {
            Err(ScenProblem::Outside { cell, width, height })
        }
    };
    let from = cell(coordinate("start x", from_x)?, coordinate("start y", from_y)?)?;
    let to = cell(coordinate("goal x", to_x)?, coordinate("goal y", to_y)?)?;
    let length = |length: &f64| length.is_finite() && *length >= 0.0;
    let optimal = number("length", optimal, "a length in cells", length)?;
    Ok(Query { map: map.into(), width, height, from, to, optimal })
}

fn side(name: &'static str, text: &str) -> Result<u32, ScenProblem> {
    number(name, text, "1 to 65535 cells", |side| (1..=MAX_SIDE).contains(side))
}

fn coordinate(name: &'static str, text: &str) -> Result<i32, ScenProblem> {
    number(name, text, "a column or row, from 0", |&coordinate| coordinate >= 0)
}

fn number<T: std::str::FromStr>(
    name: &'static str,
    text: &str,
    expected: &'static str,
    is_valid: impl Fn(&T) -> bool,
) -> Result<T, ScenProblem> {
    let wrong = || ScenProblem::Number { name, found: cut(text), expected };
    text.parse().ok().filter(is_valid).ok_or_else(wrong)
}

/// At most 40 characters of `text`.
fn cut(text: &str) -> String {
    text.chars().take(40).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const QUERY: &str = "0 a.map 7 5 1 2 6 4 7.5";

    fn error(text: &str) -> String {
        read_scen(text).unwrap_err().to_string()
    }

    #[test]
    fn tabs_blanks_windows_line_ends_and_a_missing_version_are_read() {
        let read = read_scen(QUERY).unwrap();
        let (from, to) = (Cell { x: 1, y: 2 }, Cell { x: 6, y: 4 });
        let expected = Query { map: "a.map".into(), width: 7, height: 5, from, to, optimal: 7.5 };
        assert_eq!(read, [expected]);
        for version in ["version 1\n", "version 1.0\r\n", "version\t1\n\n"] {
            assert_eq!(read_scen(&format!("{version}{}\r\n", QUERY.replace(' ', "\t"))).unwrap(), read);
        }
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        assert_eq!(error("version 2\n"), "line 1: version `2`: expected 1");
        assert!(error(&format!("version 1\n{QUERY} 8")).starts_with("line 2: 10 fields: expected 9, bucket"));
        assert_eq!(
            error("\n0 a.map 7 5 1 -2 6 4 7.5"),
            "line 2: start y is `-2`: expected a column or row, from 0"
        );
        assert_eq!(error("0 a.map 7 5 1 2 6 5 7.5"), "line 1: cell (6, 5) is outside the map of 7 x 5 cells");
        assert_eq!(
            error("0 a.map 70000 5 1 2 6 4 7.5"),
            "line 1: width is `70000`: expected 1 to 65535 cells"
        );
        assert_eq!(error("0 a.map 7 5 1 2 6 4 nan"), "line 1: length is `nan`: expected a length in cells");
    }

    proptest! {
        #[test]
        fn no_text_makes_the_reader_panic(
            text in "(version [0-9.]{1,3}\n)?([0-9a\u{e9}]{0,3}[\t ]){6,9}[-0-9.einf]{0,6}\r?\n?", rest in ".*",
        ) {
            let _ = read_scen(&(text + &rest));
        }
    }
}
