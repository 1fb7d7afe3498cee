//! The Layout Interchange Format (LIF) of VDMA, in which layouts of tracks go to a master control that
//! speaks VDA 5050: JSON, in metres, y up. Versions 1 (`layouts`) and 2 (`origins` of layouts).
//!
//! A node is a pile where a vehicle can do `startCharging`, or where a station of a type that names
//! charging has its interaction. Edges lead one way. A layout has no walls: its grid is free along
//! the edges; trajectories are taken for straight.

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::floor_plan::{FloorPlan, Lane, Place, PlaceKind};

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
    let layouts = lif.layouts.into_iter().chain(lif.origins.into_iter().flat_map(|origin| origin.layouts));
    let plans: Vec<_> = layouts.map(Layout::plan).collect::<Result<_, _>>()?;
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

impl Layout {
    fn plan(self) -> Result<FloorPlan, LifError> {
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
        for Edge { edge_id, start_node_id, end_node_id } in &self.edges {
            let ends = [find("edge", edge_id, start_node_id)?, find("edge", edge_id, end_node_id)?];
            lanes.push(Lane { ends, both_ways: false });
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
        assert_eq!(plan.lanes, [Lane { ends: [0, 1], both_ways: false }]);
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
