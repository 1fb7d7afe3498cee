//! Hub labels: for every node the few nodes that its shortest paths go up to.
//!
//! A label holds hubs and how far they are, such that the labels of any two nodes have a hub of a
//! shortest path between them in common (Abraham, Delling, Goldberg and Werneck, "A Hub-Based
//! Labeling Algorithm for Shortest Paths in Road Networks", SEA 2011). Labels end at the core of the
//! hierarchy: a path that goes through the core has the nodes where it enters and leaves it in them.

use super::hierarchy::{Hierarchy, NONE};
use crate::moves::Cost;

/// One hub of a node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hub {
    pub(super) node: u32,
    /// The place of the edge that the way to the hub starts with, [`NONE`] at the hub itself.
    edge: u32,
    pub(super) cost: Cost,
}

/// The labels of all nodes of a hierarchy.
#[derive(Clone, Debug)]
pub(super) struct Labels {
    /// Where the hubs of each node start in `hubs`.
    first: Vec<u32>,
    /// By node, and there by number.
    hubs: Vec<Hub>,
}

impl Labels {
    pub(super) fn new(hierarchy: &Hierarchy) -> Self {
        let mut labels = Self { first: vec![0], hubs: Vec::new() };
        // By node, while the label that it may be in is made.
        let mut known = vec![(Cost::MAX, NONE); hierarchy.nodes() as usize];
        let mut reached = Vec::new();
        for node in 0..hierarchy.nodes() {
            known[node as usize] = (0, NONE);
            reached.push(node);
            let upward = if node < hierarchy.core { 0..0 } else { hierarchy.edges(node) };
            for place in upward {
                let edge = hierarchy.edge(place);
                for hub in labels.of(edge.to) {
                    let (cost, by) = &mut known[hub.node as usize];
                    if *cost == Cost::MAX {
                        reached.push(hub.node);
                    }
                    if edge.cost + hub.cost < *cost {
                        (*cost, *by) = (edge.cost + hub.cost, place);
                    }
                }
            }
            reached.sort_unstable();
            for &hub in &reached {
                let (cost, edge) = known[hub as usize];
                // A way that is as short by a higher hub makes this one needless.
                let higher = |other: &Hub| {
                    let to_other = known[other.node as usize].0;
                    other.node != hub && to_other != Cost::MAX && to_other + other.cost <= cost
                };
                if hub == node || !labels.of(hub).iter().any(higher) {
                    labels.hubs.push(Hub { node: hub, edge, cost });
                }
            }
            labels.first.push(labels.hubs.len() as u32);
            reached.drain(..).for_each(|hub| known[hub as usize] = (Cost::MAX, NONE));
        }
        labels
    }

    /// The hubs of `node`, by number.
    pub(super) fn of(&self, node: u32) -> &[Hub] {
        &self.hubs[self.first[node as usize] as usize..self.first[node as usize + 1] as usize]
    }

    /// The place of the edge by which the way from `node` to one of its hubs starts; `None` at the hub.
    pub(super) fn next(&self, node: u32, hub: u32) -> Option<u32> {
        let hubs = self.of(node);
        let place = hubs.binary_search_by_key(&hub, |hub| hub.node).ok()?;
        Some(hubs[place].edge).filter(|&edge| edge != NONE)
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.first.as_slice()) + size_of_val(self.hubs.as_slice())
    }
}
