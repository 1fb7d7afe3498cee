//! What makes one path better than another: eq. 9, and eqs. 15 and 16 of A\*-IGWO.

use super::point::Point;
use crate::grid::Cell;

/// How AC1 and AC2 share the weight: AC1 of the path's length, AC2 of its nodes' distances. Their sum
/// is 1 (IGWO, section 4), so AC2 says both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    ac2: f64,
}

impl Weights {
    /// AC1 = AC2 = 0.5, what IGWO finds best for fitness 1 (Fig. 15).
    pub const HALF: Self = Self { ac2: 0.5 };
    /// AC1 = 0.8 and AC2 = 0.2, what IGWO finds best for fitness 2 (Fig. 16).
    pub const FIFTH: Self = Self { ac2: 0.2 };

    /// The weights with this AC2; `None` if it is not from 0 to 1.
    #[must_use]
    pub fn with_ac2(ac2: f64) -> Option<Self> {
        (0.0..=1.0).contains(&ac2).then_some(Self { ac2 })
    }

    /// The weight of the length.
    #[must_use]
    pub fn ac1(self) -> f64 {
        1.0 - self.ac2
    }

    /// The weight of the distances.
    #[must_use]
    pub const fn ac2(self) -> f64 {
        self.ac2
    }
}

/// What is to be made small, in cells.
///
/// Eqs. 15 and 16 are missing from the text at hand; they are rebuilt from its prose (3.3.2): to the
/// length with weight AC1 is added, with weight AC2 and summed over the I nodes of the path,
/// A\*'s h(x), or g(x) + h(x), both as straight distances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fitness {
    /// The length L, eq. 9.
    Length,
    /// Fitness 1, eq. 15: AC1 L + AC2 sum (distance to the goal).
    Goal(Weights),
    /// Fitness 2, eq. 16: AC1 L + AC2 sum (distance to the start + distance to the goal).
    StartAndGoal(Weights),
}

impl Fitness {
    /// The fitness of a path that turns at `turns`, whose evenly spread nodes are `nodes`.
    pub(super) fn of(self, turns: &[Cell], nodes: &[Point], from: Cell, to: Cell) -> f64 {
        let (from, to) = (Point::from(from), Point::from(to));
        let sum = |distance: &dyn Fn(Point) -> f64| nodes.iter().fold(0.0, |sum, &node| sum + distance(node));
        let length = length_cells(turns);
        match self {
            Self::Length => length,
            Self::Goal(weights) => weights.ac1() * length + weights.ac2() * sum(&|node| node.distance(to)),
            Self::StartAndGoal(weights) => {
                weights.ac1() * length + weights.ac2() * sum(&|node| node.distance(from) + node.distance(to))
            }
        }
    }
}

/// Eq. 9: the length of the straight pieces between `turns`, in cells.
pub(super) fn length_cells(turns: &[Cell]) -> f64 {
    let pieces = turns.iter().zip(turns.iter().skip(1));
    pieces.fold(0.0, |sum, (&from, &to)| sum + Point::from(from).distance(to.into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weights_are_those_of_the_equations() {
        let turns = [Cell { x: 0, y: 0 }, Cell { x: 3, y: 4 }, Cell { x: 3, y: 8 }];
        let nodes = [Point { x: 3.0, y: 4.0 }, Point { x: 3.0, y: 7.0 }];
        let of = |fitness: Fitness| fitness.of(&turns, &nodes, turns[0], turns[2]);
        let weights = Weights::with_ac2(0.25).unwrap();
        assert_eq!(of(Fitness::Length), 9.0);
        assert_eq!(of(Fitness::Goal(weights)), 0.75 * 9.0 + 0.25 * (4.0 + 1.0));
        let starts = 5.0 + f64::sqrt(9.0 + 49.0);
        assert!((of(Fitness::StartAndGoal(weights)) - (0.75 * 9.0 + 0.25 * (5.0 + starts))).abs() < 1e-12);
        assert_eq!(of(Fitness::Goal(Weights::with_ac2(0.0).unwrap())), 9.0);
    }

    #[test]
    fn weights_are_shares() {
        for wrong in [-0.1, 1.1, f64::NAN, f64::INFINITY] {
            assert_eq!(Weights::with_ac2(wrong), None);
        }
        assert_eq!(Weights::FIFTH.ac1(), 0.8);
    }
}
