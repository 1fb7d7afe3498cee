//! `chargehand plan`: a path from here to there.

use std::{path::PathBuf, time::Instant};

use host_coordinator::site::{Site, SiteFrame};
use planning::{
    grid::{Cell, Grid},
    moves::MoveSet,
    path::Path,
    rooms::DoorId,
    search::{AStar, Planner as _, SearchError, Workspace},
};
use serde::Serialize;

use super::{Outcome, map, out, out_json, point::Point};

/// Plan a path on a site or on a bare map
#[derive(clap::Args)]
pub struct Plan {
    #[command(flatten)]
    place: Place,
    /// Where the path starts, in the site's coordinates; on a bare map from 0, y down
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true)]
    from: Point,
    /// Where it ends; for lmpp the place of a pile
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true)]
    to: Point,
    /// How it is planned: astar searches, lmpp recalls paths between doors and piles
    #[arg(long, value_enum, default_value_t = Planner::Astar)]
    planner: Planner,
    /// Moves from a cell: 8 or 16; the site's own if left out, 8 on a bare map
    #[arg(long, value_parser = neighbours)]
    neighbours: Option<MoveSet>,
    /// Avoid doors more congested than this; from 1 on none (lmpp only)
    #[arg(long, value_name = "F", value_parser = super::non_negative)]
    theta: Option<f64>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

#[derive(clap::Args)]
#[group(required = true, multiple = false)]
struct Place {
    /// The folder of a site
    #[arg(long, value_name = "DIR")]
    site: Option<PathBuf>,
    /// A MovingAI octile map
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Planner {
    Astar,
    Lmpp,
}

fn neighbours(text: &str) -> Result<MoveSet, String> {
    match text {
        "8" => Ok(MoveSet::Eight),
        "16" => Ok(MoveSet::Sixteen),
        _ => Err("expected 8 or 16".into()),
    }
}

/// Why there is no plan.
#[derive(Debug, thiserror::Error)]
enum NoPlan {
    #[error("{point} is a wall: give a free cell")]
    Wall { point: Point },
    #[error("no path leads from {from} to {to}: walls part them; give two cells of one region")]
    Parted { from: Point, to: Point },
    #[error(
        "no chain of open doors leads from {from} to {to}: give --planner astar, which needs none, or a larger --theta"
    )]
    NoDoors { from: Point, to: Point },
    #[error(
        "no pile stands at {to}: lmpp recalls paths to piles; give the place of one, such as {example}, or --planner astar"
    )]
    NoPile { to: Point, example: Point },
    #[error(
        "lmpp needs the rooms, doors and piles of a site: give --site instead of --map, or --planner astar"
    )]
    BareMap,
    #[error("--theta closes doors, which astar does not know: give --planner lmpp or leave --theta out")]
    ThetaWithoutDoors,
}

/// A path, as programs read it.
#[derive(Serialize)]
struct Planned {
    /// In cells.
    length: f64,
    expanded: u32,
    micros: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    doors: Option<Vec<u16>>,
    path: Vec<(i32, i32)>,
    #[serde(skip)]
    turns: Vec<Point>,
}

impl Plan {
    pub fn run(self) -> Outcome {
        if self.planner == Planner::Astar && self.theta.is_some() {
            return Err(NoPlan::ThetaWithoutDoors.into());
        }
        let planned = match (&self.place.site, &self.place.map) {
            (Some(folder), _) => {
                let mut site = Site::load(folder)?;
                site.moves = self.neighbours.unwrap_or(site.moves);
                match self.planner {
                    Planner::Astar => self.search(&site.grid, site.frame, site.moves)?,
                    Planner::Lmpp => self.recall(&site)?,
                }
            }
            (None, Some(file)) if self.planner == Planner::Astar => {
                let moves = self.neighbours.unwrap_or(MoveSet::Eight);
                self.search(&map::read(file)?, SiteFrame::default(), moves)?
            }
            (None, _) => return Err(NoPlan::BareMap.into()),
        };
        if self.json { out_json(&planned) } else { out(&planned.text()) }
    }

