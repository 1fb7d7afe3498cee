//! What an experiment draws: curves, or paths on a map. Plain data; the shell renders it.

use planning::{
    grid::{Cell, Grid},
    path::Path,
};

use crate::site::SiteFrame;

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
    /// Bars side by side.
    Bars {
        /// What stands below each group of bars.
        groups: Vec<String>,
        /// What the bars measure, with its unit.
        y: String,
        /// A bar of each in every group.
        series: Vec<Series>,
    },
    /// Paths on a map.
    Map {
        /// The map.
        grid: Grid,
        /// How the axes count its cells.
        frame: SiteFrame,
        /// The paths, in cells: x to the right, y down; a cell's middle is at its whole numbers.
        lines: Vec<Line>,
        /// Places with names, such as piles.
        marks: Vec<Mark>,
    },
}

/// A line through points. Lines with one label share a colour and an entry of the legend; the first label
/// is drawn below the others, and wider where there are two or three, so that one path shows on another.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// What the legend says.
    pub label: String,
    /// Its points in order.
    pub points: Vec<(f64, f64)>,
}

impl Line {
    /// A path on a map.
    #[must_use]
    pub fn of_path(label: impl Into<String>, path: &Path) -> Self {
        Self { label: label.into(), points: path.waypoints().iter().copied().map(middle).collect() }
    }
}

/// The bars of one kind, the first in the first group.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// What the legend says.
    pub label: String,
    /// How high they are; 0 or more.
    pub values: Vec<f64>,
}

impl Mark {
    /// A mark on a cell.
    #[must_use]
    pub fn on(label: impl Into<String>, cell: Cell) -> Self {
        Self { label: label.into(), at: middle(cell) }
    }
}

/// The middle of a cell, as [`Content::Map`] counts.
fn middle(cell: Cell) -> (f64, f64) {
    (cell.x.into(), cell.y.into())
}

/// A named place on a map.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// Its name.
    pub label: String,
    /// Where, in cells as [`Content::Map`] counts them.
    pub at: (f64, f64),
}
