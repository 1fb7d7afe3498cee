//! Navigation graphs that RMF's `building_map_generator nav` writes: one file a fleet, in metres, y up.
//!
//! Lanes lead one way; where robots drive both ways there are two. A graph has no walls: its grid is
//! free along the lanes.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::{RmfError, Value, kind};
use crate::{
    floor_plan::{Doorway, FloorPlan, Lane, Place, Point},
    formats::yaml,
};

#[derive(Deserialize)]
struct NavGraph {
    levels: BTreeMap<String, Level>,
    #[serde(default)]
    doors: BTreeMap<String, Door>,
}

#[derive(Deserialize)]
struct Level {
    #[serde(default)]
    vertices: Vec<Vertex>,
    #[serde(default)]
    lanes: Vec<LaneEntry>,
}

/// `[x, y, {name: ..., is_charger: true}]`
#[derive(Deserialize)]
struct Vertex(f64, f64, #[serde(default)] BTreeMap<String, Value>);

/// `[from, to, {speed_limit: ...}]`
#[derive(Deserialize)]
struct LaneEntry(usize, usize, #[serde(default)] serde::de::IgnoredAny);

#[derive(Deserialize)]
struct Door {
    endpoints: [Point; 2],
    /// The level that it is on.
    map: String,
}

/// Reads a navigation graph: a floor plan of lanes for each level, in the order of their names.
///
/// # Errors
/// [`RmfError`] names what is wrong.
pub fn read(text: &str) -> Result<Vec<FloorPlan>, RmfError> {
    let graph: NavGraph = yaml::read(text)?;
    if graph.levels.is_empty() {
        return Err(RmfError::NoLevel);
    }
    for (number, door) in graph.doors.values().enumerate() {
        check(&door.map, "door", number, door.endpoints.as_flattened())?;
    }
    let level = |(name, level): (&String, &Level)| {
        let on_level = graph.doors.iter().filter(|(_, door)| door.map == *name);
        let doors = on_level.map(|(name, door)| Doorway { name: name.clone(), ends_m: door.endpoints });
        Ok(FloorPlan {
            name: name.clone(),
            places: level.places(name)?,
            doors: doors.collect(),
            lanes: level.lanes(name)?,
            ..FloorPlan::default()
        })
    };
    graph.levels.iter().map(level).collect()
}

fn check(level: &str, what: &'static str, number: usize, coordinates: &[f64]) -> Result<(), RmfError> {
    let sound = coordinates.iter().all(|coordinate| coordinate.abs() < 1e9);
    sound.then_some(()).ok_or_else(|| RmfError::Number { level: level.to_owned(), what, number })
}

impl Level {
    fn places(&self, name: &str) -> Result<Vec<Place>, RmfError> {
        let place = |(number, Vertex(x, y, parameters)): (usize, &Vertex)| {
            check(name, "vertex", number, &[*x, *y])?;
            let name = match parameters.get("name") {
                Some(Value::Text(name)) => name.clone(),
                _ => String::new(),
            };
            let kind = kind(|key| parameters.get(key).is_some_and(Value::is_true));
            Ok(Place { name, at_m: [*x, *y], kind })
        };
        self.vertices.iter().enumerate().map(place).collect()
    }

    fn lanes(&self, name: &str) -> Result<Vec<Lane>, RmfError> {
        let vertices = self.vertices.len();
        let lane = |(number, &LaneEntry(from, to, _)): (usize, &LaneEntry)| {
            let unknown = [from, to].into_iter().find(|&vertex| vertex >= vertices);
            let unknown = unknown.map(|vertex| {
                let level = name.to_owned();
                RmfError::Vertex { level, what: "lane", number, vertex, vertices }
            });
            unknown.map_or(Ok(Lane { ends: [from, to], both_ways: false }), Err)
        };
        self.lanes.iter().enumerate().map(lane).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::floor_plan::PlaceKind;

    const GRAPH: &str = "\
building_name: building
doors:
  main_door:
    door_axis: start
    endpoints:
    - [1.5, -2]
    - [2.5, -2]
    map: L1
levels:
  L1:
    lanes:
    - - 0
      - 1
      - {speed_limit: 0}
    - [1, 0, &none {}]
    vertices:
    - [1, -1, {name: dock, is_charger: true}]
    - [3, -4, *none]
lifts: {}
";

    #[test]
    fn a_graph_has_places_lanes_and_doors() {
        let [level] = <[_; 1]>::try_from(read(GRAPH).unwrap()).unwrap();
        let dock = Place { name: "dock".into(), at_m: [1.0, -1.0], kind: PlaceKind::Pile };
        assert_eq!((&level.places[0], level.places.len()), (&dock, 2));
        assert_eq!(level.lanes.iter().map(|lane| lane.ends).collect::<Vec<_>>(), [[0, 1], [1, 0]]);
        assert_eq!(level.doors[0].ends_m, [[1.5, -2.0], [2.5, -2.0]]);
    }

    #[test]
    fn a_lane_to_nowhere_is_named() {
        let error = read(&GRAPH.replace("[1, 0, &none", "[1, 2, &none")).unwrap_err().to_string();
        assert_eq!(error, "level L1: lane 1 names vertex 2: expected one of the 2 vertices, from 0");
    }
}
