//! Any start to any goal in microseconds, through an index of the map.
//!
//! The index holds the `subgoals` of the map as a graph, a `hierarchy` on it and the hub
//! `labels` of its nodes. A query asks whether the goal can be seen, else which subgoals start and
//! goal see, and compares their labels: no search. Where so much stands around that the hierarchy
//! stops early (random clutter), labels end at its `core`, through which A* with landmarks
//! searches the rest of the way. It is one structure for all maps: the core of an office is empty,
//! and in the densest clutter it is all there is.
//!
//! What it costs to build is bounded by the number of cells, and counted, so that a map gives the
//! same index on every machine. A map that changes needs a new one.
//!
//! It is the same for 8 and 16 neighbours: with the corner rule both turn at the same subgoals. What differs is
//! what sees what.

mod core;
mod hierarchy;
mod labels;
mod lines;
mod sight;
mod slanted;
mod subgoals;
#[cfg(test)]
mod tests;
mod turns;

use self::{
    core::{Counts, Landmarks, Target},
    hierarchy::{Edge, Hierarchy, NONE},
    labels::Labels,
    sight::{Leg, Turn},
    subgoals::Subgoals,
    turns::Directions,
};
use crate::{
    grid::{Cell, Grid},
    moves::{Cost, MoveSet},
    path::Path,
    search::{Plan, Planner, SearchError, free_index},
};

/// How many edges contraction looks at for each cell of the map.
const EDGES_A_CELL: u64 = 100;
/// And for a map however small.
const EDGES: u64 = 1_000_000;

/// An index of a map for shortest paths.
#[derive(Clone, Debug)]
pub struct Index {
    grid: Grid,
    subgoals: Subgoals,
    hierarchy: Hierarchy,
    labels: Labels,
    /// By node, a number that those share between which there is a path.
    components: Vec<u32>,
    landmarks: AnyLandmarks,
}

#[derive(Clone, Debug)]
enum AnyLandmarks {
    Eight(Landmarks<Counts>),
    Sixteen(Landmarks<Cost>),
}

impl Index {
    /// The index of `grid`.
    ///
    /// Below a second on one core for 512 x 512 cells of random clutter with either move set, hundredths of one
    /// for rooms and mazes, between them where small rooms or ragged terrain have many corners; about proportional to the
    /// number of cells.
    #[must_use]
    pub fn build(grid: Grid, moves: MoveSet) -> Self {
        let budget = EDGES + EDGES_A_CELL * grid.len() as u64;
        Self::with_budget(grid, moves, budget)
    }

    fn with_budget(grid: Grid, moves: MoveSet, budget: u64) -> Self {
        let mut subgoals = Subgoals::find(&grid, moves);
        let cells = subgoals.cells();
        let neighbours = |&from: &Cell| {
            let mut edges = Vec::new();
            subgoals.sight(from, |to, cost| {
                let directions = Directions::between(moves, from, cells[to as usize]);
                edges.push(Edge { to, middle: NONE, cost, leaves: directions, arrives: directions });
            });
            edges
        };
        let graph = cells.iter().map(neighbours).collect();
        let (hierarchy, order) = Hierarchy::contract(graph, budget);
        subgoals.reorder(&order);
        let labels = Labels::new(&hierarchy);
        let components = hierarchy.components();
        let largest = largest(&hierarchy, &components);
        let landmarks = match moves {
            MoveSet::Eight => AnyLandmarks::Eight(Landmarks::spread(&hierarchy, subgoals.cells(), &largest)),
            MoveSet::Sixteen => {
                AnyLandmarks::Sixteen(Landmarks::spread(&hierarchy, subgoals.cells(), &largest))
            }
        };
        Self { grid, subgoals, hierarchy, labels, components, landmarks }
    }

    /// The map that it is of.
    #[must_use]
    pub const fn grid(&self) -> &Grid {
        &self.grid
    }

    /// What it takes, in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let grid = self.grid.row(0).len() * 8 * self.grid.height() as usize;
        let parts = [
            self.subgoals.bytes(),
            self.hierarchy.bytes(),
            self.labels.bytes(),
            size_of_val(self.components.as_slice()),
            match &self.landmarks {
                AnyLandmarks::Eight(landmarks) => landmarks.bytes(),
                AnyLandmarks::Sixteen(landmarks) => landmarks.bytes(),
            },
        ];
        grid + parts.iter().sum::<usize>()
    }

    /// Whether no path leads from what `starts` are seen from to what `goals` are seen from.
    fn parted(&self, starts: &[(u32, Cost)], goals: &[(u32, Cost)]) -> bool {
        match (starts, goals) {
            // Within sight of no corner all that can be reached is seen.
            ([], _) | (_, []) => true,
            // What is seen from one cell is all in one component.
            ([(one, _), ..], [(other, _), ..]) => {
                self.components[*one as usize] != self.components[*other as usize]
            }
        }
    }
}

