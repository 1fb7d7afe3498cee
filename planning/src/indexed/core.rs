//! Search in the core of a hierarchy: A* with landmarks.
//!
//! The difference of two nodes' distances to a landmark is never more than the way between them
//! (Goldberg and Harrelson, "Computing the Shortest Path: A* Search Meets Graph Theory", SODA 2005).
//! With 8 neighbours the distances are kept as counts of moves: in half the memory of costs, and still exact, so
//! that of many equally short paths, as there are on grids, only one is followed.

use super::{
    hierarchy::{Hierarchy, NONE},
    turns::Directions,
};
use crate::{
    grid::Cell,
    moves::{Cost, Length, MoveSet},
    search::Open,
};

/// How many landmarks there are, a multiple of 4.
const LANDMARKS: usize = 32;
/// How many of them a query uses: those that tell most of its start and goal.
const ACTIVE: usize = 5;

/// How far a node is from a landmark, for a move set.
pub(super) trait Distance: Copy + PartialEq {
    const MOVES: MoveSet;
    /// No way leads there.
    const UNKNOWN: Self;

    /// `None` if it is too large.
    fn of(cost: Cost) -> Option<Self>;

    fn cost(self) -> Cost;
}

/// Straight and diagonal moves: the distance with 8 neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Counts {
    straight: u16,
    diagonal: u16,
}

impl Distance for Counts {
    const MOVES: MoveSet = MoveSet::Eight;
    const UNKNOWN: Self = Self { straight: u16::MAX, diagonal: u16::MAX };

    /// The only counts that give `cost`.
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

/// The distance with 16 neighbours: three counts can't be told from their cost.
impl Distance for Cost {
    const MOVES: MoveSet = MoveSet::Sixteen;
    /// The way on can be added.
    const UNKNOWN: Self = Self::MAX / 2;

    fn of(cost: Cost) -> Option<Self> {
        (cost < Self::UNKNOWN).then_some(cost)
    }

