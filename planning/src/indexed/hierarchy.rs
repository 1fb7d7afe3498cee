//! Contraction of a graph: what is left out is bridged by shortcuts.
//!
//! A contraction hierarchy (Geisberger, Sanders, Schultes and Delling, "Contraction Hierarchies",
//! WEA 2008): nodes are taken out one by one, the least entangled first, and two neighbours of one
//! taken out are joined by a shortcut unless another way between them is as short. Where it gets
//! dear it stops, and the nodes that remain are the core. What is dear is counted in edges looked
//! at, not timed, so that a map gives the same hierarchy on every machine.

use std::{
    cmp::Reverse,
    collections::{BinaryHeap, binary_heap::PeekMut},
};

use super::turns::Directions;
use crate::moves::Cost;

/// No node or edge.
pub(super) const NONE: u32 = u32::MAX;

/// How many nodes a search for a way around a node settles at most.
const WITNESSES: usize = 8;

/// An edge to a neighbour, both ways alike.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    pub(super) to: u32,
    /// The node that a shortcut bridges, [`NONE`] if the edge is none.
    pub(super) middle: u32,
    pub(super) cost: Cost,
    /// The first moves of the way to the neighbour.
    pub(super) leaves: Directions,
    /// The last ones.
    pub(super) arrives: Directions,
}

/// What a search reads of an edge: 16 bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Way {
    pub(super) cost: Cost,
    pub(super) to: u32,
    /// The first moves of the way.
    pub(super) leaves: Directions,
    /// What a shortest path may go on by after it.
    pub(super) onward: Directions,
}

impl Edge {
    /// The edge back to `from`.
    const fn reversed(self, from: u32) -> Self {
        Self { to: from, leaves: self.arrives.reversed(), arrives: self.leaves.reversed(), ..self }
    }

    /// What a shortest path may go on by that comes by this edge backwards.
    const fn onward_from(&self) -> Directions {
        self.leaves.reversed().onward()
    }
}

/// A contracted graph. Nodes are numbered anew: first the core, then from the last contracted to the
/// first.
#[derive(Clone, Debug)]
pub(super) struct Hierarchy {
    /// How many nodes the core has.
    pub(super) core: u32,
    /// Where the edges of each node start in `ways`.
    first: Vec<u32>,
    ways: Vec<Way>,
    /// Of each of these the node that a shortcut bridges, [`NONE`] if it is none.
    middles: Vec<u32>,
}

impl Hierarchy {
    /// Contracts the graph with these neighbours, each known to both, looking at about `budget` edges.
    /// Also tells which number each node had before.
    pub(super) fn contract(graph: Vec<Vec<Edge>>, budget: u64) -> (Self, Vec<u32>) {
        let nodes = graph.len();
        let mut contraction = Contraction::new(graph);
        contraction.run(budget);
        let Contraction { edges: graph, level, contracted, .. } = contraction;
        let mut order: Vec<u32> = (0..nodes as u32).filter(|&node| level[node as usize] != DONE).collect();
        let core = order.len() as u32;
        order.extend(contracted.iter().rev());
        let mut number = vec![NONE; nodes];
        (0..).zip(&order).for_each(|(new, &old)| number[old as usize] = new);
        let renumber = |old: u32| number.get(old as usize).copied().unwrap_or(NONE);
        let (mut first, mut ways, mut middles) = (vec![0], Vec::new(), Vec::new());
        for &old in &order {
            let mut edges = graph[old as usize].clone();
            // A search goes on by those that leave by some directions: they come after each other.
            edges.sort_unstable_by_key(|edge| (edge.leaves, edge.cost, edge.to));
            for &Edge { to, middle, cost, leaves, arrives } in &edges {
                ways.push(Way { cost, to: renumber(to), leaves, onward: arrives.onward() });
                middles.push(renumber(middle));
            }
            first.push(ways.len() as u32);
        }
        (Self { core, first, ways, middles }, order)
    }

