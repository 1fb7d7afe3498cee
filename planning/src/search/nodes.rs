//! What A* and Dijkstra share: the nodes of a grid and the open list.

use super::{Open, neighbours};
use crate::{
    grid::{Cell, Grid},
    moves::{Cost, Length, MoveSet, Step},
    path::Path,
};

/// The memory of a search by [`super::AStar`] or [`super::Dijkstra`], 16 bytes a cell. It is reused from
/// query to query and allocates only when a grid is larger than any before.
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    nodes: Vec<Node>,
    /// Nodes of other rounds are as good as new: no need to clear them.
    round: u32,
    open: Open<Cell>,
    pub(super) path: Path,
}

#[derive(Clone, Copy, Debug, Default)]
struct Node {
    cost: Cost,
    round: u32,
    /// The number of the move by which the node was reached; [`START`] at the start.
    reached_by: u8,
    closed: bool,
    /// Whether the search goes on until this node is expanded.
    wanted: bool,
}

const START: u8 = u8::MAX;

/// The cost of each move of [`MoveSet::steps`].
const COSTS: [Cost; 16] = {
    let steps = MoveSet::Sixteen.steps();
    let mut costs = [0; 16];
    let mut number = 0;
    while number < 16 {
        costs[number] = Length::of(steps[number]).cost();
        number += 1;
    }
    costs
};

impl Workspace {
    /// Forgets the last query.
    pub(super) fn begin(&mut self, grid: &Grid) {
        if self.nodes.len() < grid.len() || self.round == u32::MAX {
            self.nodes.clear();
            self.nodes.resize(grid.len(), Node::default());
            self.round = 0;
        }
        self.round += 1;
    }

    /// Wants a cell; whether it was not wanted before.
    pub(super) fn want(&mut self, index: usize) -> bool {
        let round = self.round;
        let Some(node) = self.nodes.get_mut(index).filter(|node| node.round != round) else { return false };
        *node = Node { cost: Cost::MAX, round, reached_by: START, closed: false, wanted: true };
        true
    }

    /// Searches from `start` until all of the `wanted` nodes that are wanted are expanded and no shorter
    /// way can lead to the last of them; returns how many nodes were expanded.
    pub(super) fn run(
        &mut self,
        grid: &Grid,
        moves: MoveSet,
        start: Cell,
        estimate: impl Fn(Cell) -> Cost,
        mut wanted: usize,
    ) -> u32 {
        let width = grid.width() as usize;
        let index = |cell: Cell| cell.y as usize * width + cell.x as usize;
        self.open.begin(estimate(start));
        self.reach(index(start), 0, START);
        self.open.push(estimate(start), start);
        let mut expanded = 0;
        let mut bound = Cost::MAX;
        while let Some(cell) = self.open.pop(bound) {
            let Some(node) = self.nodes.get_mut(index(cell)).filter(|node| !node.closed) else { continue };
            let cost = node.cost;
            if cost + estimate(cell) >= bound {
                continue;
            }
            node.closed = true;
            expanded += 1;
            if std::mem::take(&mut node.wanted) {
                wanted -= 1;
                if wanted == 0 {
                    bound = cost;
                    continue;
                }
            }
            let mut allowed = neighbours::allowed(grid, moves, cell);
            while allowed != 0 {
                let number = allowed.trailing_zeros() as usize;
                allowed &= allowed - 1;
                let (dx, dy) = moves.steps()[number];
                let next = Cell { x: cell.x + dx, y: cell.y + dy };
                let cost = cost + COSTS[number];
                if self.reach(index(next), cost, number as u8) {
                    self.open.push(cost + estimate(next), next);
                }
            }
        }
        expanded
    }

    /// Notes a way to a node; whether it is the shortest so far.
    #[inline]
    fn reach(&mut self, index: usize, cost: Cost, reached_by: u8) -> bool {
        let round = self.round;
        let node = &mut self.nodes[index];
        let is_known = node.round == round;
        if is_known && node.cost <= cost {
            return false;
        }
        *node = Node { cost, round, reached_by, closed: false, wanted: is_known && node.wanted };
        true
    }

    /// Whether the shortest way to `cell` is known.
    pub(super) fn is_expanded(&self, grid: &Grid, cell: Cell) -> bool {
        let node = grid.index(cell).and_then(|index| self.nodes.get(index));
        node.is_some_and(|node| node.round == self.round && node.closed)
    }

    /// Whether there is a way to a node.
    pub(super) fn is_reached(&self, index: usize) -> bool {
        self.nodes.get(index).is_some_and(|node| node.round == self.round && node.cost < Cost::MAX)
    }

    /// The moves from `cell` back to the start, each as it was made.
    pub(super) fn steps_back<'a>(&'a self, grid: &'a Grid, cell: Cell) -> impl Iterator<Item = Step> + 'a {
        steps_back(&self.nodes, self.round, grid, cell)
    }

    /// Puts the way from the start to `to` into [`Self::path`].
    pub(super) fn trace(&mut self, grid: &Grid, to: Cell) {
        let Self { nodes, round, path, .. } = self;
        path.restart(to);
        steps_back(nodes, *round, grid, to).for_each(|(dx, dy)| path.step((-dx, -dy)));
        path.reverse();
    }
}

fn steps_back<'a>(
    nodes: &'a [Node],
    round: u32,
    grid: &'a Grid,
    cell: Cell,
) -> impl Iterator<Item = Step> + 'a {
    let mut here = cell;
    std::iter::from_fn(move || {
        let node = nodes.get(grid.index(here)?).filter(|node| node.round == round)?;
        let &step = MoveSet::Sixteen.steps().get(usize::from(node.reached_by))?;
        here = here.offset(-step.0, -step.1);
        Some(step)
    })
}
