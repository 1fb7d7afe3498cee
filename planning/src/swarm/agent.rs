//! One member of a swarm.

use super::point::Point;
use crate::grid::Cell;

/// A wolf, or a particle: its nodes and the path they lead to.
#[derive(Clone, Debug, Default)]
pub(super) struct Agent {
    /// Where it is in the space that is searched.
    pub nodes: Vec<Point>,
    /// Where its path turns, start and goal included; nothing if its nodes lead nowhere.
    pub turns: Vec<Cell>,
    /// How good its path is: the less, the better; infinite if there is none.
    pub fitness: f64,
}

impl Agent {
    /// Becomes the same as `other` without allocating anew.
    pub fn copy_from(&mut self, other: &Self) {
        self.nodes.clone_from(&other.nodes);
        self.turns.clone_from(&other.turns);
        self.fitness = other.fitness;
    }
}
