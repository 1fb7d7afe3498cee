//! MovingAI's octile maps (`.map`).
//!
//! ```text
//! type octile
//! height 2
//! width 3
//! map
//! ..@
//! .TG
//! ```
//! `.`, `G` (ground) and `S` (swamp) are free; `@`, `O` (out of bounds), `T` (trees) and `W`
//! (water) are blocked: no robot swims. Lines may end in CR LF; blank lines may follow the map.

use crate::grid::{Grid, MAX_SIDE};

/// What is wrong with a map, and in which line (from 1).
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {problem}")]
pub struct MapError {
    /// The line, from 1.
    pub line: usize,
    /// What is wrong with it.
    pub problem: MapProblem,
}

/// What can be wrong with a line of a map.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MapProblem {
    /// The header does not continue as it should.
    #[error("expected `{expected}`, found `{found}`")]
    Header {
        /// What should stand here.
        expected: &'static str,
        /// What does, cut short.
        found: String,
    },
    /// A side is zero or longer than a grid can be.
    #[error("a side of {side} cells: expected 1 to {MAX_SIDE}")]
    Side {
        /// The side.
        side: u32,
    },
    /// A row is too long or too short.
    #[error("a row of {found} cells: expected {expected}, as the width says")]
    Ragged {
        /// The width.
        expected: u32,
        /// How many cells the row has.
        found: usize,
    },
    /// A character that stands for no terrain.
    #[error("`{found}` in column {column} is no terrain: expected one of . G S @ O T W")]
    Terrain {
        /// The character.
        found: char,
        /// Its column, from 1.
        column: usize,
    },
    /// The file ends before the last row.
    #[error("the map ends after {found} rows: expected {expected}, as the height says")]
    TooFewRows {
        /// The height.
        expected: u32,
        /// How many rows there are.
        found: u32,
    },
    /// Something follows the last row.
    #[error("text after the last of {expected} rows: expected the end of the file")]
    TooManyRows {
        /// The height.
        expected: u32,
    },
}

/// Reads a map.
///
/// # Errors
/// [`MapError`] names the first line that is wrong.
pub fn read_map(text: &str) -> Result<Grid, MapError> {
    let mut lines = Lines { lines: text.lines(), line: 0 };
    lines.keyword("type octile")?;
    let height = lines.side("height", "height N")?;
    let width = lines.side("width", "width N")?;
    lines.keyword("map")?;
    // A header may promise more than the file holds: memory grows with the text only.
    let mut cells = Vec::new();
    for y in 0..height {
        let Some(row) = lines.next() else {
            return Err(lines.error(MapProblem::TooFewRows { expected: height, found: y }));
        };
        lines.row(row, width, &mut cells)?;
    }
    while let Some(rest) = lines.next() {
        if !rest.trim().is_empty() {
            return Err(lines.error(MapProblem::TooManyRows { expected: height }));
        }
    }
    let too_large = |_| lines.error(MapProblem::Side { side: width.max(height) });
    let mut grid = Grid::blocked(width, height).map_err(too_large)?;
    for (index, free) in cells.into_iter().enumerate() {
        grid.set(grid.cell(index), free);
    }
    Ok(grid)
}

/// Writes a map: `.` for free cells, `@` for blocked ones.
#[must_use]
pub fn write_map(grid: &Grid) -> String {
    let mut text = format!("type octile\nheight {}\nwidth {}\nmap\n", grid.height(), grid.width());
    for index in 0..grid.len() {
        let cell = grid.cell(index);
        text.push(if grid.is_free(cell) { '.' } else { '@' });
        if cell.x as u32 + 1 == grid.width() {
            text.push('\n');
        }
    }
    text
}

struct Lines<'a> {
    lines: std::str::Lines<'a>,
    line: usize,
}