    fn search(
        &self,
        grid: &Grid,
        frame: SiteFrame,
        moves: MoveSet,
    ) -> Result<Planned, Box<dyn std::error::Error>> {
        let (from, to) = (free_cell(grid, frame, self.from)?, free_cell(grid, frame, self.to)?);
        let mut workspace = Workspace::default();
        let start = Instant::now();
        let found = AStar::new(grid, moves).plan(from, to, &mut workspace);
        let micros = micros_since(start);
        let found = found.map_err(|error| self.parted(error))?;
        Ok(Planned::new(found.path, found.expanded, micros, None, |cell| frame.coordinates(grid, cell)))
    }

    fn recall(&self, site: &Site) -> Result<Planned, Box<dyn std::error::Error>> {
        let from = free_cell(&site.grid, site.frame, self.from)?;
        let to = free_cell(&site.grid, site.frame, self.to)?;
        let Some(pile) = site.piles.iter().find(|pile| pile.cell == to) else {
            let example = site.piles.first().map_or(self.to, |pile| Point::of(site.coordinates(pile.cell)));
            return Err(NoPlan::NoPile { to: self.to, example }.into());
        };
        // The memory is there before a robot asks, so it is not timed.
        let lmpp = site.lmpp(self.theta.unwrap_or(1.0));
        let start = Instant::now();
        let survey = lmpp.survey(from).map_err(|error| self.parted(error))?;
        let route = survey.route_to(pile.id.0);
        let micros = micros_since(start);
        let route = route.ok_or(NoPlan::NoDoors { from: self.from, to: self.to })?;
        let coordinates = |cell| site.coordinates(cell);
        Ok(Planned::new(&route.path, 0, micros, Some(&route.doors), coordinates))
    }

    /// A search's error in the coordinates that were given.
    fn parted(&self, error: SearchError) -> NoPlan {
        match error {
            SearchError::NoPath { .. } => NoPlan::Parted { from: self.from, to: self.to },
            // Both ends were checked; a closed door's cell may still be one of them.
            SearchError::Outside { .. } | SearchError::Blocked { .. } | SearchError::NoTarget { .. } => {
                NoPlan::Wall { point: self.from }
            }
        }
    }
}

/// The free cell at `point`.
pub fn free_cell(grid: &Grid, frame: SiteFrame, point: Point) -> Result<Cell, Box<dyn std::error::Error>> {
    let cell = frame.cell_at(grid, point.x, point.y)?;
    if grid.is_free(cell) { Ok(cell) } else { Err(NoPlan::Wall { point }.into()) }
}

fn micros_since(start: Instant) -> f64 {
    start.elapsed().as_nanos() as f64 / 1000.0
}

impl Planned {
    fn new(
        path: &Path,
        expanded: u32,
        micros: f64,
        doors: Option<&[DoorId]>,
        coordinates: impl Fn(Cell) -> (i32, i32),
    ) -> Self {
        Self {
            length: path.length().units(),
            expanded,
            micros,
            doors: doors.map(|doors| doors.iter().map(|door| door.0).collect()),
            path: path.cells().map(&coordinates).collect(),
            turns: path.waypoints().iter().map(|&cell| Point::of(coordinates(cell))).collect(),
        }
    }

    fn text(&self) -> String {
        let doors = match self.doors.as_deref() {
            None => String::new(),
            Some([]) => "\ndoors     none".into(),
            Some(doors) => {
                let doors: Vec<_> = doors.iter().map(u16::to_string).collect();
                format!("\ndoors     {}", doors.join(", "))
            }
        };
        let turns: Vec<_> = self.turns.iter().map(Point::to_string).collect();
        format!(
            "length    {:.3} cells\nexpanded  {} nodes\ntime      {:.1} us{doors}\npath      {}",
            self.length,
            self.expanded,
            self.micros,
            turns.join(" "),
        )
    }
}
