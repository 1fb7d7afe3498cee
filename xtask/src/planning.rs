//! How long planners take, and whether what they find is optimal: runs the benchmark of `planning`.

use std::path::Path;

use crate::command::{Command, Failure, cargo};

/// Measures planners on the maps in a folder, or on those in the repository.
pub fn bench(maps: Option<&Path>, json: bool) -> Result<(), Failure> {
    let mut bench = benchmark();
    if let Some(maps) = maps {
        // Relative to where we were called; cargo runs elsewhere.
        let absolute = std::path::absolute(maps).map_err(|error| {
            Failure::new(format!("{} is no folder: {error}", maps.display()), "name another with --maps")
        })?;
        bench = bench.args(["--maps".to_owned(), absolute.to_string_lossy().into_owned()]);
    }
    if json { bench.args(["--json"]).run() } else { bench.run() }
}

/// Every length of every optimal planner on the maps in the repository: all queries, some minutes.
pub fn check() -> Command {
    benchmark().args(["--check"])
}

fn benchmark() -> Command {
    cargo("bench --quiet --package planning --bench planning --")
}
