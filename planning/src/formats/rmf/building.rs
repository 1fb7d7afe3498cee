//! Buildings as Open-RMF's traffic editor keeps them: `*.building.yaml`.
//!
//! Vertices are in pixels of a level's drawing, y down; the level's measurements say how long a pixel
//! is (their mean, or 0.05 m where there are none). Levels other than the reference level, which is the
//! one the file names or else the first, are laid over it by the fiducials that both have, two at
//! least. The world is in metres of the reference level, y up, as in RMF's own graphs: a vertex of
//! the reference level at (x, y) pixels is at (x, -y) times its scale. With `coordinate_system:
//! cartesian_meters` all that is as it stands.
//!
//! A lift is part of every storey where it stops. A vertex is in its cabin if its `lift_cabin` says so, or if
//! a lane leads to it and it says nothing and lies within.
//!
//! Drawings, layers, models (furniture) and crowds are not read.

use std::collections::{BTreeMap, BTreeSet};

use serde::Deserialize;

use super::{
    RmfError, Value, kind,
    lift::{self, Part, Storeys},
    transform::Similarity,
};
use crate::{
    floor_plan::{Doorway, FloorPlan, Lane, Lift, Place, Point},
    formats::yaml,
};

/// How long a pixel is where nobody has measured, in metres: as the traffic editor takes it.
const UNMEASURED_M: f64 = 0.05;

type Parameters = BTreeMap<String, Vec<Value>>;

#[derive(Deserialize)]
struct Building {
    levels: BTreeMap<String, Level>,
    coordinate_system: Option<String>,
    reference_level_name: Option<String>,
    #[serde(default)]
    lifts: BTreeMap<String, lift::OfBuilding>,
}

#[derive(Deserialize)]
struct Level {
    #[serde(default)]
    elevation: f64,
    #[serde(default)]
    vertices: Vec<Vertex>,
    #[serde(default)]
    walls: Vec<Edge>,
    #[serde(default)]
    doors: Vec<Edge>,
    #[serde(default)]
    lanes: Vec<Edge>,
    #[serde(default)]
    measurements: Vec<Edge>,
    #[serde(default)]
    floors: Vec<Polygon>,
    #[serde(default)]
    holes: Vec<Polygon>,
    #[serde(default)]
    fiducials: Vec<(f64, f64, String)>,
}

/// `[x, y, z, name, {parameter: [type, value]}]`
#[derive(Deserialize)]
struct Vertex(f64, f64, #[serde(default)] f64, #[serde(default)] String, #[serde(default)] Parameters);

/// `[from, to, {parameter: [type, value]}]`
#[derive(Deserialize)]
struct Edge(usize, usize, #[serde(default)] Parameters);

#[derive(Deserialize)]
struct Polygon {
    vertices: Vec<usize>,
}

/// A parameter's value, which its type precedes.
fn parameter<'a>(parameters: &'a Parameters, name: &str) -> Option<&'a Value> {
    parameters.get(name)?.last()
}

/// Reads a building: a floor plan for each level, in the order of their names.
///
/// # Errors
/// [`RmfError`] names what is wrong.
pub fn read(text: &str) -> Result<Vec<FloorPlan>, RmfError> {
    let building: Building = yaml::read(text)?;
    let metric = match building.coordinate_system.as_deref() {
        None | Some("reference_image") => false,
        Some("cartesian_meters") => true,
        Some(other) => return Err(RmfError::Coordinates(other.to_owned())),
    };
    let named = building.reference_level_name.as_deref();
    let named = named.and_then(|name| building.levels.get_key_value(name));
    let (reference, level) = named.or_else(|| building.levels.first_key_value()).ok_or(RmfError::NoLevel)?;
    let scale = if metric { 1.0 } else { scale(reference, level)? };
    // The first of those with the same name.
    let named = level.fiducials.iter().rev().filter(|(.., id)| !id.is_empty());
    let known: BTreeMap<_, _> = named.map(|(x, y, id)| (id, [x * scale, y * scale])).collect();
    let to_metres = |(name, own): (&String, &Level)| {
        let pairs = own.fiducials.iter().filter_map(|(x, y, id)| Some(([*x, *y], *known.get(id)?)));
        let over = Similarity::between(&pairs.collect::<Vec<_>>()).filter(|_| !metric && name != reference);
        let to_metres = match over {
            Some(over) => over,
            None if metric => Similarity::scale(1.0),
            None => Similarity::scale(self::scale(name, own)?),
        };
        Ok((name.clone(), to_metres))
    };
    let to_metres: BTreeMap<_, _> = building.levels.iter().map(to_metres).collect::<Result<_, RmfError>>()?;
    let up = if metric { 1.0 } else { -1.0 };
    let world = |level: &str, point: Point| {
        let [x, y] = to_metres.get(level).map_or(point, |to_metres| to_metres.apply(point));
        [x, up * y]
    };
    let plan = |(name, own): (&String, &Level)| {
        Reader { name, level: own, vertices: own.world(name, |point| world(name, point))? }.plan()
    };
    let mut plans = building.levels.iter().map(plan).collect::<Result<Vec<_>, _>>()?;
    let storeys = Storeys {
        reference,
        elevations: building.levels.iter().map(|(name, level)| (name.as_str(), level.elevation)).collect(),
    };
    for (name, lift) in &building.lifts {
        let mut parts = lift.parts(name, &storeys, world)?;
        for (plan, level) in plans.iter_mut().zip(building.levels.values()) {
            match parts.remove(plan.name.as_str()) {
                Some(Part::Stop(lift)) => {
                    let places = level.places_in(&lift, &plan.places);
                    plan.lifts.push(Lift { places, ..lift });
                }
                Some(Part::Shaft(corners)) => plan.holes.push(corners.to_vec()),
                None => {}
            }
        }
    }
    for (name, level) in &building.levels {
        level.check_cabins(name, &building.lifts)?;
    }
    Ok(plans)
}

