//! Maps drawn to the text. The paper's own are lost with its figures; it prints their sizes and the density
//! of their obstacles.

use planning::{
    grid::{Cell, Grid},
    moves::MoveSet,
    search::{AStar, Planner, SearchError, Workspace},
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// What the paper's robot does: steps to the surrounding eight cells.
pub const MOVES: MoveSet = MoveSet::Eight;

/// A map and the way across it.
pub struct Drawn {
    pub grid: Grid,
    pub from: Cell,
    pub to: Cell,
}

/// A map of `width` by `height` cells with so many of them blocked, and the way from its top left to its bottom
/// right cell.
///
/// Cells are blocked in an order that the seed shuffles. One that would part start and goal is left free, so
/// that there is a way at every density: at 1/2 and 2/3 chance alone leaves none.
pub fn drawn(width: u32, height: u32, blocked: u32, seed: u64) -> Result<Drawn, SearchError> {
    let outside = SearchError::Outside { cell: Cell::default(), width, height };
    let mut grid = Grid::blocked(width, height).map_err(|_| outside)?;
    let mut cells: Vec<Cell> = (0..grid.len()).map(|index| grid.cell(index)).collect();
    cells.iter().for_each(|&cell| grid.set(cell, true));
    let from = Cell { x: 0, y: 0 };
    let to = Cell { x: width as i32 - 1, y: height as i32 - 1 };
    let mut workspace = Workspace::default();
    let mut path = AStar::new(&grid, MOVES).plan(from, to, &mut workspace)?.path.clone();
    let mut chance = Pcg64Mcg::seed_from_u64(seed);
    let mut left = blocked;
    while left > 0 && !cells.is_empty() {
        let drawn = chance.random_range(0..cells.len() as u32);
        let cell = cells.swap_remove(drawn as usize);
        if cell == from || cell == to {
            continue;
        }
        grid.set(cell, false);
        if !path.is_walkable(&grid, MOVES) {
            let Ok(plan) = AStar::new(&grid, MOVES).plan(from, to, &mut workspace) else {
                grid.set(cell, true);
                continue;
            };
            path = plan.path.clone();
        }
        left -= 1;
    }
    Ok(Drawn { grid, from, to })
}
