//! What A* and the improved A* take on a map, measured in this run.

use std::{hint::black_box, time::Instant};

use planning::{
    grid::{Cell, Grid},
    rrt::{ImprovedAStar, ImprovedWorkspace, Rrt},
    search::{AStar, Jps, Planner, SearchError, Workspace},
};

use super::maps::{Drawn, MOVES, drawn};

/// Each time is the median of so many runs.
const RUNS: usize = 7;
/// Maps of a kind, each from its own seed.
pub const MAPS: u64 = 51;

/// What a planner took.
#[derive(Clone, Copy, Debug)]
pub struct Cost {
    pub micros: f64,
    pub nodes: f64,
    /// In cells.
    pub length: f64,
}

/// The improved A* (I), then A* (II), as the tables name them.
pub type Pair = [Cost; 2];

/// The improved A* of the paper: jump point search between a tree's necessary nodes.
pub fn improved(grid: &Grid, seed: u64) -> ImprovedAStar<'_, Jps> {
    ImprovedAStar::new(grid, Jps::new(grid.clone(), MOVES), Rrt::PAPER, seed)
}

/// Plans one way by both, and counts the nodes of the tree.
pub fn measure(grid: &Grid, from: Cell, to: Cell, seed: u64) -> Result<(Pair, usize), SearchError> {
    let mut workspace = ImprovedWorkspace::default();
    let one = cost(&improved(grid, seed), from, to, &mut workspace)?;
    let other = cost(&AStar::new(grid, MOVES), from, to, &mut Workspace::default())?;
    Ok(([one, other], workspace.tree().len()))
}

fn cost<P: Planner>(
    planner: &P,
    from: Cell,
    to: Cell,
    workspace: &mut P::Workspace,
) -> Result<Cost, SearchError> {
    let plan = planner.plan(from, to, workspace)?;
    let (nodes, length) = (f64::from(plan.expanded), plan.path.length().units());
    let mut micros = Vec::new();
    for _ in 0..RUNS {
        let start = Instant::now();
        black_box(planner.plan(from, to, workspace)?);
        micros.push(start.elapsed().as_nanos() as f64 / 1000.0);
    }
    Ok(Cost { micros: median(micros), nodes, length })
}

/// Medians over maps of one kind.
#[derive(Clone, Copy, Debug)]
pub struct Medians {
    pub costs: Pair,
    pub tree: f64,
    /// Of each map's ratio, I to II.
    pub time_ratio: f64,
    pub node_ratio: f64,
    pub length_ratio: f64,
}

/// Medians over [`MAPS`] maps of so many columns and rows with such a share blocked.
pub fn medians((width, height): (u32, u32), (some, of): (u32, u32)) -> Result<Medians, SearchError> {
    let mut pairs = Vec::new();
    let mut trees = Vec::new();
    for seed in 0..MAPS {
        let Drawn { grid, from, to } = drawn(width, height, width * height * some / of, seed)?;
        let (pair, tree) = measure(&grid, from, to, seed)?;
        pairs.push(pair);
        trees.push(tree as f64);
    }
    let over = |value: fn(&Pair) -> f64| median(pairs.iter().map(value).collect());
    let costs = [
        Cost {
            micros: over(|[i, _]| i.micros),
            nodes: over(|[i, _]| i.nodes),
            length: over(|[i, _]| i.length),
        },
        Cost {
            micros: over(|[_, a]| a.micros),
            nodes: over(|[_, a]| a.nodes),
            length: over(|[_, a]| a.length),
        },
    ];
    Ok(Medians {
        costs,
        tree: median(trees),
        time_ratio: over(|[i, a]| i.micros / a.micros),
        node_ratio: over(|[i, a]| i.nodes / a.nodes),
        length_ratio: over(|[i, a]| i.length / a.length),
    })
}

/// The middle of some numbers; 0 of none.
fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers.get(numbers.len() / 2).copied().unwrap_or_default()
}
