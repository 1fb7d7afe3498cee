//! Paths by swarms: grey wolf optimiser (GWO), improved GWO (IGWO), A\*-IGWO, and particle swarm
//! optimisation (PSO).
//!
//! A swarm keeps a few paths in mind and moves their nodes by chance and towards the best. It promises
//! a path that can be walked, not the shortest; on parking lots it comes near. What [`Swarm::plan`]
//! answers walks straight and diagonally under the one corner rule of [`crate::moves`]. What IGWO
//! measures is [`Hunt::length_cells`], the length of the straight pieces between the path's turns
//! (eq. 9): they keep the corner rule too, and can be shorter than any path of moves.
//!
//! | module | one idea | in IGWO |
//! |---|---|---|
//! | `population` | the random paths that a swarm starts with | 3.1 |
//! | `gwo` | how wolves move | eqs. 1 to 8 |
//! | `pso` | how particles move | 4.3.1 |
//! | `convergence` | how soon wolves close in | eqs. 10 to 13 |
//! | `route`, `line` | how nodes become a path | 3.1, 3.2.1, 3.2.2 |
//! | `fitness` | which path is better | eqs. 9, 15, 16 |
//!
//! Chance comes from a seed. Only operations that are exact everywhere are used, so a seed gives the
//! same path on every machine.
//!
//! ```
//! use planning::{parking::{CellSize, Lot}, swarm::{Algorithm, Swarm, Workspace}};
//!
//! let lot = Lot::parked(CellSize::M1_30, 30, 1);
//! let &car = lot.cars().last().ok_or("an empty lot")?;
//! let swarm = Swarm::new(lot.grid(), Algorithm::ASTAR_IGWO, 7);
//! let mut workspace = Workspace::default();
//! let hunt = swarm.hunt(lot.cabin(), lot.stop(car), &mut workspace)?;
//! println!("{:.2} m after {} iterations", hunt.length_cells * 1.3, hunt.iterations());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod agent;
mod convergence;
mod fitness;
mod gwo;
mod line;
mod point;
mod population;
mod pso;
mod route;

use std::num::{NonZeroU16, NonZeroU32};

use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use crate::{
    grid::{Cell, Grid},
    path::Path,
    search::{Plan, Planner, SearchError, free_index},
};

pub use convergence::Convergence;
pub use fitness::{Fitness, Weights};

use agent::Agent;
use route::Routing;

/// How a swarm moves and what it is after.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Algorithm {
    /// The traditional grey wolf optimiser (IGWO, 3.1): nodes are joined by straight lines, and wolves whose
    /// lines meet obstacles count for nothing; a is linear, the fitness is the length.
    Gwo,
    /// The improved grey wolf optimiser (IGWO, 3.2), and A\*-IGWO (3.3) with another fitness than the
    /// length: nodes guide the robot, and what it finds is shortened and interpolated.
    Igwo {
        /// How soon wolves close in.
        convergence: Convergence,
        /// What is made small.
        fitness: Fitness,
    },
    /// Particle swarm optimisation; nodes and fitness as in [`Self::Gwo`].
    Pso,
}

impl Algorithm {
    /// IGWO with a4, which it finds needs the fewest iterations (4.1.2).
    pub const IGWO: Self = Self::Igwo { convergence: Convergence::Earliest, fitness: Fitness::Length };
    /// A\*-IGWO at its best (4.2): a4, fitness 2, AC1 = 0.8, AC2 = 0.2.
    pub const ASTAR_IGWO: Self =
        Self::Igwo { convergence: Convergence::Earliest, fitness: Fitness::StartAndGoal(Weights::FIFTH) };

    const fn routing(self) -> Routing {
        match self {
            Self::Gwo | Self::Pso => Routing::Joined,
            Self::Igwo { .. } => Routing::Guided,
        }
    }

