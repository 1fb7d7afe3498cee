//! The Layout Interchange Format (LIF) of VDMA, in which layouts of tracks go to a master control that
//! speaks VDA 5050: JSON, in metres, y up. Versions 1 (`layouts`) and 2 (`origins` of layouts).
//!
//! A node is a pile where a vehicle can do `startCharging`, or where a station of a type that names
//! charging has its interaction. Edges lead one way, straight or along the trajectories (NURBS) that they
//! have for types of vehicles: a lane for each way that there is. An edge that ends in another layout is no
//! lane of this one. A layout has no walls: its grid is free along the lanes.

use std::collections::{BTreeMap, BTreeSet};

use serde::Deserialize;

use super::nurbs::{ControlPoint, Curve, CurveError};
use crate::floor_plan::{FloorPlan, Lane, Place, PlaceKind, Point};

/// A trajectory's end so near to a node is at it, in metres.
const SAME_PLACE_M: f64 = 0.001;

/// What is wrong with a LIF file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LifError {
    /// It is no JSON, or lacks something.
    #[error("line {line}: {problem}")]
    Json {
        /// The line, from 1.
        line: usize,
        /// What is wrong.
        problem: String,
    },
    /// There is no layout.
    #[error("there is no layout: expected one under `layouts` (version 1) or `origins` (version 2)")]
    NoLayout,
    /// Two nodes of a layout have one id.
    #[error("layout {layout}: node {node} is there twice: expected an id of its own for each")]
    Twice {
        /// The layout.
        layout: String,
        /// The node.
        node: String,
    },
    /// A trajectory is no curve.
    #[error("layout {layout}: edge {edge}: trajectory {number} (from 0): {problem}")]
    Trajectory {
        /// The layout.
        layout: String,
        /// The edge.
        edge: String,
        /// Of which of the edge's properties, from 0.
        number: usize,
        /// What is wrong with it.
        problem: CurveError,
    },
    /// An edge or a station names a node that there is not.
    #[error("layout {layout}: {what} {id} names node {node}: expected a node of the layout")]
    Node {
        /// The layout.
        layout: String,
        /// Edge or station.
        what: &'static str,
        /// Which.
        id: String,
        /// The node that there is not.
        node: String,
    },
    /// A node is nowhere.
    #[error("layout {layout}: node {node} is far too far away: expected metres")]
    Position {
        /// The layout.
        layout: String,
        /// The node.
        node: String,
    },
}

#[derive(Deserialize)]
struct Lif {
    #[serde(default)]
    layouts: Vec<Layout>,
    #[serde(default)]
    origins: Vec<Origin>,
}

