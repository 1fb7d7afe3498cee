//! A door closes and opens again under fields of known targets.

use planning::{
    grid::{Cell, Grid},
    memory::Fields,
    segment::{Options, segment},
};
use serde::Serialize;

use crate::clock::Clock;
use crate::statistics::{Summary, mean};

/// So many doors at most, evenly spaced.
const DOORS: usize = 100;
/// What `chargehand map segment` takes for cells of unknown size.
const OPTIONS: Options = Options { door_width: 10, room_area: 30, clutter_area: 16, reach: 5 };

/// What doors take, in microseconds.
#[derive(Debug, Serialize)]
pub struct DoorsReport {
    pub doors: usize,
    /// All fields after a door has closed.
    pub close: Summary,
    pub slowest_close: f64,
    /// And after it has opened again.
    pub open: Summary,
    /// All fields built anew with a door closed, on average.
    pub rebuild: f64,
}

/// Closes and opens every door that the map's rooms have; `None` if they have none.
pub fn measure(fields: &mut Fields) -> Option<DoorsReport> {
    let grid = fields.grid().clone();
    let rooms = segment(&grid, OPTIONS, &[]);
    let doors = rooms.doors();
    let step = doors.len().div_ceil(DOORS).max(1);
    let [mut close, mut open, mut rebuild] = [const { Vec::new() }; 3];
    for door in doors.iter().step_by(step) {
        let cells = doorway(&grid, door.cell);
        close.push(Clock::Thread.time(|| fields.change(cells.iter().map(|&cell| (cell, false)))).0);
        // Some of them only: it takes long, and always as long.
        if rebuild.len() < 5 {
            let (grid, targets) = (fields.grid().clone(), fields.targets().to_vec());
            rebuild.push(
                Clock::Thread.time(|| Fields::build(grid, planning::moves::MoveSet::Eight, &targets)).0,
            );
        }
        open.push(Clock::Thread.time(|| fields.change(cells.iter().map(|&cell| (cell, true)))).0);
    }
    (!close.is_empty()).then(|| DoorsReport {
        doors: close.len(),
        close: Summary::of(&close),
        slowest_close: close.iter().copied().fold(0.0, f64::max),
        open: Summary::of(&open),
        rebuild: mean(&rebuild),
    })
}

/// The free cells in line with `cell` from wall to wall, across or along, whichever are fewer.
fn doorway(grid: &Grid, cell: Cell) -> Vec<Cell> {
    let line = |dx: i32, dy: i32| {
        let side = |sign: i32| {
            (1..)
                .map(move |far| cell.offset(sign * far * dx, sign * far * dy))
                .take_while(|&cell| grid.is_free(cell))
        };
        side(-1).chain([cell]).chain(side(1)).collect::<Vec<_>>()
    };
    let (across, along) = (line(1, 0), line(0, 1));
    if across.len() <= along.len() { across } else { along }
}
