//! Search in the core of a hierarchy: A* with landmarks.
//!
//! The difference of two nodes' distances to a landmark is never more than the way between them
//! (Goldberg and Harrelson, "Computing the Shortest Path: A* Search Meets Graph Theory", SODA 2005).
//! The distances are kept as counts of moves: in half the memory of costs, and still exact, so that
//! of many equally short paths, as there are on grids, only one is followed.

use std::{cmp::Reverse, collections::BinaryHeap};

use super::hierarchy::{Hierarchy, NONE};
use crate::{
    grid::Cell,
    moves::{Cost, Length, MoveSet},
};

/// How many landmarks there are: a node's distances to all of them fill a cache line.
const LANDMARKS: usize = 16;
/// How many of them a query uses: those that tell most of its start and goal.
const ACTIVE: usize = 4;

/// Straight and diagonal moves to a landmark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Distance {
    straight: u16,
    diagonal: u16,
}

impl Distance {
    /// No way leads there.
    const UNKNOWN: Self = Self { straight: u16::MAX, diagonal: u16::MAX };

    /// The only counts that give `cost`; `None` if they are too large.
    fn of(cost: Cost) -> Option<Self> {
        const DIAGONAL: Cost = Length { straight: 0, diagonal: 1, knight: 0 }.cost();
        const STRAIGHT: Cost = Length { straight: 1, diagonal: 0, knight: 0 }.cost();
        // The straight moves are multiples of 2^32, so that the low half is the diagonal ones' alone:
        // an odd number of eighths for each, which has an inverse.
        const INVERSE: u32 = inverse((DIAGONAL / 8) as u32);
        let diagonal = (((cost / 8) as u32 & EIGHTHS).wrapping_mul(INVERSE)) & EIGHTHS;
        let straight = cost.checked_sub(Cost::from(diagonal) * DIAGONAL)? / STRAIGHT;
        let distance = Self { straight: straight.try_into().ok()?, diagonal: diagonal.try_into().ok()? };
        (distance.cost() == cost && distance != Self::UNKNOWN).then_some(distance)
    }

    fn cost(self) -> Cost {
        Length { straight: self.straight.into(), diagonal: self.diagonal.into(), knight: 0 }.cost()
    }
}

/// The low 29 bits.
const EIGHTHS: u32 = u32::MAX >> 3;

/// What `odd` is to be multiplied with to give 1 in 32 bits, by Newton's iteration.
const fn inverse(odd: u32) -> u32 {
    let mut inverse = odd;
    let mut bits = 3;
    while bits < 32 {
        inverse = inverse.wrapping_mul(2u32.wrapping_sub(odd.wrapping_mul(inverse)));
        bits *= 2;
    }
    inverse
}

/// The landmarks of a core.
#[derive(Clone, Debug)]
pub(super) struct Landmarks {
    /// By core node, then by landmark.
    distances: Vec<[Distance; LANDMARKS]>,
}

impl Landmarks {
    /// Spreads landmarks around `among`, core nodes of one component: a landmark tells most of pairs
    /// that it is behind.
    pub(super) fn spread(hierarchy: &Hierarchy, cells: &[Cell], among: &[u32]) -> Self {
        let mut distances = vec![[Distance::UNKNOWN; LANDMARKS]; hierarchy.core as usize];
        let mut costs = Vec::new();
        for number in 0..LANDMARKS {
            let Some(landmark) = around(cells, among, number) else { break };
            distances_from(hierarchy, landmark, &mut costs);
            let counted = |&&node: &&u32| Distance::of(costs[node as usize]).is_some();
            // One with a distance too long to be counted would promise too much of its neighbours.
            if among.iter().filter(counted).count() < among.len() {
                continue;
            }
            for (distances, &cost) in distances.iter_mut().zip(&costs) {
                distances[number] = Distance::of(cost).unwrap_or(Distance::UNKNOWN);
            }
        }
        Self { distances }
    }

    /// The least distances from each landmark by way of `nodes`, each so far away.
    fn distances(&self, nodes: &[(u32, Cost)]) -> [Cost; LANDMARKS] {
        let mut least = [Cost::MAX; LANDMARKS];
        for &(node, cost) in nodes {
            for (least, distance) in least.iter_mut().zip(self.distances[node as usize]) {
                if distance != Distance::UNKNOWN {
                    *least = (*least).min(distance.cost() + cost);
                }
            }
        }
        least
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.distances.as_slice())
    }
}

/// The one of `among` nearest to a point on the frame around them all, `number` of [`LANDMARKS`]
/// sixteenths along it.
fn around(cells: &[Cell], among: &[u32], number: usize) -> Option<u32> {
    let at = |node: &u32| (i64::from(cells[*node as usize].x), i64::from(cells[*node as usize].y));
    let (left, right) =
        (among.iter().map(|node| at(node).0).min()?, among.iter().map(|node| at(node).0).max()?);
    let (top, bottom) =
        (among.iter().map(|node| at(node).1).min()?, among.iter().map(|node| at(node).1).max()?);
    let side = LANDMARKS / 4;
    let part = |length: i64| length * (2 * (number % side) as i64 + 1) / (2 * side as i64);
    let (width, height) = (right - left, bottom - top);
    let (x, y) = match number / side {
        0 => (left + part(width), top),
        1 => (right, top + part(height)),
        2 => (right - part(width), bottom),
        _ => (left, bottom - part(height)),
    };
    among.iter().copied().min_by_key(|node| {
        let (dx, dy) = (at(node).0 - x, at(node).1 - y);
        (dx * dx + dy * dy, *node)
    })
}