/// The core nodes of the component that has the most.
fn largest(hierarchy: &Hierarchy, components: &[u32]) -> Vec<u32> {
    let mut sizes = vec![0u32; components.len()];
    let core = || (0..hierarchy.core).map(|node| (node, components[node as usize]));
    core().for_each(|(_, component)| sizes[component as usize] += 1);
    let largest = (0u32..).zip(&sizes).max_by_key(|&(_, size)| size).map(|(component, _)| component);
    core().filter(|&(_, component)| Some(component) == largest).map(|(node, _)| node).collect()
}

/// The memory of a query.
#[derive(Clone, Debug)]
pub struct Workspace {
    /// Subgoals that the start and the goal see, and how far they are.
    starts: Vec<(u32, Cost)>,
    goals: Vec<(u32, Cost)>,
    from: Reached,
    to: Reached,
    entries: Vec<(u32, Cost)>,
    exits: Vec<(u32, Cost)>,
    core: core::Workspace,
    hops: Vec<Hop>,
    path: Path,
}

impl Default for Workspace {
    fn default() -> Self {
        Self {
            starts: Vec::new(),
            goals: Vec::new(),
            from: Reached::default(),
            to: Reached::default(),
            entries: Vec::new(),
            exits: Vec::new(),
            core: core::Workspace::default(),
            hops: Vec::new(),
            path: Path::at(Cell::default()),
        }
    }
}

/// The hubs reached from one end of a query.
#[derive(Clone, Debug, Default)]
struct Reached {
    /// By node, how far it is and by which subgoal in sight.
    hubs: Vec<(Cost, u32)>,
    nodes: Vec<u32>,
}

impl Reached {
    const NOT: (Cost, u32) = (Cost::MAX, NONE);

    /// Reaches the hubs of the subgoals in sight.
    fn reach(&mut self, labels: &Labels, nodes: u32, sight: &[(u32, Cost)]) {
        self.nodes.drain(..).for_each(|node| self.hubs[node as usize] = Self::NOT);
        if self.hubs.len() < nodes as usize {
            self.hubs.resize(nodes as usize, Self::NOT);
        }
        for &(subgoal, cost) in sight {
            for hub in labels.of(subgoal) {
                let known = &mut self.hubs[hub.node as usize];
                if known.0 == Cost::MAX {
                    self.nodes.push(hub.node);
                }
                if cost + hub.cost < known.0 {
                    *known = (cost + hub.cost, subgoal);
                }
            }
        }
    }

    /// The core nodes reached, and how far they are.
    fn core<'a>(&'a self, core: u32) -> impl Iterator<Item = (u32, Cost)> + 'a {
        let nodes = self.nodes.iter().copied().filter(move |&node| node < core);
        nodes.map(|node| (node, self.hubs[node as usize].0))
    }
}

/// A way from one node to another by an edge.
#[derive(Clone, Copy, Debug)]
struct Hop {
    from: u32,
    to: u32,
    middle: u32,
}

/// Where a path leaves the nodes reached from its start and comes to those reached from its goal: the
/// same node, or two of the core.
#[derive(Clone, Copy, Debug)]
struct Meeting {
    cost: Cost,
    hub: u32,
    in_core: bool,
}

impl Planner for Index {
    type Workspace = Workspace;

    /// A shortest path. As expanded count hubs of the start and nodes of the core.
    fn plan<'w>(&self, from: Cell, to: Cell, workspace: &'w mut Workspace) -> Result<Plan<'w>, SearchError> {
        free_index(&self.grid, from)?;
        free_index(&self.grid, to)?;
        workspace.path.restart(from);
        if let Some(turn) = self.subgoals.direct(from, to) {
            go(&mut workspace.path, self.subgoals.moves(), to, Some(turn));
            return Ok(Plan { path: &workspace.path, expanded: 0 });
        }
        for (cell, sight) in [(from, &mut workspace.starts), (to, &mut workspace.goals)] {
            sight.clear();
            self.subgoals.sight(cell, |subgoal, cost| sight.push((subgoal, cost)));
        }
        let no_path = SearchError::NoPath { from, to };
        if self.parted(&workspace.starts, &workspace.goals) {
            return Err(no_path);
        }
        let meeting = workspace.meet(self, to).ok_or(no_path)?;
        workspace.unpack(self, meeting);
        go(&mut workspace.path, self.subgoals.moves(), to, None);
        let expanded = workspace.from.nodes.len() as u32 + workspace.core.expanded;
        Ok(Plan { path: &workspace.path, expanded })
    }
}