    /// By node, a number that those share which are joined by any number of edges.
    pub(super) fn components(&self) -> Vec<u32> {
        let mut components = vec![NONE; self.nodes() as usize];
        let mut reached = Vec::new();
        for node in 0..self.nodes() {
            if components[node as usize] != NONE {
                continue;
            }
            let above = self.edges_of(node).first().map_or(NONE, |edge| components[edge.to as usize]);
            components[node as usize] = if above == NONE { node } else { above };
            if node < self.core {
                reached.push(node);
            }
            while let Some(from) = reached.pop() {
                for edge in self.edges_of(from) {
                    if components[edge.to as usize] == NONE {
                        components[edge.to as usize] = node;
                        reached.push(edge.to);
                    }
                }
            }
        }
        components
    }

    /// How many nodes there are.
    pub(super) fn nodes(&self) -> u32 {
        self.first.len() as u32 - 1
    }

    /// The places for [`Self::edge`] of a node's edges: of a core node's to all its neighbours in the
    /// core, of any other's to neighbours that were contracted later.
    pub(super) fn edges(&self, node: u32) -> std::ops::Range<u32> {
        self.first[node as usize]..self.first[node as usize + 1]
    }

    /// The edges at these places.
    pub(super) fn edges_of(&self, node: u32) -> &[Way] {
        let places = self.edges(node);
        &self.ways[places.start as usize..places.end as usize]
    }

    pub(super) fn edge(&self, place: u32) -> &Way {
        &self.ways[place as usize]
    }

    /// The node that the shortcut at a place bridges, [`NONE`] if the edge is none.
    pub(super) fn middle(&self, place: u32) -> u32 {
        self.middles[place as usize]
    }

    /// What a node that was contracted, or a core node, is joined to `to` by: the middle of that edge.
    pub(super) fn between(&self, node: u32, to: u32) -> Option<u32> {
        self.edges(node).find(|&place| self.edge(place).to == to).map(|place| self.middle(place))
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.first.as_slice())
            + size_of_val(self.ways.as_slice())
            + size_of_val(self.middles.as_slice())
    }
}

/// The level of a contracted node.
const DONE: u32 = u32::MAX;

struct Contraction {
    /// By node; of contracted ones what they were joined to when it happened.
    edges: Vec<Vec<Edge>>,
    /// The longest chain of contracted neighbours below each node.
    level: Vec<u32>,
    contracted: Vec<u32>,
    /// Edges looked at.
    work: u64,
    search: Witnesses,
    /// From where, and the edge.
    shortcuts: Vec<(u32, Edge)>,
}

/// The memory of searches for ways around a node.
struct Witnesses {
    cost: Vec<Cost>,
    reached: Vec<u32>,
    open: BinaryHeap<Reverse<(Cost, u32)>>,
}

impl Contraction {
    fn new(edges: Vec<Vec<Edge>>) -> Self {
        let nodes = edges.len();
        let search = Witnesses { cost: vec![Cost::MAX; nodes], reached: Vec::new(), open: BinaryHeap::new() };
        let (contracted, shortcuts) = (Vec::with_capacity(nodes), Vec::new());
        Self { edges, level: vec![0; nodes], contracted, work: 0, search, shortcuts }
    }

    fn run(&mut self, budget: u64) {
        let mut queue: BinaryHeap<_> = (0..)
            .zip(self.priorities(budget / 8))
            .map(|(node, priority)| Reverse((priority, node)))
            .collect();
        while let Some(mut top) = queue.peek_mut() {
            let Reverse((known, node)) = *top;
            let priority = self.priority(node);
            if self.work > budget {
                return;
            }
            if priority > known {
                // Others may come first now.
                *top = Reverse((priority, node));
                continue;
            }
            PeekMut::pop(top);
            self.contract(node);
        }
    }

