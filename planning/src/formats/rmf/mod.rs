//! Open-RMF's buildings, as its traffic editor draws them, and the navigation graphs made from them.

pub mod building;
mod lift;
pub mod nav_graph;
mod transform;

use serde::Deserialize;

use super::yaml::YamlError;
use crate::floor_plan::PlaceKind;

/// What is wrong with a building or a navigation graph.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RmfError {
    /// It is no YAML, or lacks something.
    #[error(transparent)]
    Yaml(#[from] YamlError),
    /// There is no level.
    #[error("there is no level: expected one under `levels`")]
    NoLevel,
    /// A wall, door, lane, floor or measurement has an end that is no vertex.
    #[error(
        "level {level}: {what} {number} names vertex {vertex}: expected one of the {vertices} vertices, from 0"
    )]
    Vertex {
        /// The level.
        level: String,
        /// What it is.
        what: &'static str,
        /// Which, from 0.
        number: usize,
        /// The vertex that there is not.
        vertex: usize,
        /// How many there are.
        vertices: usize,
    },
    /// The coordinates are none that can be read.
    #[error("`coordinate_system` is `{0}`: expected reference_image or cartesian_meters")]
    Coordinates(String),
    /// A lift, or a vertex in it, names something that there is not.
    #[error("{what} names {kind} {name}: expected one of the building")]
    Unknown {
        /// What names it.
        what: String,
        /// What it should be.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// A lift's measure makes no sense.
    #[error("lift {lift}: {what} is {value}: expected metres above 0, or pixels or radians, of a usual size")]
    LiftNumber {
        /// The lift.
        lift: String,
        /// Which measure.
        what: String,
        /// As it was given.
        value: String,
    },
    /// A coordinate or a length makes no sense.
    #[error("level {level}: {what} {number} is not finite, or far too large: expected metres or pixels")]
    Number {
        /// The level.
        level: String,
        /// What it is.
        what: &'static str,
        /// Which, from 0.
        number: usize,
    },
}

/// A value of any kind; what is no scalar says nothing here.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
enum Value {
    Truth(bool),
    Number(f64),
    Text(String),
    Other(serde::de::IgnoredAny),
}

impl Value {
    /// A name; none if it is empty.
    fn name(&self) -> Option<&str> {
        match self {
            Self::Text(name) if !name.is_empty() => Some(name),
            _ => None,
        }
    }

    fn is_true(&self) -> bool {
        match self {
            Self::Truth(truth) => *truth,
            Self::Number(number) => *number != 0.0,
            Self::Text(text) => text.eq_ignore_ascii_case("true"),
            Self::Other(_) => false,
        }
    }
}

/// What a vertex is for, by what its parameters say.
fn kind<'a>(is_true: impl Fn(&'a str) -> bool) -> PlaceKind {
    if is_true("is_charger") {
        PlaceKind::Pile
    } else if is_true("is_parking_spot") {
        PlaceKind::Parking
    } else {
        PlaceKind::Other
    }
}
