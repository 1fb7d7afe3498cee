//! Coordinates on the command line.

use std::{fmt, str::FromStr};

/// A cell as a person gives it: `X,Y`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Point {
    /// To the right.
    pub x: i32,
    /// Up or down, as the site counts.
    pub y: i32,
}

impl Point {
    /// The point at these coordinates.
    pub const fn of((x, y): (i32, i32)) -> Self {
        Self { x, y }
    }
}

impl FromStr for Point {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let whole = |number: &str| number.trim().parse().ok();
        let point = text.split_once(',').and_then(|(x, y)| Some(Self { x: whole(x)?, y: whole(y)? }));
        point.ok_or_else(|| "expected two whole numbers as X,Y, such as 12,40".into())
    }
}

impl fmt::Display for Point {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "({}, {})", self.x, self.y)
    }
}