    const fn fitness(self) -> Fitness {
        match self {
            Self::Gwo | Self::Pso => Fitness::Length,
            Self::Igwo { fitness, .. } => fitness,
        }
    }
}

/// How large a swarm is and how long it searches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// How many wolves or particles.
    pub population: NonZeroU16,
    /// How often they are ranked: the first iteration ranks the paths drawn at random, and before each
    /// that follows all move once.
    pub iterations: NonZeroU32,
    /// How many nodes a path has between start and goal (dim). IGWO's table of it is missing from the
    /// text at hand.
    pub nodes: u16,
}

impl Default for Settings {
    /// 5 wolves and 100 iterations, as in IGWO, section 4; 8 nodes.
    fn default() -> Self {
        Self {
            population: NonZeroU16::MIN.saturating_add(4),
            iterations: NonZeroU32::MIN.saturating_add(99),
            nodes: 8,
        }
    }
}

/// A planner that searches by a swarm.
#[derive(Clone, Copy, Debug)]
pub struct Swarm<'g> {
    /// Where it plans.
    pub grid: &'g Grid,
    /// How.
    pub algorithm: Algorithm,
    /// How large and how long.
    pub settings: Settings,
    /// The seed of all chance: the same query with the same seed has the same answer.
    pub seed: u64,
}

/// The memory of a query.
#[derive(Debug, Default)]
pub struct Workspace {
    random_paths: population::RandomPaths,
    agents: Vec<Agent>,
    flights: Vec<pso::Flight>,
    leaders: gwo::Leaders,
    curve: Vec<f64>,
    path: Path,
}

/// What a swarm found; it lives until the next query.
#[derive(Clone, Copy, Debug)]
pub struct Hunt<'w> {
    /// The path, in straight and diagonal moves.
    pub path: &'w Path,
    /// Where the path turns, start and goal included; between two turns it runs straight.
    pub turns: &'w [Cell],
    /// The length of the straight pieces between the turns (eq. 9), in cells.
    pub length_cells: f64,
    /// The best fitness after each iteration.
    pub curve: &'w [f64],
    /// How many paths were tried.
    pub tried: u32,
}

impl Hunt<'_> {
    /// How many iterations it took to find the best path: at least 1.
    #[must_use]
    pub fn iterations(&self) -> u32 {
        let worse = self.curve.iter().take_while(|&fitness| self.curve.last() != Some(fitness));
        1 + worse.count() as u32
    }
}

/// Between what is planned, and where.
#[derive(Clone, Copy, Debug)]
struct Ground<'g> {
    grid: &'g Grid,
    from: Cell,
    to: Cell,
}

impl<'g> Swarm<'g> {
    /// A swarm with the settings of IGWO's experiments.
    #[must_use]
    pub fn new(grid: &'g Grid, algorithm: Algorithm, seed: u64) -> Self {
        Self { grid, algorithm, settings: Settings::default(), seed }
    }