/// Dijkstra's algorithm in the core.
fn distances_from(hierarchy: &Hierarchy, from: u32, costs: &mut Vec<Cost>) {
    costs.clear();
    costs.resize(hierarchy.core as usize, Cost::MAX);
    let mut open = BinaryHeap::from([Reverse((0, from))]);
    costs[from as usize] = 0;
    while let Some(Reverse((cost, node))) = open.pop() {
        if cost > costs[node as usize] {
            continue;
        }
        for edge in hierarchy.edges_of(node) {
            let next = cost + edge.cost;
            if next < costs[edge.to as usize] {
                costs[edge.to as usize] = next;
                open.push(Reverse((next, edge.to)));
            }
        }
    }
}

/// The memory of a search.
#[derive(Clone, Debug, Default)]
pub(super) struct Workspace {
    nodes: Vec<Node>,
    /// By node, how far the goal is from there; [`Cost::MAX`] if only by way of other core nodes.
    goal: Vec<Cost>,
    /// Nodes of other rounds are as good as new.
    round: u32,
    open: BinaryHeap<Reverse<(Cost, Cost, u32)>>,
    pub(super) expanded: u32,
}

#[derive(Clone, Copy, Debug, Default)]
struct Node {
    cost: Cost,
    round: u32,
    /// From where it was reached, [`NONE`] at a start.
    parent: u32,
}

/// Where a search goes.
pub(super) struct Target<'a> {
    pub(super) cell: Cell,
    /// How far it is from core nodes.
    pub(super) from: &'a [(u32, Cost)],
}

impl Workspace {
    /// The core node from which the shortest way from `starts`, each so far from the start, leaves the
    /// core for `target`, and the way's cost; `None` if it is no shorter than `bound`.
    pub(super) fn run(
        &mut self,
        (hierarchy, landmarks, cells): (&Hierarchy, &Landmarks, &[Cell]),
        starts: &[(u32, Cost)],
        target: &Target<'_>,
        bound: Cost,
    ) -> Option<(u32, Cost)> {
        self.begin(hierarchy.core as usize);
        target.from.iter().for_each(|&(node, cost)| self.goal[node as usize] = cost);
        let (from, to) = (landmarks.distances(starts), landmarks.distances(target.from));
        let mut active: [usize; LANDMARKS] = std::array::from_fn(|landmark| landmark);
        // Either both are unknown or none is.
        active.sort_by_key(|&landmark| Reverse(from[landmark].abs_diff(to[landmark])));
        let estimate = |node: u32| {
            let (cell, distances) = (cells[node as usize], &landmarks.distances[node as usize]);
            let open = MoveSet::Eight.open_length(target.cell.x - cell.x, target.cell.y - cell.y).cost();
            active[..ACTIVE].iter().fold(open, |most, &landmark| {
                if to[landmark] == Cost::MAX {
                    return most;
                }
                most.max(distances[landmark].cost().abs_diff(to[landmark]))
            })
        };
        for &(node, cost) in starts {
            self.reach(node, cost, NONE, bound, estimate);
        }
        let mut best = None;
        let mut least = bound;
        while let Some(Reverse((sum, estimated, node))) = self.open.pop() {
            if sum >= least {
                break;
            }
            let cost = self.nodes[node as usize].cost;
            if sum - estimated > cost {
                continue;
            }
            self.expanded += 1;
            let through = cost.saturating_add(self.goal[node as usize]);
            if through < least {
                (least, best) = (through, Some((node, through)));
            }
            for edge in hierarchy.edges_of(node) {
                self.reach(edge.to, cost + edge.cost, node, least, estimate);
            }
        }
        target.from.iter().for_each(|&(node, _)| self.goal[node as usize] = Cost::MAX);
        best
    }

    /// From where the last search reached `node`; `None` at its starts.
    pub(super) fn parent(&self, node: u32) -> Option<u32> {
        Some(self.nodes[node as usize].parent).filter(|&parent| parent != NONE)
    }

    fn begin(&mut self, nodes: usize) {
        self.open.clear();
        self.expanded = 0;
        if self.nodes.len() < nodes || self.round == u32::MAX {
            self.nodes.clear();
            self.nodes.resize(nodes, Node::default());
            self.goal.resize(nodes, Cost::MAX);
            self.round = 0;
        }
        self.round += 1;
    }

    fn reach(&mut self, node: u32, cost: Cost, parent: u32, bound: Cost, estimate: impl Fn(u32) -> Cost) {
        let known = &mut self.nodes[node as usize];
        if known.round == self.round && known.cost <= cost {
            return;
        }
        *known = Node { cost, round: self.round, parent };
        let estimated = estimate(node);
        // Of equal sums the one nearer to the goal comes first.
        if cost + estimated < bound {
            self.open.push(Reverse((cost + estimated, estimated, node)));
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn counts_come_back_from_costs(straight in 0u16..u16::MAX, diagonal: u16) {
            let distance = Distance { straight, diagonal };
            prop_assert_eq!(Distance::of(distance.cost()), Some(distance));
        }

        #[test]
        fn what_is_no_sum_of_few_moves_is_not_counted(cost: Cost) {
            if let Some(distance) = Distance::of(cost) {
                prop_assert_eq!(distance.cost(), cost);
            }
        }
    }
}