impl Workspace {
    /// Where the shortest path from the subgoals of the start to those of the goal changes from
    /// one's hubs to the other's.
    fn meet(&mut self, index: &Index, to: Cell) -> Option<Meeting> {
        let nodes = index.hierarchy.nodes();
        self.from.reach(&index.labels, nodes, &self.starts);
        self.to.reach(&index.labels, nodes, &self.goals);
        let sum = |&node: &u32| {
            let cost = self.from.hubs[node as usize].0.saturating_add(self.to.hubs[node as usize].0);
            Meeting { cost, hub: node, in_core: false }
        };
        let common = self.from.nodes.iter().map(sum).min_by_key(|meeting| meeting.cost);
        let common = common.filter(|meeting| meeting.cost != Cost::MAX);
        let core = index.hierarchy.core;
        self.entries.clear();
        self.entries.extend(self.from.core(core));
        self.exits.clear();
        self.exits.extend(self.to.core(core));
        self.core.expanded = 0;
        if self.entries.is_empty() || self.exits.is_empty() {
            return common;
        }
        let (hierarchy, cells) = (&index.hierarchy, index.subgoals.cells());
        let target = Target { cell: to, from: &self.exits };
        let bound = common.map_or(Cost::MAX, |meeting| meeting.cost);
        let through = match &index.landmarks {
            AnyLandmarks::Eight(landmarks) => {
                self.core.run((hierarchy, landmarks, cells), &self.entries, &target, bound)
            }
            AnyLandmarks::Sixteen(landmarks) => {
                self.core.run((hierarchy, landmarks, cells), &self.entries, &target, bound)
            }
        };
        through.map(|(hub, cost)| Meeting { cost, hub, in_core: true }).or(common)
    }

    /// Goes from the start to the last subgoal before the goal.
    fn unpack(&mut self, index: &Index, meeting: Meeting) {
        self.hops.clear();
        // Hops are taken from the end.
        climb(index, self.to.hubs[meeting.hub as usize].1, meeting.hub, &mut self.hops);
        for hop in &mut self.hops {
            *hop = Hop { from: hop.to, to: hop.from, middle: hop.middle };
        }
        let mut hub = meeting.hub;
        while let Some(parent) = Some(hub).filter(|_| meeting.in_core).and_then(|hub| self.core.parent(hub)) {
            if let Some(middle) = index.hierarchy.between(parent, hub) {
                self.hops.push(Hop { from: parent, to: hub, middle });
            }
            hub = parent;
        }
        let climbed = self.hops.len();
        let first = self.from.hubs[hub as usize].1;
        climb(index, first, hub, &mut self.hops);
        self.hops[climbed..].reverse();
        let (cells, moves) = (index.subgoals.cells(), index.subgoals.moves());
        go(&mut self.path, moves, cells[first as usize], None);
        while let Some(Hop { from, to, middle }) = self.hops.pop() {
            if middle == NONE {
                go(&mut self.path, moves, cells[to as usize], None);
                continue;
            }
            let halves = (index.hierarchy.between(middle, from), index.hierarchy.between(middle, to));
            if let (Some(first), Some(second)) = halves {
                self.hops.push(Hop { from: middle, to, middle: second });
                self.hops.push(Hop { from, to: middle, middle: first });
            }
        }
    }
}

/// The hops from `node` to its `hub`.
fn climb(index: &Index, mut node: u32, hub: u32, hops: &mut Vec<Hop>) {
    while let Some(place) = index.labels.next(node, hub) {
        let edge = index.hierarchy.edge(place);
        hops.push(Hop { from: node, to: edge.to, middle: index.hierarchy.middle(place) });
        node = edge.to;
    }
}

/// Goes on to `to`, which is seen from the end of the path, turning where `turn` says; without it
/// the first move is the last one so far if that is possible.
fn go(path: &mut Path, moves: MoveSet, to: Cell, turn: Option<Turn>) {
    let Leg { finer, other } = Leg::new(moves, path.end(), to);
    let turn = turn.unwrap_or_else(|| {
        if path.last_step() == Some(other.0) { Turn::FinerLast } else { Turn::FinerFirst }
    });
    let (first, second) = match turn {
        Turn::FinerFirst => (finer, other),
        Turn::FinerLast => (other, finer),
    };
    path.run(first.0, first.1);
    path.run(second.0, second.1);
}
