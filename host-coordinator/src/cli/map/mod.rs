//! `chargehand map`: look into a map of any usual kind, convert, divide or draw it.

mod input;
mod picture;
mod rooms;
mod write;

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use host_coordinator::diagnostics::Diagnostics;
use planning::{
    floor_plan::{Layout, PlaceKind},
    grid::Grid,
};
use serde::Serialize;
use serde_json::json;

use self::{
    input::{Input, Read},
    picture::MapPicture,
    rooms::Division,
};
use super::{Outcome, out, out_json};

/// Look into a map of MovingAI, ROS, Open-RMF or LIF; convert, divide or draw it
#[derive(clap::Args)]
pub struct Map {
    #[command(subcommand)]
    question: Question,
}

#[derive(clap::Subcommand)]
enum Question {
    /// Print a map's size, how much of it is free, how many parts walls divide it into, and what it names
    Info {
        #[command(flatten)]
        input: Input,
        /// Print JSON
        #[arg(long)]
        json: bool,
    },
    /// Write a map as another program reads it, or as a site
    Convert {
        #[command(flatten)]
        input: Input,
        /// A .map file (MovingAI), a .yaml file (ROS, with a .pgm beside it) or else a folder (a site)
        #[arg(long, value_name = "PATH")]
        to: PathBuf,
        #[command(flatten)]
        division: Division,
        /// Print JSON
        #[arg(long)]
        json: bool,
    },
    /// Divide a map into subareas with doors between them, and write both into a folder
    Segment {
        #[command(flatten)]
        input: Input,
        /// The folder for subareas.txt and doors.toml; nothing is written without it
        #[arg(long, value_name = "FOLDER")]
        to: Option<PathBuf>,
        #[command(flatten)]
        division: Division,
        /// Print JSON
        #[arg(long)]
        json: bool,
    },
    /// Draw a map: subareas in colours, doors red, piles green
    Render {
        #[command(flatten)]
        input: Input,
        /// The picture, a .png or an .svg file
        #[arg(long, value_name = "FILE")]
        to: PathBuf,
        #[command(flatten)]
        division: Division,
    },
}

#[derive(Serialize)]
struct Info {
    kind: &'static str,
    width: u32,
    height: u32,
    resolution_m: f64,
    /// Where the lower left corner is: x and y in metres, yaw in radians.
    origin: [f64; 3],
    free: usize,
    blocked: usize,
    /// Of the blocked cells, those that nobody has looked at.
    unknown: usize,
    /// Parts of the map between which no path leads.
    regions: usize,
    /// Free cells of the largest.
    largest_region: usize,
    piles: usize,
    doors: usize,
    lanes: usize,
    /// How long they are in all, in metres.
    lanes_m: f64,
    lifts: Vec<Stops>,
}

/// A lift that stops here, and where else.
#[derive(Serialize)]
struct Stops {
    name: String,
    storeys: Vec<String>,
}

impl Map {
    pub fn run(self) -> Outcome {
        match self.question {
            Question::Info { input, json } => info(&input, json),
            Question::Convert { input, to, division, json } => convert(&input, &to, &division, json),
            Question::Segment { input, to, division, json } => {
                segment(&input, to.as_deref(), &division, json)
            }
            Question::Render { input, to, division } => {
                let Read { layout, .. } = input.read()?;
                let (rooms, (piles, _)) = (division.rooms(&layout), rooms::piles(&layout));
                MapPicture { grid: &layout.grid, rooms: &rooms, piles: &piles }.write(&to)?;
                out(&format!("{} shows {}", to.display(), input.file().display()))
            }
        }
    }
}

fn info(input: &Input, json: bool) -> Outcome {
    let info = Info::of(&input.read()?);
    if json {
        return out_json(&info);
    }
    let Info { kind, width, height, resolution_m, origin: [x, y, yaw], .. } = info;
    let Info { free, blocked, unknown, regions, largest_region, piles, doors, lanes, lanes_m, .. } = info;
    let percent = |cells: usize| 100.0 * cells as f64 / (free + blocked).max(1) as f64;
    let mut text = format!(
        "{}: {width} x {height} cells\n\
         kind     {kind}\n\
         cells    of {resolution_m} m; the lower left corner is at ({x:.3}, {y:.3}) m, turned by {yaw:.3} rad\n\
         free     {free} ({:.1} %)\n\
         blocked  {blocked} ({:.1} %), {unknown} of them unknown\n\
         regions  {regions}, the largest of {largest_region} cells",
        input.file().display(),
        percent(free),
        percent(blocked),
    );
    if piles + doors + lanes > 0 {
        text += &format!("\nnames    {piles} piles, {doors} doors, {lanes} lanes of {lanes_m:.1} m");
    }
    for Stops { name, storeys } in &info.lifts {
        text += &format!("\nlift     {name} to {}", storeys.join(", "));
    }
    out(&text)
}

