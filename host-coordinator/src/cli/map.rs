//! `chargehand map`: what is in a map file?

use std::{
    fs,
    path::{Path, PathBuf},
};

use host_coordinator::diagnostics::Diagnostics;
use planning::grid::Grid;
use serde::Serialize;

use super::{Outcome, out, out_json};

/// Look into a MovingAI octile map
#[derive(clap::Args)]
pub struct Map {
    #[command(subcommand)]
    question: Question,
}

#[derive(clap::Subcommand)]
enum Question {
    /// Print a map's size, how much of it is free and how many parts walls divide it into
    Info {
        /// The map
        file: PathBuf,
        /// Print JSON
        #[arg(long)]
        json: bool,
    },
}

#[derive(Serialize)]
struct Info {
    width: u32,
    height: u32,
    free: usize,
    blocked: usize,
    /// Parts of the map between which no path leads.
    regions: usize,
    /// Free cells of the largest.
    largest_region: usize,
}

impl Map {
    pub fn run(self) -> Outcome {
        let Question::Info { file, json } = self.question;
        let info = Info::of(&read(&file)?);
        if json {
            return out_json(&info);
        }
        let Info { width, height, free, blocked, regions, largest_region } = info;
        let percent = |cells: usize| 100.0 * cells as f64 / (free + blocked).max(1) as f64;
        out(&format!(
            "{}: {width} x {height} cells\n\
             free     {free} ({:.1} %)\n\
             blocked  {blocked} ({:.1} %)\n\
             regions  {regions}, the largest of {largest_region} cells",
            file.display(),
            percent(free),
            percent(blocked),
        ))
    }
}

/// Reads the map in `file`.
pub fn read(file: &Path) -> Result<Grid, Diagnostics> {
    let read = host_coordinator::site::read_map(file, fs::read_to_string(file));
    read.map_err(|mistake| Diagnostics::one(file, mistake))
}

impl Info {
    fn of(grid: &Grid) -> Self {
        let free = grid.free_cells().count();
        let regions = regions(grid);
        Self {
            width: grid.width(),
            height: grid.height(),
            free,
            blocked: grid.len() - free,
            regions: regions.len(),
            largest_region: regions.into_iter().max().unwrap_or(0),
        }
    }
}

/// How many cells each region has. Straight moves tell: by the corner rule no other move passes
/// where they do not.
fn regions(grid: &Grid) -> Vec<usize> {
    let mut unseen = grid.clone();
    let mut regions = Vec::new();
    for start in grid.free_cells() {
        let mut size = 0;
        let mut open = vec![start];
        while let Some(cell) = open.pop() {
            if unseen.is_free(cell) {
                unseen.set(cell, false);
                size += 1;
                open.extend([(1, 0), (-1, 0), (0, 1), (0, -1)].map(|(dx, dy)| cell.offset(dx, dy)));
            }
        }
        if size > 0 {
            regions.push(size);
        }
    }
    regions
}
