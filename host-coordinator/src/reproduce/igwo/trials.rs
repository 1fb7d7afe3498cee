//! Twenty runs of one planner in one place.

use planning::{
    grid::Cell,
    moves::MoveSet,
    search::{self, AStar, Planner, SearchError},
    swarm::{Algorithm, Settings, Swarm, Workspace},
};

use super::places::Place;

/// How many runs each figure is taken from; run 1 has seed 1.
pub const RUNS: u64 = 20;
/// How many particles PSO has.
pub const PARTICLES: u16 = 20;

/// What the runs gave.
#[derive(Clone, Debug, Default)]
pub struct Trials {
    iterations: Vec<f64>,
    lengths_m: Vec<f64>,
    /// The turns of the shortest path.
    pub best: Vec<Cell>,
    /// After each iteration the mean of the best fitness so far, as a multiple of its last value.
    pub curve: Vec<f64>,
}

impl Trials {
    /// Runs a planner, with its population of the paper.
    pub fn run(place: &Place, algorithm: Algorithm) -> Result<Self, SearchError> {
        let mut trials = Self::default();
        let mut workspace = Workspace::default();
        for seed in 1..=RUNS {
            let swarm = Swarm { grid: &place.grid, algorithm, settings: settings(algorithm), seed };
            let hunt = swarm.hunt(place.from, place.to, &mut workspace)?;
            let length_m = hunt.length_cells * place.metres_per_cell;
            if trials.lengths_m.iter().all(|&length| length_m < length) {
                trials.best = hunt.turns.to_vec();
            }
            trials.iterations.push(hunt.iterations().into());
            trials.lengths_m.push(length_m);
            let last = hunt.curve.last().copied().unwrap_or(1.0);
            trials.curve.resize(hunt.curve.len(), 0.0);
            for (mean, fitness) in trials.curve.iter_mut().zip(hunt.curve) {
                *mean += fitness / last / RUNS as f64;
            }
        }
        Ok(trials)
    }

    pub fn mean_iterations(&self) -> f64 {
        mean(&self.iterations)
    }

    pub fn best_iterations(&self) -> f64 {
        self.iterations.iter().copied().fold(f64::INFINITY, f64::min)
    }

    pub fn mean_length_m(&self) -> f64 {
        mean(&self.lengths_m)
    }

    pub fn best_length_m(&self) -> f64 {
        self.lengths_m.iter().copied().fold(f64::INFINITY, f64::min)
    }
}

/// The settings of a planner.
pub fn settings(algorithm: Algorithm) -> Settings {
    let settings = Settings::default();
    match algorithm {
        Algorithm::Pso => {
            Settings { population: PARTICLES.try_into().unwrap_or(settings.population), ..settings }
        }
        Algorithm::Gwo | Algorithm::Igwo { .. } => settings,
    }
}

pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The path of A\* with 8 neighbours and its length in metres.
pub fn astar(place: &Place) -> Result<(Vec<Cell>, f64), SearchError> {
    let mut workspace = search::Workspace::default();
    let path = AStar::new(&place.grid, MoveSet::Eight).plan(place.from, place.to, &mut workspace)?.path;
    Ok((path.waypoints().to_vec(), path.length().units() * place.metres_per_cell))
}