fn convert(input: &Input, to: &Path, division: &Division, json: bool) -> Outcome {
    let Read { layout, .. } = input.read()?;
    let extension = to.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let mut summary = json!({ "to": to, "width": layout.grid.width(), "height": layout.grid.height() });
    let said = match extension.as_str() {
        "map" => {
            write::moving_ai(to, &layout)?;
            "a MovingAI map".to_owned()
        }
        "yaml" | "yml" => {
            write::ros(to, &layout)?;
            "a ROS map".to_owned()
        }
        _ => {
            let (rooms, (piles, lost)) = (division.rooms(&layout), rooms::piles(&layout));
            let name = input.file().file_stem().unwrap_or_default().to_string_lossy();
            write::site(to, &name, &layout, &rooms, &piles)?;
            let subareas = rooms.subareas().iter().count();
            let counted = json!({ "subareas": subareas, "doors": rooms.doors().len(), "piles": piles.len(), "lost_piles": lost });
            summary
                .as_object_mut()
                .into_iter()
                .for_each(|all| all.extend(counted.as_object().cloned().into_iter().flatten()));
            let lost: String = lost
                .iter()
                .map(|name| format!("\npile {name:?} is near no free cell of its own: it is left out"))
                .collect();
            format!(
                "a site of {subareas} subareas, {} doors and {} piles{lost}",
                rooms.doors().len(),
                piles.len()
            )
        }
    };
    if json { out_json(&summary) } else { out(&format!("{} is {said}", to.display())) }
}

fn segment(input: &Input, to: Option<&Path>, division: &Division, json: bool) -> Outcome {
    let Read { layout, .. } = input.read()?;
    let rooms = division.rooms(&layout);
    if let Some(folder) = to {
        write::segmentation(folder, &rooms)?;
    }
    let mut cells = vec![0_usize; rooms.subareas().iter().count()];
    for subarea in layout.grid.free_cells().filter_map(|cell| rooms.find_subarea(cell)) {
        cells.get_mut(usize::from(subarea.0)).into_iter().for_each(|cells| *cells += 1);
    }
    let all: Vec<_> = rooms.subareas().iter().map(|(_, name)| name).zip(cells).collect();
    if json {
        let name = |id| rooms.subareas().name(id);
        let doors = rooms.doors().iter().map(|door| json!({ "id": door.id.0, "at": [door.cell.x, door.cell.y], "joins": door.joins.map(name) }));
        let subareas = all.iter().map(|(name, cells)| json!({ "name": name, "cells": cells }));
        return out_json(
            &json!({ "subareas": subareas.collect::<Vec<_>>(), "doors": doors.collect::<Vec<_>>() }),
        );
    }
    let list: String = all.iter().map(|(name, cells)| format!("\n{name}  {cells} cells")).collect();
    out(&format!("{}: {} subareas, {} doors{list}", input.file().display(), all.len(), rooms.doors().len()))
}

/// Reads the MovingAI map in `file`.
pub fn read(file: &Path) -> Result<Grid, Diagnostics> {
    parse(file, fs::read_to_string(file))
}

fn parse(file: &Path, text: io::Result<String>) -> Result<Grid, Diagnostics> {
    host_coordinator::site::read_map(file, text).map_err(|mistake| Diagnostics::one(file, mistake))
}

impl Info {
    fn of(Read { kind, layout }: &Read) -> Self {
        let Layout { grid, frame, unknown, places, doors, lanes, lifts } = layout;
        let [x, y] = frame.origin_m;
        let free = grid.free_cells().count();
        let regions = regions(grid);
        Self {
            kind,
            width: grid.width(),
            height: grid.height(),
            resolution_m: frame.resolution_m,
            origin: [x, y, frame.yaw_rad],
            free,
            blocked: grid.len() - free,
            regions: regions.len(),
            largest_region: regions.into_iter().max().unwrap_or(0),
            unknown: *unknown,
            piles: places.iter().filter(|place| place.kind == PlaceKind::Pile).count(),
            doors: doors.len(),
            lanes: lanes.len(),
            lanes_m: lanes.iter().fold(0.0, |sum, lane| sum + lane.length_m(places)),
            lifts: lifts
                .iter()
                .map(|lift| Stops { name: lift.name.clone(), storeys: lift.storeys.clone() })
                .collect(),
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
