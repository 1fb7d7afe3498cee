//! The map as the dashboard draws it: what does not change while the coordinator runs.

use std::collections::BTreeMap;

use planning::{grid::Cell, rooms::DoorId};
use serde::Serialize;

use crate::site::Site;

/// The map and its doors.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SiteView {
    /// What people call the site.
    pub name: String,
    /// Cells from left to right.
    pub width: u32,
    /// Cells from top to bottom.
    pub height: u32,
    /// The length of a cell in metres.
    pub resolution_m: f64,
    /// How the site's people count cells.
    pub frame: FrameView,
    /// Blocked cells: x and y of the first of a row's run, and how many.
    pub walls: Vec<[u32; 3]>,
    /// The subareas.
    pub subareas: Vec<SubareaView>,
    /// The doors between them.
    pub doors: Vec<DoorView>,
}

/// How the site's people count cells.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FrameView {
    /// The number of the first cell.
    pub origin: i32,
    /// Whether y grows upwards.
    pub y_up: bool,
}

/// A subarea.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SubareaView {
    /// Its name.
    pub name: String,
    /// A cell of it near its middle, for its label.
    pub at: [i32; 2],
}

/// A door.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DoorView {
    /// Its number.
    pub id: u16,
    /// Its cell.
    pub at: [i32; 2],
    /// The subareas it joins.
    pub joins: [String; 2],
    /// How often robots meet obstacles there, 0 to 1 (LMPP's rho, eq. 11).
    pub congestion: f64,
    /// Whether ways may lead through it.
    pub open: bool,
}

impl SiteView {
    /// Draws `site`, with the doors that `is_open` says are.
    #[must_use]
    pub fn new(site: &Site, is_open: impl Fn(DoorId) -> bool) -> Self {
        let subareas = site.rooms.subareas();
        let name = |id| subareas.name(id).map(String::from).unwrap_or_default();
        let doors = site.rooms.doors().iter().zip(&site.congestion).map(|(door, (_, congestion))| DoorView {
            id: door.id.0,
            at: [door.cell.x, door.cell.y],
            joins: door.joins.map(name),
            congestion: *congestion,
            open: is_open(door.id),
        });
        Self {
            name: site.name.clone(),
            width: site.grid.width(),
            height: site.grid.height(),
            resolution_m: site.resolution_m,
            frame: FrameView { origin: site.frame.origin, y_up: site.frame.y_up },
            walls: walls(site),
            subareas: labels(site),
            doors: doors.collect(),
        }
    }
}

fn walls(site: &Site) -> Vec<[u32; 3]> {
    let blocked = |x: u32, y: u32| !site.grid.is_free(Cell { x: x as i32, y: y as i32 });
    let mut walls: Vec<[u32; 3]> = Vec::new();
    for y in 0..site.grid.height() {
        for x in (0..site.grid.width()).filter(|x| blocked(*x, y)) {
            match walls.last_mut() {
                Some([first, row, length]) if *row == y && *first + *length == x => *length += 1,
                _ => walls.push([x, y, 1]),
            }
        }
    }
    walls
}

/// How many cells around a label should be the subarea's own, so that it is not written on a wall.
const LABEL_ROOM: i32 = 4;

/// Every subarea's label goes on its cell that is nearest to the mean of its cells, which itself
/// may lie outside a crooked room, and has room around it if any has.
fn labels(site: &Site) -> Vec<SubareaView> {
    let mut cells: BTreeMap<_, Vec<Cell>> = BTreeMap::new();
    for cell in site.grid.free_cells() {
        if let Some(subarea) = site.rooms.find_subarea(cell) {
            cells.entry(subarea).or_default().push(cell);
        }
    }
    let label = |(id, name)| {
        let mut cells = cells.get(&id)?.clone();
        let mean = |of: fn(&Cell) -> i32| {
            cells.iter().map(|cell| f64::from(of(cell))).sum::<f64>() / cells.len() as f64
        };
        let (x, y) = (mean(|cell| cell.x), mean(|cell| cell.y));
        let distance = |cell: &Cell| (f64::from(cell.x) - x).hypot(f64::from(cell.y) - y);
        cells.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        let side = -LABEL_ROOM..=LABEL_ROOM;
        let has_room = |cell: &&Cell| {
            let own = |x, y| site.rooms.find_subarea(Cell { x, y }) == Some(id);
            side.clone().all(|dy| side.clone().all(|dx| own(cell.x + dx, cell.y + dy)))
        };
        let at = cells.iter().find(has_room).or(cells.first())?;
        Some(SubareaView { name: String::from(name), at: [at.x, at.y] })
    };
    site.rooms.subareas().iter().filter_map(label).collect()
}