/// How long a pixel of a level is, in metres.
fn scale(name: &str, level: &Level) -> Result<f64, RmfError> {
    let mut scales = Vec::new();
    for (number, Edge(from, to, parameters)) in level.measurements.iter().enumerate() {
        let what = "measurement";
        let vertices = level.vertices.len();
        let end = |vertex: usize| {
            let unknown = RmfError::Vertex { level: name.to_owned(), what, number, vertex, vertices };
            level.vertices.get(vertex).map(|end| [end.0, end.1]).ok_or(unknown)
        };
        let (from, to) = (end(*from)?, end(*to)?);
        let pixels = (from[0] - to[0]).hypot(from[1] - to[1]);
        let metres = match parameter(parameters, "distance") {
            Some(Value::Number(metres)) => *metres,
            _ => f64::NAN,
        };
        let scale = metres / pixels;
        if !(1e-6..=1e3).contains(&scale) {
            return Err(RmfError::Number { level: name.to_owned(), what, number });
        }
        scales.push(scale);
    }
    let sum: f64 = scales.iter().sum();
    Ok(if scales.is_empty() { UNMEASURED_M } else { sum / scales.len() as f64 })
}

impl Level {
    /// The vertices' places in the world.
    fn world(&self, name: &str, world: impl Fn(Point) -> Point) -> Result<Vec<Point>, RmfError> {
        let place = |(number, vertex): (usize, &Vertex)| {
            let place = world([vertex.0, vertex.1]);
            let sound = place.iter().chain([&vertex.2]).all(|coordinate| coordinate.abs() < 1e9);
            sound.then_some(place).ok_or_else(|| RmfError::Number {
                level: name.to_owned(),
                what: "vertex",
                number,
            })
        };
        self.vertices.iter().enumerate().map(place).collect()
    }
}

impl Vertex {
    /// The lift in whose cabin it says that it is.
    fn cabin(&self) -> Option<&str> {
        parameter(&self.4, "lift_cabin")?.name()
    }
}

impl Level {
    /// The vertices, which are at these places, in a lift's cabin.
    fn places_in(&self, lift: &Lift, places: &[Place]) -> Vec<usize> {
        let on_lanes: BTreeSet<usize> = self.lanes.iter().flat_map(|lane| [lane.0, lane.1]).collect();
        let is_in = |(number, (vertex, place)): (usize, (&Vertex, &Place))| {
            let inside = vertex.cabin().map_or_else(
                || on_lanes.contains(&number) && lift.holds(place.at_m),
                |cabin| cabin == lift.name,
            );
            inside.then_some(number)
        };
        self.vertices.iter().zip(places).enumerate().filter_map(is_in).collect()
    }

    /// Whether there are all the lifts that vertices are said to be in.
    fn check_cabins(&self, name: &str, lifts: &BTreeMap<String, lift::OfBuilding>) -> Result<(), RmfError> {
        let mut cabins = self.vertices.iter().map(Vertex::cabin).enumerate();
        let unknown = cabins.find_map(|(number, cabin)| {
            let cabin = cabin.filter(|cabin| !lifts.contains_key(*cabin))?;
            Some(lift::unknown(format!("level {name}: vertex {number}"), "lift", cabin))
        });
        unknown.map_or(Ok(()), Err)
    }
}

/// A level while it is made a floor plan.
struct Reader<'a> {
    name: &'a str,
    level: &'a Level,
    vertices: Vec<Point>,
}