    /// What to begin with: the priority of every node, if that takes no more than `budget`; else what it is at
    /// most, so that only those are looked at whose turn comes.
    fn priorities(&mut self, budget: u64) -> Vec<i64> {
        let nodes = 0..self.edges.len() as u32;
        let exact = nodes.clone().map(|node| (self.work <= budget).then(|| self.priority(node)));
        let exact: Option<Vec<_>> = exact.collect();
        exact.unwrap_or_else(|| nodes.map(|node| self.at_most(node)).collect())
    }

    /// [`Self::priority`] if no shortcut were needless, which is quick to say.
    fn at_most(&self, node: u32) -> i64 {
        let neighbours = &self.edges[node as usize];
        let pairs = |(number, from): (usize, &Edge)| {
            let onward = from.onward_from();
            neighbours[number..].iter().filter(|to| to.leaves.within(onward)).count() as i64
        };
        2 * (1..).zip(neighbours).map(pairs).sum::<i64>() - neighbours.len() as i64
    }

    /// How soon a node is contracted, and the shortcuts that it takes.
    fn priority(&mut self, node: u32) -> i64 {
        self.find_shortcuts(node);
        2 * self.shortcuts.len() as i64 - self.edges[node as usize].len() as i64
            + i64::from(self.level[node as usize])
    }

    fn find_shortcuts(&mut self, node: u32) {
        self.shortcuts.clear();
        let neighbours = &self.edges[node as usize];
        for (number, from) in (1..).zip(neighbours) {
            let onward = from.onward_from();
            let others = || neighbours[number..].iter().filter(|to| to.leaves.within(onward));
            let Some(farthest) = others().map(|to| from.cost + to.cost).max() else { continue };
            self.work += self.search.run(&self.edges, from.to, node, farthest);
            for to in others() {
                let cost = from.cost + to.cost;
                if self.search.cost[to.to as usize] > cost {
                    let leaves = from.arrives.reversed();
                    self.shortcuts.push((from.to, Edge { middle: node, cost, leaves, ..*to }));
                }
            }
        }
    }

    /// Takes out `node`, for which the shortcuts have just been found.
    fn contract(&mut self, node: u32) {
        let level = self.level[node as usize] + 1;
        self.level[node as usize] = DONE;
        self.contracted.push(node);
        let neighbours = std::mem::take(&mut self.edges[node as usize]);
        for neighbour in &neighbours {
            let to = neighbour.to as usize;
            self.edges[to].retain(|edge| edge.to != node);
            self.level[to] = self.level[to].max(level);
        }
        self.edges[node as usize] = neighbours;
        for &(from, shortcut) in &self.shortcuts {
            for (from, edge) in [(from, shortcut), (shortcut.to, shortcut.reversed(from))] {
                let edges = &mut self.edges[from as usize];
                match edges.iter_mut().find(|known| known.to == edge.to) {
                    Some(longer) => *longer = edge,
                    None => edges.push(edge),
                }
            }
        }
    }
}

impl Witnesses {
    /// Searches from `from` without entering `without`, as far as `farthest` and [`WITNESSES`] nodes;
    /// tells how many edges it looked at.
    fn run(&mut self, edges: &[Vec<Edge>], from: u32, without: u32, farthest: Cost) -> u64 {
        self.reached.drain(..).for_each(|node| self.cost[node as usize] = Cost::MAX);
        self.open.clear();
        self.cost[from as usize] = 0;
        self.reached.push(from);
        self.open.push(Reverse((0, from)));
        let (mut settled, mut work) = (0, 0);
        while let Some(Reverse((cost, node))) = self.open.pop() {
            if cost > self.cost[node as usize] {
                continue;
            }
            if settled == WITNESSES || cost >= farthest {
                break;
            }
            settled += 1;
            for edge in &edges[node as usize] {
                work += 1;
                let next = cost + edge.cost;
                let known = &mut self.cost[edge.to as usize];
                if edge.to == without || next > farthest || next >= *known {
                    continue;
                }
                if *known == Cost::MAX {
                    self.reached.push(edge.to);
                }
                *known = next;
                self.open.push(Reverse((next, edge.to)));
            }
        }
        work
    }
}