impl<'a> Lines<'a> {
    fn next(&mut self) -> Option<&'a str> {
        self.line += 1;
        self.lines.next()
    }

    const fn error(&self, problem: MapProblem) -> MapError {
        MapError { line: self.line, problem }
    }

    fn header(&self, expected: &'static str, found: &str) -> MapError {
        self.error(MapProblem::Header { expected, found: found.chars().take(40).collect() })
    }

    fn keyword(&mut self, expected: &'static str) -> Result<(), MapError> {
        let found = self.next().unwrap_or_default();
        if found.split_whitespace().eq(expected.split_whitespace()) {
            Ok(())
        } else {
            Err(self.header(expected, found))
        }
    }

    fn side(&mut self, name: &str, expected: &'static str) -> Result<u32, MapError> {
        let found = self.next().unwrap_or_default();
        let mut words = found.split_whitespace();
        let side = (words.next() == Some(name))
            .then(|| words.next()?.parse().ok())
            .flatten()
            .filter(|_| words.next().is_none())
            .ok_or_else(|| self.header(expected, found))?;
        if (1..=MAX_SIDE).contains(&side) { Ok(side) } else { Err(self.error(MapProblem::Side { side })) }
    }

    fn row(&self, row: &str, width: u32, cells: &mut Vec<bool>) -> Result<(), MapError> {
        let found = row.chars().count();
        if found != width as usize {
            return Err(self.error(MapProblem::Ragged { expected: width, found }));
        }
        for (column, terrain) in (1..).zip(row.chars()) {
            cells.push(match terrain {
                '.' | 'G' | 'S' => true,
                '@' | 'O' | 'T' | 'W' => false,
                found => return Err(self.error(MapProblem::Terrain { found, column })),
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const HEAD: &str = "type octile\nheight 2\nwidth 3\nmap\n";

    fn error(body: &str) -> String {
        read_map(&format!("{HEAD}{body}")).unwrap_err().to_string()
    }

    #[test]
    fn a_ragged_row_is_named_by_its_line() {
        assert_eq!(error("...\n..\n"), "line 6: a row of 2 cells: expected 3, as the width says");
    }

    #[test]
    fn missing_and_surplus_rows_are_told_apart() {
        assert_eq!(error("...\n"), "line 6: the map ends after 1 rows: expected 2, as the height says");
        assert_eq!(
            error("...\n...\n\n..."),
            "line 8: text after the last of 2 rows: expected the end of the file"
        );
    }

    #[test]
    fn a_strange_character_is_named_with_its_column() {
        assert_eq!(
            error("...\n.x.\n"),
            "line 6: `x` in column 2 is no terrain: expected one of . G S @ O T W"
        );
    }

    #[test]
    fn a_header_that_is_none_is_quoted() {
        assert_eq!(
            read_map("height 3").unwrap_err().to_string(),
            "line 1: expected `type octile`, found `height 3`"
        );
        assert_eq!(
            read_map("type octile\nheight -3\n").unwrap_err().to_string(),
            "line 2: expected `height N`, found `height -3`"
        );
        assert_eq!(
            read_map("type octile\nheight 70000\n").unwrap_err().to_string(),
            "line 2: a side of 70000 cells: expected 1 to 65535"
        );
    }

    #[test]
    fn windows_line_ends_are_read() {
        let unix = format!("{HEAD}.@.\n...\n");
        assert_eq!(read_map(&unix.replace('\n', "\r\n")), read_map(&unix));
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_again(width in 1u32..20, cells in prop::collection::vec(any::<bool>(), 1..200)) {
            let height = (cells.len() as u32).div_ceil(width);
            let mut grid = Grid::blocked(width, height).unwrap();
            for (index, &free) in cells.iter().enumerate() {
                grid.set(grid.cell(index), free);
            }
            prop_assert_eq!(read_map(&write_map(&grid)), Ok(grid));
        }

        #[test]
        fn no_text_makes_the_reader_panic(text in "(type octile\n)?(height [0-9]{1,10}\n)?(width [0-9]{1,10}\n)?(map\n)?[.@TGx\r\n\u{e9}]{0,50}") {
            let _ = read_map(&text);
        }
    }
}
