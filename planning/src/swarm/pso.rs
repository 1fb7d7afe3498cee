//! How particles move: particle swarm optimisation, which IGWO compares with (4.3.1).

use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::{agent::Agent, point::Point};
use crate::grid::Grid;

/// Of a particle's velocity so much stays.
const INERTIA: f64 = 0.729;
/// The pull of a particle's own best path and of the swarm's. IGWO's table of parameters is missing from
/// the text at hand: these three are Clerc's, with which a swarm always converges.
const PULL: f64 = 1.494;

/// What a particle has beside its place.
#[derive(Clone, Debug, Default)]
pub(super) struct Flight {
    velocities: Vec<Point>,
    /// The particle at its best.
    best: Agent,
}

impl Flight {
    /// Sets out from where `particle` is.
    pub fn start(&mut self, particle: &Agent) {
        self.velocities.clear();
        self.velocities.resize(particle.nodes.len(), Point::default());
        self.best.copy_from(particle);
    }

    /// Remembers where `particle` is if it was never better.
    pub fn remember(&mut self, particle: &Agent) {
        if particle.fitness < self.best.fitness {
            self.best.copy_from(particle);
        }
    }

    /// Moves a particle's nodes on, drawn to its own best and to the swarm's.
    pub fn fly(&mut self, grid: &Grid, swarm: &Agent, nodes: &mut [Point], rng: &mut Pcg64Mcg) {
        let bests = self.best.nodes.iter().zip(&swarm.nodes);
        for ((node, velocity), (own, swarm)) in nodes.iter_mut().zip(&mut self.velocities).zip(bests) {
            velocity.x = pulled(velocity.x, node.x, [own.x, swarm.x], rng);
            velocity.y = pulled(velocity.y, node.y, [own.y, swarm.y], rng);
            *node = Point { x: node.x + velocity.x, y: node.y + velocity.y }.clamped(grid);
        }
    }
}

/// The next velocity in one coordinate.
fn pulled(velocity: f64, here: f64, bests: [f64; 2], rng: &mut Pcg64Mcg) -> f64 {
    bests
        .into_iter()
        .fold(INERTIA * velocity, |velocity, best| velocity + PULL * rng.random::<f64>() * (best - here))
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;

    #[test]
    fn a_particle_comes_to_rest_where_both_bests_are() {
        let grid = Grid::blocked(50, 50).unwrap();
        let mut rng = Pcg64Mcg::seed_from_u64(3);
        let best = Agent { nodes: vec![Point { x: 20.0, y: 30.0 }], turns: Vec::new(), fitness: 1.0 };
        let mut nodes = [Point { x: 3.0, y: 45.0 }];
        let mut flight = Flight::default();
        flight.start(&Agent { nodes: nodes.to_vec(), turns: Vec::new(), fitness: f64::INFINITY });
        flight.remember(&best);
        for _ in 0..300 {
            flight.fly(&grid, &best, &mut nodes, &mut rng);
        }
        assert!(nodes[0].distance(best.nodes[0]) < 1e-3, "{nodes:?}");
    }
}