    fn cost(self) -> Cost {
        self
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
pub(super) struct Landmarks<D> {
    /// By landmark, then by core node: a query reads few landmarks of many nodes near each other.
    distances: Vec<Vec<D>>,
}

impl<D: Distance> Landmarks<D> {
    /// Spreads landmarks around `among`, core nodes of one component: a landmark tells most of pairs
    /// that it is behind.
    pub(super) fn spread(hierarchy: &Hierarchy, cells: &[Cell], among: &[u32]) -> Self {
        let (mut costs, mut open) = (Vec::new(), Open::default());
        let mut distances = Vec::new();
        for landmark in around(cells, among) {
            distances_from(hierarchy, landmark, &mut costs, &mut open);
            let counted = |node: &u32| D::of(costs[*node as usize]).is_some();
            // One with a distance too long to be counted would promise too much of its neighbours.
            if among.iter().all(counted) {
                let counts = costs.iter().map(|&cost| D::of(cost).unwrap_or(D::UNKNOWN));
                distances.push(counts.collect());
            }
        }
        Self { distances }
    }

    /// The landmarks that tell most of the way between `starts` and `goals`, each so far from its end:
    /// how far they are from all nodes and from the goal.
    fn active(&self, starts: &[(u32, Cost)], goals: &[(u32, Cost)]) -> [(&[D], Cost); ACTIVE] {
        let mut best: [(Cost, &[D]); ACTIVE] = [(0, &[]); ACTIVE];
        // To choose by, any node near each end will do.
        let (Some(&(start, _)), Some(&(goal, _))) = (starts.first(), goals.first()) else {
            return [(&[], 0); ACTIVE];
        };
        for distances in &self.distances {
            let (from, to) = (distances[start as usize], distances[goal as usize]);
            let tells = from.cost().abs_diff(to.cost());
            if let Some(place) = best.iter().position(|&(least, _)| tells > least) {
                best[place..].rotate_right(1);
                best[place] = (tells, distances);
            }
        }
        best.map(|(_, distances)| {
            let by = |&(node, cost): &(u32, Cost)| Some(distances.get(node as usize)?.cost() + cost);
            (distances, goals.iter().filter_map(by).min().unwrap_or_default())
        })
    }

    pub(super) fn bytes(&self) -> usize {
        self.distances.iter().map(|distances| size_of_val(distances.as_slice())).sum()
    }
}

/// Those of `among` that are nearest to [`LANDMARKS`] points spaced evenly on the frame around them all.
fn around(cells: &[Cell], among: &[u32]) -> Vec<u32> {
    let columns = || among.iter().map(|&node| i64::from(cells[node as usize].x));
    let rows = || among.iter().map(|&node| i64::from(cells[node as usize].y));
    let frame = (columns().min(), columns().max(), rows().min(), rows().max());
    let (Some(left), Some(right), Some(top), Some(bottom)) = frame else { return Vec::new() };
    let side = LANDMARKS as i64 / 4;
    let part = |number: i64, length: i64| length * (2 * number + 1) / (2 * side);
    let (width, height) = (right - left, bottom - top);
    let points = (0..side).flat_map(|number| {
        let (x, y) = (left + part(number, width), top + part(number, height));
        [(x, top), (right, y), (x, bottom), (left, y)]
    });
    let nearest = |(x, y): (i64, i64)| {
        among.iter().copied().min_by_key(|&node| {
            let cell = cells[node as usize];
            (i64::from(cell.x) - x).pow(2) + (i64::from(cell.y) - y).pow(2)
        })
    };
    points.filter_map(nearest).collect()
}

/// Dijkstra's algorithm in the core.
fn distances_from(hierarchy: &Hierarchy, from: u32, costs: &mut Vec<Cost>, open: &mut Open<Reached>) {
    costs.clear();
    costs.resize(hierarchy.core as usize, Cost::MAX);
    open.begin(0);
    open.push(0, Reached { node: from, cost: 0, sum: 0, onward: Directions::ALL });
    costs[from as usize] = 0;
    while let Some(Reached { node, cost, onward, .. }) = open.pop(Cost::MAX) {
        if cost > costs[node as usize] {
            continue;
        }
        for edge in hierarchy.edges_of(node) {
            let next = cost + edge.cost;
            if edge.leaves.within(onward) && next < costs[edge.to as usize] {
                costs[edge.to as usize] = next;
                let onward = edge.onward;
                open.push(next, Reached { node: edge.to, cost: next, sum: next, onward });
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
    open: Open<Reached>,
    pub(super) expanded: u32,
}

#[derive(Clone, Copy, Debug, Default)]
struct Node {
    cost: Cost,
    round: u32,
    /// From where it was reached, [`NONE`] at a start.
    parent: u32,
}

/// A node that was reached.
#[derive(Clone, Copy, Debug)]
struct Reached {
    node: u32,
    cost: Cost,
    /// With the estimate of the way on.
    sum: Cost,
    /// What it is left by.
    onward: Directions,
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
    pub(super) fn run<D: Distance>(
        &mut self,
        (hierarchy, landmarks, cells): (&Hierarchy, &Landmarks<D>, &[Cell]),
        starts: &[(u32, Cost)],
        target: &Target<'_>,
        bound: Cost,
    ) -> Option<(u32, Cost)> {
        self.begin(hierarchy.core as usize);
        target.from.iter().for_each(|&(node, cost)| self.goal[node as usize] = cost);
        let active = landmarks.active(starts, target.from);
        let estimate = |node: u32| {
            let cell = cells[node as usize];
            let open = D::MOVES.open_length(target.cell.x - cell.x, target.cell.y - cell.y).cost();
            active.iter().fold(open, |most, (distances, to)| {
                distances.get(node as usize).map_or(most, |distance| most.max(distance.cost().abs_diff(*to)))
            })
        };
        self.open.begin(starts.iter().map(|&(node, cost)| cost + estimate(node)).min().unwrap_or_default());
        for &(node, cost) in starts {
            self.reach((node, cost, Directions::ALL), NONE, bound, estimate);
        }
        let mut best = None;
        let mut least = bound;
        while let Some(Reached { node, cost, sum, onward }) = self.open.pop(least) {
            if sum >= least || cost > self.nodes[node as usize].cost {
                continue;
            }
            self.expanded += 1;
            let through = cost.saturating_add(self.goal[node as usize]);
            if through < least {
                (least, best) = (through, Some((node, through)));
            }
            for edge in hierarchy.edges_of(node).iter().filter(|edge| edge.leaves.within(onward)) {
                let reached = (edge.to, cost + edge.cost, edge.onward);
                self.reach(reached, node, least, estimate);
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
        self.expanded = 0;
        if self.nodes.len() < nodes || self.round == u32::MAX {
            self.nodes.clear();
            self.nodes.resize(nodes, Node::default());
            self.goal.resize(nodes, Cost::MAX);
            self.round = 0;
        }
        self.round += 1;
    }

    fn reach(
        &mut self,
        (node, cost, onward): (u32, Cost, Directions),
        parent: u32,
        bound: Cost,
        estimate: impl Fn(u32) -> Cost,
    ) {
        let known = &mut self.nodes[node as usize];
        if known.round == self.round && known.cost <= cost {
            return;
        }
        *known = Node { cost, round: self.round, parent };
        let estimated = estimate(node);
        if cost + estimated < bound {
            self.open.push(cost + estimated, Reached { node, cost, sum: cost + estimated, onward });
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
            let distance = Counts { straight, diagonal };
            prop_assert_eq!(Counts::of(distance.cost()), Some(distance));
        }

        #[test]
        fn what_is_no_sum_of_few_moves_is_not_counted(cost: Cost) {
            if let Some(distance) = Counts::of(cost) {
                prop_assert_eq!(distance.cost(), cost);
            }
        }
    }
}
