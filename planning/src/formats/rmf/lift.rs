//! Lifts, as buildings and as navigation graphs have them.
//!
//! A building says where the cabin is on its reference floor, and for each storey where it stops which of its doors
//! open; doors are placed from the cabin's middle. Past storeys without a door goes a shaft: a hole in their floors,
//! if they are between the lowest and the highest floor. A graph says where the cabin is, and by a property of
//! vertices where it stops.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::RmfError;
use crate::floor_plan::{Doorway, Lift, Point};

/// The longest side of a cabin, or width of a door, in metres.
const MAX_SIDE_M: f64 = 1000.0;

/// A lift of a building.
#[derive(Deserialize)]
pub(super) struct OfBuilding {
    x: f64,
    y: f64,
    #[serde(default)]
    yaw: f64,
    width: f64,
    depth: f64,
    reference_floor_name: Option<String>,
    lowest_floor: Option<String>,
    highest_floor: Option<String>,
    /// By storey where it stops, the doors that open.
    #[serde(default)]
    level_doors: BTreeMap<String, Vec<String>>,
    #[serde(default)]
    doors: BTreeMap<String, Door>,
}

/// A door, from the middle of the cabin.
#[derive(Deserialize)]
struct Door {
    x: f64,
    y: f64,
    width: f64,
    /// How its leaf is turned against the cabin's x axis, in radians.
    #[serde(default)]
    motion_axis_orientation: f64,
}

/// A lift of a navigation graph.
#[derive(Deserialize)]
pub(super) struct OfGraph {
    /// x, y and yaw.
    position: [f64; 3],
    /// Width and depth.
    dims: [f64; 2],
}

/// What a building says of its storeys.
pub(super) struct Storeys<'a> {
    /// The one that a lift without a reference floor is drawn on.
    pub(super) reference: &'a str,
    /// By name, how high each is, in metres.
    pub(super) elevations: BTreeMap<&'a str, f64>,
}

/// A lift's part of a storey.
pub(super) enum Part {
    /// It stops there.
    Stop(Lift),
    /// It only passes.
    Shaft([Point; 4]),
}

impl OfBuilding {
    /// What a lift is to each storey that it stops at or passes; `world` says where a point of a storey's drawing is.
    pub(super) fn parts<'a>(
        &self,
        name: &str,
        storeys: &Storeys<'a>,
        world: impl Fn(&str, Point) -> Point,
    ) -> Result<BTreeMap<&'a str, Part>, RmfError> {
        let level = |what: &str, named: &str| {
            let level =
                storeys.elevations.get_key_value(named).map(|(level, elevation)| (*level, *elevation));
            level.ok_or_else(|| unknown(format!("lift {name}: {what}"), "level", named))
        };
        let floor = |what: &str, named: &Option<String>| {
            named.as_deref().filter(|named| !named.is_empty()).map(|named| level(what, named)).transpose()
        };
        let reference = floor("reference_floor_name", &self.reference_floor_name)?;
        let reference = reference.map_or(storeys.reference, |(level, _)| level);
        let lowest =
            floor("lowest_floor", &self.lowest_floor)?.map_or(f64::NEG_INFINITY, |(_, lowest)| lowest);
        let highest =
            floor("highest_floor", &self.highest_floor)?.map_or(f64::INFINITY, |(_, highest)| highest);
        self.check(name)?;
        let stops = || self.level_doors.iter().filter(|(_, doors)| !doors.is_empty());
        let cabin = Lift {
            name: name.to_owned(),
            at_m: world(reference, [self.x, self.y]),
            yaw_rad: self.yaw,
            size_m: [self.width, self.depth],
            doors: Vec::new(),
            places: Vec::new(),
            storeys: stops().map(|(storey, _)| storey.clone()).collect(),
        };
        let mut parts = BTreeMap::new();
        // One that stops nowhere is none.
        let is_passed = |elevation: f64| stops().next().is_some() && (lowest..=highest).contains(&elevation);
        for (&level, _) in storeys.elevations.iter().filter(|(_, elevation)| is_passed(**elevation)) {
            parts.insert(level, Part::Shaft(cabin.corners_m()));
        }
        for (named, doors) in stops() {
            let (level, _) = level("level_doors", named)?;
            let door = |door: &String| {
                let (door, entry) = self
                    .doors
                    .get_key_value(door)
                    .ok_or_else(|| unknown(format!("lift {name}: level {named}"), "door", door))?;
                Ok(Doorway { name: door.clone(), ends_m: entry.ends().map(|end| cabin.world(end)) })
            };
            let doors: Vec<_> = doors.iter().map(door).collect::<Result<_, RmfError>>()?;
            parts.insert(level, Part::Stop(Lift { doors, ..cabin.clone() }));
        }
        Ok(parts)
    }

    fn check(&self, name: &str) -> Result<(), RmfError> {
        place(name, &[("x", self.x), ("y", self.y), ("yaw", self.yaw)])?;
        size(name, &[("width", self.width), ("depth", self.depth)])?;
        for (door, Door { x, y, width, motion_axis_orientation }) in &self.doors {
            let of_door = |what: &str| format!("door {door}'s {what}");
            let orientation = of_door("motion_axis_orientation");
            place(
                name,
                &[(&of_door("x"), *x), (&of_door("y"), *y), (&orientation, *motion_axis_orientation)],
            )?;
            size(name, &[(&of_door("width"), *width)])?;
        }
        Ok(())
    }
}

