//! What an experiment draws: curves, or paths on a map. Plain data; the shell renders it.

use planning::grid::Grid;

/// One picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// The file's name without its ending, such as `access-experiment-1`.
    pub name: String,
    /// What stands above it.
    pub title: String,
    /// What is drawn.
    pub content: Content,
}

/// What is drawn.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    /// Lines in a coordinate system.
    Curves {
        /// What the x axis measures, with its unit.
        x: String,
        /// What the y axis measures, with its unit.
        y: String,
        /// The lines.
        lines: Vec<Line>,
    },
    /// Paths on a map.
    Map {
        /// The map.
        grid: Grid,
        /// The paths, in cells: x to the right, y down; a cell's middle is at its whole numbers.
        lines: Vec<Line>,
        /// Places with names, such as piles.
        marks: Vec<Mark>,
    },
}

/// A line through points.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// What the legend says.
    pub label: String,
    /// Its points in order.
    pub points: Vec<(f64, f64)>,
}

/// A named place on a map.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// Its name.
    pub label: String,
    /// Where, in cells as [`Content::Map`] counts them.
    pub at: (f64, f64),
}