    /// Searches for a path.
    ///
    /// # Errors
    /// [`SearchError`] if an end is outside or blocked, or there is no path. Where there is one, one is
    /// found.
    pub fn hunt<'w>(
        &self,
        from: Cell,
        to: Cell,
        workspace: &'w mut Workspace,
    ) -> Result<Hunt<'w>, SearchError> {
        free_index(self.grid, from)?;
        free_index(self.grid, to)?;
        let ground = Ground { grid: self.grid, from, to };
        let mut rng = Pcg64Mcg::seed_from_u64(self.seed);
        self.begin(ground, workspace, &mut rng).ok_or(SearchError::NoPath { from, to })?;
        let moves = self.settings.iterations.get() - 1;
        for done in 0..moves {
            let progress = f64::from(done) / f64::from(moves);
            self.iterate(ground, progress, workspace, &mut rng);
            workspace.curve.push(workspace.leaders.alpha().fitness);
        }
        let Workspace { leaders, curve, path, .. } = workspace;
        let turns = leaders.alpha().turns.as_slice();
        walk(turns, from, path);
        let tried = u32::from(self.settings.population.get()).saturating_mul(curve.len() as u32);
        Ok(Hunt { path, turns, length_cells: fitness::length_cells(turns), curve, tried })
    }

    /// Draws the first population. `None` if there is no path.
    fn begin(&self, ground: Ground<'_>, workspace: &mut Workspace, rng: &mut Pcg64Mcg) -> Option<()> {
        let Workspace { random_paths, agents, flights, leaders, curve, .. } = workspace;
        let Settings { population, iterations, nodes } = self.settings;
        agents.resize_with(population.get().into(), Agent::default);
        leaders.clear();
        for agent in &mut *agents {
            random_paths.draw(ground, rng, &mut agent.turns)?;
            agent.nodes.resize(nodes.into(), point::Point::default());
            route::spread(&agent.turns, &mut agent.nodes);
            self.algorithm.routing().improve(ground, &mut agent.nodes, &mut agent.turns);
            self.assess(ground, agent);
            leaders.rank(agent);
        }
        if self.algorithm == Algorithm::Pso {
            flights.resize_with(agents.len(), pso::Flight::default);
            flights.iter_mut().zip(&*agents).for_each(|(flight, particle)| flight.start(particle));
        }
        curve.clear();
        curve.reserve(iterations.get() as usize);
        curve.push(leaders.alpha().fitness);
        Some(())
    }

    /// Moves all once, by what was known before.
    fn iterate(&self, ground: Ground<'_>, progress: f64, workspace: &mut Workspace, rng: &mut Pcg64Mcg) {
        let Workspace { agents, flights, leaders, .. } = workspace;
        match self.algorithm {
            Algorithm::Pso => {
                for (particle, flight) in agents.iter_mut().zip(&mut *flights) {
                    flight.fly(ground.grid, leaders.alpha(), &mut particle.nodes, rng);
                }
            }
            Algorithm::Gwo => pull(ground, leaders, agents, Convergence::Linear.factor(progress), rng),
            Algorithm::Igwo { convergence, .. } => {
                pull(ground, leaders, agents, convergence.factor(progress), rng);
            }
        }
        for agent in &mut *agents {
            self.algorithm.routing().route(ground, &mut agent.nodes, &mut agent.turns);
            self.assess(ground, agent);
            leaders.rank(agent);
        }
        if self.algorithm == Algorithm::Pso {
            flights.iter_mut().zip(&*agents).for_each(|(flight, particle)| flight.remember(particle));
        }
    }

    fn assess(&self, ground: Ground<'_>, agent: &mut Agent) {
        agent.fitness = if agent.turns.is_empty() {
            f64::INFINITY
        } else {
            self.algorithm.fitness().of(&agent.turns, &agent.nodes, ground.from, ground.to)
        };
    }
}

fn pull(ground: Ground<'_>, leaders: &gwo::Leaders, wolves: &mut [Agent], a: f64, rng: &mut Pcg64Mcg) {
    for wolf in wolves {
        leaders.pull(ground.grid, a, &mut wolf.nodes, rng);
    }
}

/// Puts the moves along straight pieces between turns into `path`.
fn walk(turns: &[Cell], from: Cell, path: &mut Path) {
    path.restart(from);
    for (&from, &to) in turns.iter().zip(turns.iter().skip(1)) {
        line::steps(from, to).for_each(|step| path.step(step));
    }
}

impl Planner for Swarm<'_> {
    type Workspace = Workspace;

    /// A path that can be walked with [`crate::moves::MoveSet::Eight`], not promised to be the shortest;
    /// `expanded` counts the paths that were tried.
    fn plan<'w>(&self, from: Cell, to: Cell, workspace: &'w mut Workspace) -> Result<Plan<'w>, SearchError> {
        let Hunt { path, tried, .. } = self.hunt(from, to, workspace)?;
        Ok(Plan { path, expanded: tried })
    }
}
