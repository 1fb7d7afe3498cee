//! How a map is divided into rooms, and what comes of it.

use planning::{
    floor_plan::{Layout, PlaceKind},
    grid::Cell,
    rooms::Rooms,
    segment::{self, Options},
};

/// What counts as a door, a room or an obstacle.
#[derive(clap::Args)]
pub struct Division {
    /// The widest opening that is a door [default: 1.6 m; 10 cells for MovingAI maps]
    #[arg(long, value_name = "METRES", value_parser = super::super::non_negative)]
    door_width: Option<f64>,
    /// The smallest room [default: 2 square metres; 30 cells for MovingAI maps]
    #[arg(long, value_name = "SQUARE METRES", value_parser = super::super::non_negative)]
    room_area: Option<f64>,
    /// The largest obstacle that is looked through [default: 0.5 square metres; 16 cells for MovingAI maps]
    #[arg(long, value_name = "SQUARE METRES", value_parser = super::super::non_negative)]
    clutter: Option<f64>,
}

impl Division {
    /// The rooms of a map; the doors that it names are doors.
    pub fn rooms(&self, layout: &Layout) -> Rooms {
        let resolution_m = layout.frame.resolution_m;
        // A map whose cells are longer than a door is wide is counted in cells.
        let coarse = resolution_m >= 1.0;
        let cells = |asked: Option<f64>, metres: f64, cells: f64, cell: f64| {
            // `as` saturates.
            asked.map_or(if coarse { cells } else { metres / cell }, |asked| asked / cell).round() as u32
        };
        let area = resolution_m * resolution_m;
        let options = Options {
            door_width: cells(self.door_width, 1.6, 10.0, resolution_m),
            room_area: cells(self.room_area, 2.0, 30.0, area),
            clutter_area: cells(self.clutter, 0.5, 16.0, area),
            reach: host_coordinator::site::door_reach(resolution_m),
        };
        let doorways: Vec<_> = layout.doors.iter().map(|door| line(layout, door.ends_m)).collect();
        segment::segment(&layout.grid, options, &doorways)
    }
}

/// The cells between two ends, so that no straight move passes between them.
fn line(layout: &Layout, [from, to]: [[f64; 2]; 2]) -> Vec<Cell> {
    let resolution_m = layout.frame.resolution_m;
    let length = (from[0] - to[0]).hypot(from[1] - to[1]);
    // A wall's end may be thicker than the door's.
    let over = 3.0 * resolution_m / length.max(resolution_m);
    let steps = (length / resolution_m * 4.0).min(100_000.0) as i32;
    let at = |step: i32| {
        let part = -over + f64::from(step) / f64::from(steps.max(1)) * (1.0 + 2.0 * over);
        layout.frame.cell_at([from[0] + part * (to[0] - from[0]), from[1] + part * (to[1] - from[1])])
    };
    let mut cells: Vec<Cell> = (0..=steps).map(at).collect();
    cells.dedup();
    cells
}

/// A pile on a free cell.
pub struct Pile {
    pub name: String,
    pub cell: Cell,
}

/// The piles of a map, each on the free cell nearest to it, and the names of those that have none
/// within a metre, or only one that another pile is on.
pub fn piles(layout: &Layout) -> (Vec<Pile>, Vec<String>) {
    let (mut piles, mut lost): (Vec<Pile>, _) = (Vec::new(), Vec::new());
    for place in layout.places.iter().filter(|place| place.kind == PlaceKind::Pile) {
        let reach_m = 1.0_f64.max(1.5 * layout.frame.resolution_m);
        let cell = layout.frame.free_cell_near(&layout.grid, place.at_m, reach_m);
        match cell.filter(|cell| piles.iter().all(|pile| pile.cell != *cell)) {
            Some(cell) => piles.push(Pile { name: place.name.clone(), cell }),
            None => lost.push(place.name.clone()),
        }
    }
    (piles, lost)
}
