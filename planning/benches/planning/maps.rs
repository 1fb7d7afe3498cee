//! Maps with their queries, from a folder.

use std::fs;
use std::path::{Path, PathBuf};
use std::thread;

use planning::formats::{
    movingai::read_map,
    scen::{Query, read_scen},
};
use planning::grid::Grid;
use planning::moves::MoveSet;
use planning::search::{AStar, Planner, Workspace};

use crate::Failure;

/// A map and what is asked on it.
pub struct Map {
    /// The file's name without `.map`.
    pub name: String,
    pub grid: Grid,
    pub queries: Vec<Query>,
}

impl Map {
    /// At most `limit` of its queries, evenly spaced: their numbers and what is asked. With 16 neighbours the
    /// optimal lengths, of which scenarios have none, are those of A*.
    pub fn asked(&self, moves: MoveSet, limit: usize) -> Vec<(usize, Query)> {
        let numbers = spaced(self.queries.len(), limit);
        let mut asked: Vec<_> = numbers.map(|number| (number, self.queries[number].clone())).collect();
        if moves == MoveSet::Sixteen {
            let threads = thread::available_parallelism().map_or(1, usize::from);
            let share = asked.len().div_ceil(threads).max(1);
            thread::scope(|scope| {
                asked.chunks_mut(share).for_each(|share| drop(scope.spawn(|| self.measure_lengths(share))));
            });
        }
        asked
    }

    fn measure_lengths(&self, asked: &mut [(usize, Query)]) {
        let (planner, mut workspace) = (AStar::new(&self.grid, MoveSet::Sixteen), Workspace::default());
        for (_, query) in asked {
            let plan = planner.plan(query.from, query.to, &mut workspace);
            query.optimal = plan.map_or(f64::INFINITY, |plan| plan.path.length().units());
        }
    }
}

/// At most `limit` of the numbers below `count`, evenly spaced.
pub fn spaced(count: usize, limit: usize) -> impl Iterator<Item = usize> {
    let limit = limit.min(count);
    (0..limit).map(move |place| place * count / limit)
}

/// The maps in the repository.
pub fn default_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/bench")
}

/// Reads all maps in `folder`, by name.
pub fn read(folder: &Path) -> Result<Vec<Map>, Failure> {
    let unreadable = |error| {
        Failure(format!("{} cannot be read: {error}; name another folder with --maps", folder.display()))
    };
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder).map_err(unreadable)? {
        paths.push(entry.map_err(unreadable)?.path());
    }
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "map"));
    paths.sort();
    if paths.is_empty() {
        return Err(Failure(format!(
            "there is no .map in {}; name another folder with --maps",
            folder.display()
        )));
    }
    paths.iter().map(|path| read_one(path)).collect()
}

fn read_one(path: &Path) -> Result<Map, Failure> {
    let beside = [path.with_extension("map.scen"), path.with_extension("scen")];
    let scen = beside.iter().find(|scen| scen.exists()).ok_or_else(|| {
        Failure(format!("{} has no queries: put its .map.scen or .scen beside it", path.display()))
    })?;
    let grid = read_map(&text(path)?).map_err(|error| Failure(format!("{}: {error}", path.display())))?;
    let queries = read_scen(&text(scen)?).map_err(|error| Failure(format!("{}: {error}", scen.display())))?;
    if queries.is_empty() {
        return Err(Failure(format!("{} holds no query", scen.display())));
    }
    if let Some(other) =
        queries.iter().find(|query| (query.width, query.height) != (grid.width(), grid.height()))
    {
        return Err(Failure(format!(
            "{} is for a map of {} x {} cells, {} has {} x {}",
            scen.display(),
            other.width,
            other.height,
            path.display(),
            grid.width(),
            grid.height()
        )));
    }
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok(Map { name, grid, queries })
}

fn text(path: &Path) -> Result<String, Failure> {
    fs::read_to_string(path).map_err(|error| Failure(format!("{} cannot be read: {error}", path.display())))
}