impl Door {
    fn ends(&self) -> [Point; 2] {
        let (sin, cos) = (libm::sin(self.motion_axis_orientation), libm::cos(self.motion_axis_orientation));
        [-0.5, 0.5].map(|half| [self.x + half * self.width * cos, self.y + half * self.width * sin])
    }
}

/// The lifts of a graph, by level: `cabins` says for each vertex of each level in which lift's cabin it is.
pub(super) fn of_graph(
    lifts: &BTreeMap<String, OfGraph>,
    cabins: &BTreeMap<&str, Vec<Option<&str>>>,
) -> Result<BTreeMap<String, Vec<Lift>>, RmfError> {
    // Graphs that know no lifts may name them all the same.
    for (level, vertices) in cabins.iter().filter(|_| !lifts.is_empty()) {
        for (number, lift) in vertices.iter().enumerate() {
            if let Some(lift) = lift.filter(|lift| !lifts.contains_key(*lift)) {
                return Err(unknown(format!("level {level}: vertex {number}"), "lift", lift));
            }
        }
    }
    let mut by_level: BTreeMap<String, Vec<Lift>> = BTreeMap::new();
    for (name, &OfGraph { position: [x, y, yaw_rad], dims }) in lifts {
        place(name, &[("x", x), ("y", y), ("yaw", yaw_rad)])?;
        size(name, &[("width", dims[0]), ("depth", dims[1])])?;
        let is_inside = |cabin: &Option<&str>| *cabin == Some(name);
        let stops = || cabins.iter().filter(|(_, vertices)| vertices.iter().any(is_inside));
        let storeys: Vec<_> = stops().map(|(level, _)| (*level).to_owned()).collect();
        for (level, vertices) in stops() {
            let places = vertices.iter().enumerate().filter(|(_, cabin)| is_inside(cabin));
            by_level.entry((*level).to_owned()).or_default().push(Lift {
                name: name.clone(),
                at_m: [x, y],
                yaw_rad,
                size_m: dims,
                doors: Vec::new(),
                places: places.map(|(number, _)| number).collect(),
                storeys: storeys.clone(),
            });
        }
    }
    Ok(by_level)
}

pub(super) fn unknown(what: String, kind: &'static str, name: &str) -> RmfError {
    RmfError::Unknown { what, kind, name: name.to_owned() }
}

fn place(lift: &str, measures: &[(&str, f64)]) -> Result<(), RmfError> {
    check(lift, measures, |value| value.abs() < 1e9)
}

fn size(lift: &str, measures: &[(&str, f64)]) -> Result<(), RmfError> {
    check(lift, measures, |value| value > 0.0 && value <= MAX_SIDE_M)
}

fn check(lift: &str, measures: &[(&str, f64)], is_sound: impl Fn(f64) -> bool) -> Result<(), RmfError> {
    let unsound = measures.iter().find(|(_, value)| !is_sound(*value));
    unsound.map_or(Ok(()), |(what, value)| {
        let (lift, what, value) = (lift.to_owned(), (*what).to_owned(), value.to_string());
        Err(RmfError::LiftNumber { lift, what, value })
    })
}