impl Reader<'_> {
    fn plan(&self) -> Result<FloorPlan, RmfError> {
        let level = self.level;
        let places = level.vertices.iter().zip(&self.vertices).map(|(vertex, &at_m)| Place {
            name: vertex.3.clone(),
            at_m,
            kind: kind(|name| parameter(&vertex.4, name).is_some_and(Value::is_true)),
        });
        let door = |(number, edge): (usize, &Edge)| -> Result<Doorway, RmfError> {
            let name = match parameter(&edge.2, "name") {
                Some(Value::Text(name)) => name.clone(),
                _ => String::new(),
            };
            Ok(Doorway { name, ends_m: self.ends("door", number, edge)? })
        };
        let wall = |(number, edge)| self.ends("wall", number, edge);
        let lane = |(number, edge): (usize, &Edge)| -> Result<Lane, RmfError> {
            self.ends("lane", number, edge)?;
            let both_ways = parameter(&edge.2, "bidirectional").is_some_and(Value::is_true);
            Ok(Lane { ends: [edge.0, edge.1], via_m: Vec::new(), both_ways })
        };
        Ok(FloorPlan {
            name: self.name.to_owned(),
            places: places.collect(),
            doors: level.doors.iter().enumerate().map(door).collect::<Result<_, _>>()?,
            lanes: level.lanes.iter().enumerate().map(lane).collect::<Result<_, _>>()?,
            lifts: Vec::new(),
            walls: level.walls.iter().enumerate().map(wall).collect::<Result<_, _>>()?,
            floors: self.polygons("floor", &level.floors)?,
            holes: self.polygons("hole", &level.holes)?,
        })
    }

    fn vertex(&self, what: &'static str, number: usize, vertex: usize) -> Result<Point, RmfError> {
        let (level, vertices) = (self.name.to_owned(), self.vertices.len());
        let unknown = RmfError::Vertex { level, what, number, vertex, vertices };
        self.vertices.get(vertex).copied().ok_or(unknown)
    }

    fn ends(&self, what: &'static str, number: usize, edge: &Edge) -> Result<[Point; 2], RmfError> {
        Ok([self.vertex(what, number, edge.0)?, self.vertex(what, number, edge.1)?])
    }

    fn polygons(&self, what: &'static str, all: &[Polygon]) -> Result<Vec<Vec<Point>>, RmfError> {
        let corners = |(number, polygon): (usize, &Polygon)| {
            polygon.vertices.iter().map(|&vertex| self.vertex(what, number, vertex)).collect()
        };
        all.iter().enumerate().map(corners).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::floor_plan::PlaceKind;

    const TWO_LEVELS: &str = "\
levels:
  L1:
    fiducials: [[0, 0, a], [100, 0, b]]
    measurements:
      - [0, 1, {distance: [3, 10]}]
    vertices:
      - [0, 0, 0, \"\"]
      - [100, 0, 0, home, {is_charger: [4, true], is_parking_spot: [4, true]}]
      - [100, 50, 0]
      - [0, 50]
    walls:
      - [0, 1, {alpha: [3, 1]}]
    doors:
      - [1, 2, {name: [1, front]}]
    lanes:
      - [0, 2, {bidirectional: [4, true], orientation: [1, forward]}]
      - [2, 3]
    floors:
      - {parameters: {}, vertices: [0, 1, 2, 3]}
  L2:
    fiducials: [[10, 20, a], [10, 220, b]]
    vertices:
      - [10, 220, 0, over_home]
";

    #[test]
    fn a_building_is_in_metres_of_its_reference_level() {
        let [ground, upper] = <[_; 2]>::try_from(read(TWO_LEVELS).unwrap()).unwrap();
        assert_eq!((ground.places[1].at_m, ground.places[1].kind), ([10.0, 0.0], PlaceKind::Pile));
        assert_eq!(ground.places[2].at_m, [10.0, -5.0]);
        assert_eq!(ground.doors[0], Doorway { name: "front".into(), ends_m: [[10.0, 0.0], [10.0, -5.0]] });
        assert_eq!(ground.lanes.iter().map(|lane| lane.both_ways).collect::<Vec<_>>(), [true, false]);
        assert_eq!((ground.walls.len(), ground.floors[0].len()), (1, 4));
        let [x, y] = upper.places[0].at_m;
        assert!((x - 10.0).abs() < 1e-9 && y.abs() < 1e-9, "laid over the ground floor: ({x}, {y})");
    }

    #[test]
    fn of_fiducials_with_one_name_the_first_counts_and_none_without_a_name() {
        let more = TWO_LEVELS.replacen("[100, 0, b]]", "[100, 0, b], [7, 7, b], [3, 3, \"\"]]", 1).replacen(
            "[10, 220, b]]",
            "[10, 220, b], [9, 9, \"\"]]",
            1,
        );
        assert_eq!(read(&more), read(TWO_LEVELS));
    }

    #[test]
    fn what_is_wrong_with_a_building_is_named() {
        let error = |from: &str, to: &str| read(&TWO_LEVELS.replacen(from, to, 1)).unwrap_err().to_string();
        assert_eq!(
            error("[0, 1, {alpha", "[0, 9, {alpha"),
            "level L1: wall 0 names vertex 9: expected one of the 4 vertices, from 0"
        );
        assert_eq!(
            error("distance: [3, 10]", "distance: [3, 0]"),
            "level L1: measurement 0 is not finite, or far too large: expected metres or pixels"
        );
        assert!(
            error("[0, 50]", "[left, 50]").starts_with("line 10: "),
            "{}",
            error("[0, 50]", "[left, 50]")
        );
        assert_eq!(
            read("levels: {}\n").unwrap_err().to_string(),
            "there is no level: expected one under `levels`"
        );
        assert!(read(&format!("coordinate_system: web_mercator\n{TWO_LEVELS}")).is_err());
    }

    /// On the ground floor a cabin 2 m wide and 3 m deep, turned by a right angle, with its door to the west there
    /// and to the east above; past a storey between them.
    const LIFT: &str = "\
lifts:
  up:
    depth: 3
    width: 2
    x: 50
    y: 20
    yaw: 1.5707963267948966
    lowest_floor: L1
    highest_floor: \"\"
    reference_floor_name: L1
    level_doors: {L1: [front], L2: [back]}
    doors:
      front: {x: 0, y: 1.6, width: 1, motion_axis_orientation: 0, door_type: 2}
      back: {x: 0, y: -1.6, width: 1, motion_axis_orientation: 0, door_type: 2}
";

    fn with_lift() -> String {
        let between = "  L3:\n    elevation: 3\n    fiducials: [[0, 0, a], [100, 0, b]]\n";
        let vertex = "      - [50, 20, 0, \"\", {lift_cabin: [1, up]}]\n    walls:";
        format!("{}{between}{LIFT}", TWO_LEVELS.replacen("    walls:", vertex, 1))
    }

    #[test]
    fn a_lift_joins_the_storeys_where_it_stops() {
        let [ground, upper, between] = <[_; 3]>::try_from(read(&with_lift()).unwrap()).unwrap();
        let [below, above] = [&ground.lifts[0], &upper.lifts[0]];
        assert_eq!((below.at_m, below.size_m, below.places.as_slice()), ([5.0, -2.0], [2.0, 3.0], &[4][..]));
        assert_eq!(below.storeys, ["L1", "L2"]);
        let near = |found: [Point; 2], expected: [Point; 2]| {
            let pairs = found.as_flattened().iter().zip(expected.as_flattened());
            assert!(pairs.clone().all(|(found, expected)| (found - expected).abs() < 1e-9), "{found:?}");
        };
        near(below.doors[0].ends_m, [[3.4, -2.5], [3.4, -1.5]]);
        near(above.doors[0].ends_m, [[6.6, -2.5], [6.6, -1.5]]);
        assert!(above.places.is_empty());
        assert_eq!((between.lifts.len(), between.holes.len()), (0, 1));
    }

    #[test]
    fn a_cabin_is_entered_through_its_door_only() {
        let plans = read(&with_lift()).unwrap();
        let layout =
            plans[0].draw(crate::floor_plan::Scale { resolution_m: 0.1, wall_m: 0.2, lane_m: 1.0 }).unwrap();
        let is_free = |x, y| layout.grid.is_free(layout.frame.cell_at([x, y]));
        assert!(is_free(5.0, -2.0) && is_free(3.5, -2.0) && is_free(3.3, -2.0), "cabin and door");
        assert!(!is_free(6.5, -2.0) && !is_free(5.0, -1.0) && !is_free(5.0, -3.0), "walls");
    }

    #[test]
    fn what_is_wrong_with_a_lift_is_named() {
        let error = |from: &str, to: &str| read(&with_lift().replacen(from, to, 1)).unwrap_err().to_string();
        assert_eq!(
            error("{L1: [front]", "{L9: [front]"),
            "lift up: level_doors names level L9: expected one of the building"
        );
        assert_eq!(
            error("{L1: [front]", "{L1: [side]"),
            "lift up: level L1 names door side: expected one of the building"
        );
        assert_eq!(
            error("lift_cabin: [1, up]", "lift_cabin: [1, down]"),
            "level L1: vertex 4 names lift down: expected one of the building"
        );
        assert_eq!(
            error("y: -1.6, width: 1,", "y: -1.6, width: 0,"),
            "lift up: door back's width is 0: expected metres above 0, or pixels or radians, of a usual size"
        );
        assert!(error("    depth: 3\n", "").contains("missing field `depth`"));
    }

    #[test]
    fn metres_stand_as_they_are() {
        let metric = read(&format!("coordinate_system: cartesian_meters\n{TWO_LEVELS}")).unwrap();
        assert_eq!(metric[0].places[2].at_m, [100.0, 50.0]);
    }
}
