//! A door closes and opens again under fields of known targets.

use planning::{
    grid::{Cell, Grid},
    memory::Fields,
    moves::MoveSet,
};
use serde::Serialize;

use crate::clock::Clock;
use crate::statistics::{Summary, mean};

/// So many doors at most, evenly spaced.
const DOORS: usize = 100;
/// The widest, in cells.
const WIDTH: usize = 10;

/// What doors take, in microseconds.
#[derive(Debug, Serialize)]
pub struct DoorsReport {
    pub doors: usize,
    /// All fields after a cell in a door's middle is blocked, which leaves the rest of it.
    pub narrow: Summary,
    /// All fields after a door has closed.
    pub close: Summary,
    pub slowest_close: f64,
    /// And after it has opened again.
    pub open: Summary,
    /// All fields built anew with a door closed, on average.
    pub rebuild: f64,
}

/// Closes and opens doors; `None` if the map has none.
pub fn measure(fields: &mut Fields) -> Option<DoorsReport> {
    let grid = fields.grid().clone();
    let doorways = doorways(&grid);
    let step = doorways.len().div_ceil(DOORS).max(1);
    let [mut narrow, mut close, mut open, mut rebuild] = [const { Vec::new() }; 4];
    for cells in doorways.iter().step_by(step) {
        let middle = cells.get(cells.len() / 2).copied().unwrap_or_default();
        narrow.push(Clock::Thread.time(|| fields.change([(middle, false)])).0);
        fields.change([(middle, true)]);
        close.push(Clock::Thread.time(|| fields.change(cells.iter().map(|&cell| (cell, false)))).0);
        // Some of them only: it takes long, and always as long.
        if rebuild.len() < 5 {
            let (grid, targets) = (fields.grid().clone(), fields.targets().to_vec());
            rebuild.push(Clock::Thread.time(|| Fields::build(grid, MoveSet::Eight, &targets)).0);
        }
        open.push(Clock::Thread.time(|| fields.change(cells.iter().map(|&cell| (cell, true)))).0);
    }
    (!close.is_empty()).then(|| DoorsReport {
        doors: close.len(),
        narrow: Summary::of(&narrow),
        close: Summary::of(&close),
        slowest_close: close.iter().copied().fold(0.0, f64::max),
        open: Summary::of(&open),
        rebuild: mean(&rebuild),
    })
}

/// Gaps in walls that are one cell thick, each by its cells.
fn doorways(grid: &Grid) -> Vec<Vec<Cell>> {
    let along = [((1, 0), (0, 1)), ((0, 1), (1, 0))];
    along
        .into_iter()
        .flat_map(|(along, across)| {
            grid.free_cells().filter_map(move |cell| doorway(grid, cell, along, across))
        })
        .collect()
}

/// The gap that begins at `cell`, in a wall along `(dx, dy)`.
fn doorway(grid: &Grid, cell: Cell, (dx, dy): (i32, i32), (ax, ay): (i32, i32)) -> Option<Vec<Cell>> {
    let at = |far: i32| cell.offset(far * dx, far * dy);
    let cells: Vec<Cell> = (0..).map(at).take_while(|&cell| grid.is_free(cell)).take(WIDTH + 1).collect();
    let end = cells.len() as i32;
    let is_free = |cell: Cell| grid.is_free(cell.offset(ax, ay)) && grid.is_free(cell.offset(-ax, -ay));
    // Two cells of wall at either end, which are free on both sides as the gap is.
    let is_wall = |far| !grid.is_free(at(far)) && is_free(at(far));
    let is_door = cells.len() <= WIDTH
        && [-2, -1, end, end + 1].into_iter().all(is_wall)
        && cells.iter().all(|&cell| is_free(cell));
    is_door.then_some(cells)
}