#[derive(Deserialize)]
struct Origin {
    #[serde(default)]
    layouts: Vec<Layout>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Layout {
    layout_id: String,
    nodes: Vec<Node>,
    #[serde(default)]
    edges: Vec<Edge>,
    #[serde(default)]
    stations: Vec<Station>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Node {
    node_id: String,
    node_name: Option<String>,
    node_position: Position,
    #[serde(default, alias = "mobileRobotTypeNodeProperties")]
    vehicle_type_node_properties: Vec<NodeProperties>,
}

#[derive(Deserialize)]
struct Position {
    x: f64,
    y: f64,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct NodeProperties {
    #[serde(default, alias = "feasibleActions")]
    actions: Vec<Action>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Action {
    action_type: String,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Edge {
    #[serde(default)]
    edge_id: String,
    start_node_id: String,
    end_node_id: String,
    #[serde(default, alias = "mobileRobotTypeEdgeProperties")]
    vehicle_type_edge_properties: Vec<EdgeProperties>,
}

#[derive(Deserialize)]
struct EdgeProperties {
    trajectory: Option<Trajectory>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Trajectory {
    #[serde(default = "one")]
    degree: f64,
    knot_vector: Vec<f64>,
    control_points: Vec<TrajectoryPoint>,
}

#[derive(Deserialize)]
struct TrajectoryPoint {
    x: f64,
    y: f64,
    #[serde(default = "one")]
    weight: f64,
}

const fn one() -> f64 {
    1.0
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Station {
    station_id: String,
    station_name: Option<String>,
    station_type: Option<String>,
    #[serde(default)]
    interaction_node_ids: Vec<String>,
}

/// Reads a LIF file: a floor plan of lanes for each layout.
///
/// # Errors
/// [`LifError`] names what is wrong.
pub fn read(text: &str) -> Result<Vec<FloorPlan>, LifError> {
    let lif: Lif = serde_json::from_str(text.trim_start_matches('\u{feff}')).map_err(|error| {
        let problem = error.to_string();
        let problem = problem.split(" at line ").next().unwrap_or_default().to_owned();
        LifError::Json { line: error.line(), problem }
    })?;
    let layouts = lif.layouts.iter().chain(lif.origins.iter().flat_map(|origin| &origin.layouts));
    let nodes = layouts.clone().flat_map(|layout| &layout.nodes);
    let nodes: BTreeSet<_> = nodes.map(|node| node.node_id.as_str()).collect();
    let plans: Vec<_> = layouts.map(|layout| layout.plan(&nodes)).collect::<Result<_, _>>()?;
    if plans.is_empty() { Err(LifError::NoLayout) } else { Ok(plans) }
}

impl Node {
    fn charges(&self) -> bool {
        let mut actions = self.vehicle_type_node_properties.iter().flat_map(|properties| &properties.actions);
        actions.any(|action| action.action_type == "startCharging")
    }
}

impl Station {
    fn charges(&self) -> bool {
        self.station_type.as_ref().is_some_and(|kind| kind.to_ascii_lowercase().contains("charg"))
    }
}

impl Trajectory {
    /// The corners between the curve's ends, where they are those of the edge.
    fn corners(&self, ends: [Point; 2]) -> Result<Vec<Point>, CurveError> {
        let points = self.control_points.iter();
        let points = points.map(|&TrajectoryPoint { x, y, weight }| ControlPoint { at_m: [x, y], weight });
        let curve = Curve::new(self.degree, self.knot_vector.clone(), &points.collect::<Vec<_>>())?;
        let is_end = |corner: &Point| {
            ends.iter().any(|end| (corner[0] - end[0]).hypot(corner[1] - end[1]) <= SAME_PLACE_M)
        };
        let mut corners = curve.line();
        corners.pop_if(|last| is_end(last));
        let first = usize::from(corners.first().is_some_and(is_end));
        Ok(corners.split_off(first))
    }
}

impl Edge {
    /// The ways along the edge: for each of some types of vehicles, but each once.
    fn ways(&self, layout: &str, ends: [Point; 2]) -> Result<Vec<Vec<Point>>, LifError> {
        let mut ways = Vec::new();
        for (number, properties) in self.vehicle_type_edge_properties.iter().enumerate() {
            let way = properties.trajectory.as_ref().map(|trajectory| trajectory.corners(ends)).transpose();
            let way = way.map_err(|problem| {
                let (layout, edge) = (layout.to_owned(), self.edge_id.clone());
                LifError::Trajectory { layout, edge, number, problem }
            })?;
            let way = way.unwrap_or_default();
            if !ways.contains(&way) {
                ways.push(way);
            }
        }
        if ways.is_empty() {
            ways.push(Vec::new());
        }
        Ok(ways)
    }
}

impl Layout {
    /// The plan of the layout, where these `nodes` are in the file.
    fn plan(&self, nodes: &BTreeSet<&str>) -> Result<FloorPlan, LifError> {
        let mut index = BTreeMap::new();
        let mut places = Vec::new();
        for (number, node) in self.nodes.iter().enumerate() {
            let (layout, id) = (self.layout_id.clone(), node.node_id.clone());
            if index.insert(&node.node_id, number).is_some() {
                return Err(LifError::Twice { layout, node: id });
            }
            let Position { x, y } = node.node_position;
            if !(x.abs() < 1e9 && y.abs() < 1e9) {
                return Err(LifError::Position { layout, node: id });
            }
            let kind = if node.charges() { PlaceKind::Pile } else { PlaceKind::Other };
            let name = node.node_name.clone().filter(|name| !name.is_empty()).unwrap_or(id);
            places.push(Place { name, at_m: [x, y], kind });
        }
        let find = |what, id: &str, node: &String| {
            let (layout, id) = (self.layout_id.clone(), id.to_owned());
            index.get(node).copied().ok_or_else(|| LifError::Node { layout, what, id, node: node.clone() })
        };
        let mut lanes = Vec::new();
        for edge in &self.edges {
            let from = find("edge", &edge.edge_id, &edge.start_node_id)?;
            let to = match find("edge", &edge.edge_id, &edge.end_node_id) {
                Err(_) if nodes.contains(edge.end_node_id.as_str()) => continue,
                to => to?,
            };
            let ends_m = [from, to].map(|end| places.get(end).map_or([0.0; 2], |place: &Place| place.at_m));
            let ways = edge.ways(&self.layout_id, ends_m)?.into_iter();
            lanes.extend(ways.map(|via_m| Lane { ends: [from, to], via_m, both_ways: false }));
        }
        for station in &self.stations {
            for node in &station.interaction_node_ids {
                let place = places.get_mut(find("station", &station.station_id, node)?);
                if let Some(place) = place.filter(|_| station.charges()) {
                    place.kind = PlaceKind::Pile;
                    place.name = station.station_name.clone().unwrap_or_else(|| station.station_id.clone());
                }
            }
        }
        Ok(FloorPlan { name: self.layout_id.clone(), places, lanes, ..FloorPlan::default() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAYOUT: &str = r#"{"layoutId": "hall", "nodes": [
        {"nodeId": "a", "nodePosition": {"x": 0, "y": 1.5}, "PROPERTIES": [{"ACTIONS": [{"actionType": "startCharging"}]}]},
        {"nodeId": "b", "nodeName": "gate", "nodePosition": {"x": -2, "y": 1.5}},
        {"nodeId": "c", "nodePosition": {"x": -2, "y": 4}}],
        "edges": [{"edgeId": "e", "startNodeId": "a", "endNodeId": "b"}],
        "stations": [{"stationId": "s", "interactionNodeIds": ["c"], "stationType": "CHARGING"}]}"#;

    fn version_1() -> String {
        let layout = LAYOUT.replace("PROPERTIES", "vehicleTypeNodeProperties").replace("ACTIONS", "actions");
        format!(r#"{{"metaInformation": {{"lifVersion": "1.0.0"}}, "layouts": [{layout}]}}"#)
    }

    #[test]
    fn both_versions_say_the_same() {
        let layout = LAYOUT
            .replace("PROPERTIES", "mobileRobotTypeNodeProperties")
            .replace("ACTIONS", "feasibleActions");
        let second = format!(r#"{{"origins": [{{"originId": "o", "layouts": [{layout}]}}]}}"#);
        let [plan] = <[_; 1]>::try_from(read(&version_1()).unwrap()).unwrap();
        assert_eq!(read(&second).unwrap(), std::slice::from_ref(&plan));
        let places: Vec<_> = plan.places.iter().map(|place| (place.name.as_str(), place.kind)).collect();
        assert_eq!(places, [("a", PlaceKind::Pile), ("gate", PlaceKind::Other), ("s", PlaceKind::Pile)]);
        assert_eq!(plan.lanes, [Lane { ends: [0, 1], via_m: Vec::new(), both_ways: false }]);
    }

    /// The edge from (0, 1.5) to (-2, 1.5) with these properties.
    fn with_properties(properties: &str) -> String {
        let edge = r#""endNodeId": "b""#;
        version_1().replace(edge, &format!(r#"{edge}, "vehicleTypeEdgeProperties": [{properties}]"#))
    }

    /// A quarter of a circle twice, around (-1, 1.5): a half circle from a to b.
    const HALF_CIRCLE: &str = r#"{"vehicleTypeId": "t", "trajectory": {"degree": 2,
        "knotVector": [0, 0, 0, 0.5, 0.5, 1, 1, 1], "controlPoints": [{"x": 0, "y": 1.5},
        {"x": 0, "y": 2.5, "weight": 0.70710678118654752}, {"x": -1, "y": 2.5, "weight": 1.0},
        {"x": -2, "y": 2.5, "weight": 0.70710678118654752}, {"x": -2, "y": 1.5}]}}"#;

    #[test]
    fn a_lane_follows_its_trajectory() {
        let [plan] = <[_; 1]>::try_from(read(&with_properties(HALF_CIRCLE)).unwrap()).unwrap();
        let [lane] = plan.lanes.as_slice() else { panic!("{:?}", plan.lanes) };
        let length = lane.length_m(&plan.places);
        assert!((length - std::f64::consts::PI).abs() < 0.01, "{length} m");
        let scale = crate::floor_plan::Scale { resolution_m: 0.1, wall_m: 0.1, lane_m: 0.2 };
        let layout = plan.draw(scale).unwrap();
        let at = |x, y| layout.grid.is_free(layout.frame.cell_at([x, y]));
        assert!(at(-1.0, 2.5) && !at(-1.0, 1.5), "free along the curve, and only there");
    }

    #[test]
    fn there_is_a_lane_for_each_way_along_an_edge() {
        let straight = r#"{"vehicleTypeId": "u"}"#;
        let [plan] = <[_; 1]>::try_from(
            read(&with_properties(&format!("{straight}, {HALF_CIRCLE}, {straight}"))).unwrap(),
        )
        .unwrap();
        assert_eq!(plan.lanes.iter().map(|lane| lane.via_m.is_empty()).collect::<Vec<_>>(), [true, false]);
    }

    #[test]
    fn an_edge_into_another_layout_is_no_lane_of_this_one() {
        let other = r#"{"layoutId": "yard", "nodes": [{"nodeId": "x", "nodePosition": {"x": 0, "y": 0}}]}"#;
        let both = version_1()
            .replace(r#""endNodeId": "b""#, r#""endNodeId": "x""#)
            .replace("\"layouts\": [", &format!("\"layouts\": [{other}, "));
        let plans = read(&both).unwrap();
        assert_eq!(plans.iter().map(|plan| plan.lanes.len()).collect::<Vec<_>>(), [0, 0]);
    }

    #[test]
    fn a_trajectory_that_is_no_curve_is_named() {
        let error = |from: &str, to: &str| {
            read(&with_properties(&HALF_CIRCLE.replacen(from, to, 1))).unwrap_err().to_string()
        };
        assert_eq!(
            error("0, 0, 0, 0.5", "0, 0, 0.5"),
            "layout hall: edge e: trajectory 0 (from 0): 7 knots: expected 8, control points plus degree plus 1"
        );
        assert_eq!(
            error(r#""degree": 2"#, r#""degree": 0"#),
            "layout hall: edge e: trajectory 0 (from 0): degree 0: expected a whole number from 1 to 4"
        );
        assert!(error(r#""weight": 1.0"#, r#""weight": -1"#).contains("control point 2 (from 0)"));
        assert!(error(r#""knotVector""#, r#""knots""#).contains("missing field `knotVector`"));
    }

    #[test]
    fn what_is_wrong_with_a_layout_is_named() {
        let error = |from: &str, to: &str| read(&version_1().replacen(from, to, 1)).unwrap_err().to_string();
        assert_eq!(
            error(r#""endNodeId": "b""#, r#""endNodeId": "x""#),
            "layout hall: edge e names node x: expected a node of the layout"
        );
        assert_eq!(
            error(r#""nodeId": "b""#, r#""nodeId": "a""#),
            "layout hall: node a is there twice: expected an id of its own for each"
        );
        assert_eq!(error(r#""y": 4"#, r#""y": "4""#), "line 4: invalid type: string \"4\", expected f64");
        assert_eq!(read("{}").unwrap_err(), LifError::NoLayout);
    }
}
