//! How wolves move: the grey wolf optimiser's eqs. 1 to 8.

use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::{agent::Agent, point::Point};
use crate::grid::Grid;

/// The alpha, beta and delta wolf: the three best paths so far, best first.
#[derive(Clone, Debug, Default)]
pub(super) struct Leaders([Agent; 3]);

impl Leaders {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.0.iter_mut().for_each(|leader| leader.fitness = f64::INFINITY);
    }

    /// The best path so far.
    pub const fn alpha(&self) -> &Agent {
        let [alpha, _, _] = &self.0;
        alpha
    }

    /// Ranks a wolf among the leaders, if it is better than one of them and as good as none.
    pub fn rank(&mut self, wolf: &Agent) {
        let rank = self.0.iter().position(|leader| wolf.fitness <= leader.fitness);
        let Some(outranked) = rank.and_then(|rank| self.0.get_mut(rank..)) else { return };
        if outranked.first().is_some_and(|leader| leader.fitness == wolf.fitness) {
            return;
        }
        outranked.rotate_right(1);
        if let Some(place) = outranked.first_mut() {
            place.copy_from(wolf);
        }
    }

    /// Moves a wolf's nodes to where the leaders see the prey: the mean of X1, X2 and X3 (eqs. 5 to 8)
    /// with the convergence factor `a`.
    pub fn pull(&self, grid: &Grid, a: f64, nodes: &mut [Point], rng: &mut Pcg64Mcg) {
        // As long as there are fewer than three different paths, the best leads in place of others.
        let [alpha, ..] = &self.0;
        let [alpha, beta, delta] =
            self.0.each_ref().map(|leader| if leader.fitness.is_finite() { leader } else { alpha });
        let leaders = alpha.nodes.iter().zip(&beta.nodes).zip(&delta.nodes);
        for (node, ((alpha, beta), delta)) in nodes.iter_mut().zip(leaders) {
            let (mut x, mut y) = (0.0, 0.0);
            for leader in [alpha, beta, delta] {
                x += seen(leader.x, node.x, a, rng);
                y += seen(leader.y, node.y, a, rng);
            }
            *node = Point { x: x / 3.0, y: y / 3.0 }.clamped(grid);
        }
    }
}

/// Eqs. 1 to 4, in one coordinate: where a wolf at `own` goes if a leader at `leader` were the prey.
fn seen(leader: f64, own: f64, a: f64, rng: &mut Pcg64Mcg) -> f64 {
    let (r1, r2): (f64, f64) = (rng.random(), rng.random());
    let adjustment = 2.0 * a * r1 - a;
    let distance = (2.0 * r2 * leader - own).abs();
    leader - adjustment * distance
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;

    fn wolf(fitness: f64) -> Agent {
        Agent { nodes: vec![Point { x: fitness, y: 0.0 }], turns: Vec::new(), fitness }
    }

    fn led_by(fitness: &[f64]) -> Leaders {
        let mut leaders = Leaders::default();
        leaders.clear();
        fitness.iter().for_each(|&fitness| leaders.rank(&wolf(fitness)));
        leaders
    }

    #[test]
    fn leaders_are_the_three_best_that_differ() {
        let leaders = led_by(&[5.0, 3.0, f64::INFINITY, 4.0, 3.0, 9.0, 1.0, 4.0]);
        assert_eq!(leaders.0.map(|leader| leader.fitness), [1.0, 3.0, 4.0]);
    }

    #[test]
    fn in_the_end_a_wolf_stands_in_the_middle_of_its_leaders() {
        let grid = Grid::blocked(20, 20).unwrap();
        let mut rng = Pcg64Mcg::seed_from_u64(0);
        let mut nodes = [Point { x: 19.0, y: 7.0 }];
        led_by(&[1.0, 2.0, 6.0]).pull(&grid, 0.0, &mut nodes, &mut rng);
        assert_eq!(nodes, [Point { x: 3.0, y: 0.0 }]);
        led_by(&[4.0]).pull(&grid, 0.0, &mut nodes, &mut rng);
        assert_eq!(nodes, [Point { x: 4.0, y: 0.0 }]);
    }

    #[test]
    fn no_wolf_leaves_the_grid() {
        let grid = Grid::blocked(9, 7).unwrap();
        let mut rng = Pcg64Mcg::seed_from_u64(1);
        let mut nodes = [Point { x: 8.0, y: 6.0 }];
        for _ in 0..1000 {
            led_by(&[1.0, 2.0, 6.0]).pull(&grid, 2.0, &mut nodes, &mut rng);
            assert!(grid.index(nodes[0].cell()).is_some());
        }
    }
}
