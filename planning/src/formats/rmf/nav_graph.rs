//! Navigation graphs that RMF's `building_map_generator nav` writes: one file a fleet, in metres, y up.
//!
//! Lanes lead one way; where robots drive both ways there are two. A graph has no walls: its grid is
//! free along the lanes and in the cabins of lifts. A lift stops where a vertex is in its cabin.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::{RmfError, Value, kind, lift};
use crate::{
    floor_plan::{Doorway, FloorPlan, Lane, Place, Point},
    formats::yaml,
};

#[derive(Deserialize)]
struct NavGraph {
    levels: BTreeMap<String, Level>,
    #[serde(default)]
    doors: BTreeMap<String, Door>,
    #[serde(default)]
    lifts: BTreeMap<String, lift::OfGraph>,
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
    let cabins = graph.levels.iter();
    let cabins =
        cabins.map(|(name, level)| (name.as_str(), level.vertices.iter().map(Vertex::cabin).collect()));
    let lifts = lift::of_graph(&graph.lifts, &cabins.collect())?;
    let level = |(name, level): (&String, &Level)| {
        let on_level = graph.doors.iter().filter(|(_, door)| door.map == *name);
        let doors = on_level.map(|(name, door)| Doorway { name: name.clone(), ends_m: door.endpoints });
        Ok(FloorPlan {
            name: name.clone(),
            places: level.places(name)?,
            doors: doors.collect(),
            lanes: level.lanes(name)?,
            lifts: lifts.get(name).cloned().unwrap_or_default(),
            ..FloorPlan::default()
        })
    };
    graph.levels.iter().map(level).collect()
}

fn check(level: &str, what: &'static str, number: usize, coordinates: &[f64]) -> Result<(), RmfError> {
    let sound = coordinates.iter().all(|coordinate| coordinate.abs() < 1e9);
    sound.then_some(()).ok_or_else(|| RmfError::Number { level: level.to_owned(), what, number })
}

impl Vertex {
    /// The lift in whose cabin it is.
    fn cabin(&self) -> Option<&str> {
        self.2.get("lift")?.name()
    }
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
            unknown.map_or(Ok(Lane { ends: [from, to], via_m: Vec::new(), both_ways: false }), Err)
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

    fn with_lift() -> String {
        let level = "  L2:\n    vertices: [[3, -4, {lift: up}]]\n";
        let lift = "lifts: {up: {position: [3, -4, 0.5], dims: [2, 3]}}";
        GRAPH
            .replace("*none]", "{lift: up}]")
            .replace("&none ", "")
            .replace("lifts: {}", &format!("{level}{lift}"))
    }

    #[test]
    fn a_lift_stops_where_a_vertex_is_in_its_cabin() {
        let plans = read(&with_lift()).unwrap();
        let stops: Vec<_> = plans.iter().map(|plan| plan.lifts[0].places.as_slice()).collect();
        assert_eq!(stops, [&[1][..], &[0]]);
        assert_eq!(plans[1].lifts[0].storeys, ["L1", "L2"]);
        assert!(read(&GRAPH.replace("{name: dock,", "{name: dock, lift: up,")).is_ok(), "no lifts are known");
        let error = read(&with_lift().replacen("{lift: up}", "{lift: down}", 1)).unwrap_err();
        assert_eq!(error.to_string(), "level L1: vertex 1 names lift down: expected one of the building");
    }

    #[test]
    fn a_lane_to_nowhere_is_named() {
        let error = read(&GRAPH.replace("[1, 0, &none", "[1, 2, &none")).unwrap_err().to_string();
        assert_eq!(error, "level L1: lane 1 names vertex 2: expected one of the 2 vertices, from 0");
    }
}
