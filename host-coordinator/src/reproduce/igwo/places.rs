//! Where IGWO's experiments happen. All its maps are lost: these are drawn to its text.

use planning::{
    grid::{Cell, Grid},
    parking::{CellSize, Lot},
};

/// A map with a task on it.
#[derive(Clone, Debug)]
pub struct Place {
    pub name: String,
    pub grid: Grid,
    pub from: Cell,
    pub to: Cell,
    pub metres_per_cell: f64,
}

/// Test maps 1 to 4 (Fig. 5), from corner to corner. The printed differences give IGWO's lengths: 20.6, 22.2,
/// 21.5 and 23.0 m. A square of 12 cells of 1.3 m, 20.2 m across, fits them; its obstacles are ours.
const TEST_MAPS: [[&str; 12]; 4] = [
    [
        "............",
        "............",
        "............",
        "............",
        "....@@@.....",
        "....@@@.....",
        "....@@@.....",
        "............",
        "............",
        "............",
        "............",
        "............",
    ],
    [
        "............",
        "............",
        "............",
        "@@@@@.......",
        "............",
        "............",
        "............",
        "............",
        ".......@@@@@",
        "............",
        "............",
        "............",
    ],
    [
        "............",
        "............",
        "..@@@....@@.",
        "..@@@....@@.",
        "............",
        ".....@@@....",
        ".....@@@....",
        ".@@.........",
        ".@@......@@.",
        ".....@@..@@.",
        ".....@@.....",
        "............",
    ],
    [
        "............",
        "............",
        "............",
        "........@...",
        "........@...",
        "........@...",
        "........@...",
        "........@...",
        "...@@@@@@...",
        "............",
        "............",
        "............",
    ],
];

/// Test maps 1 to 4.
pub fn test_maps() -> impl Iterator<Item = Place> {
    (1..).zip(TEST_MAPS).map(|(number, rows)| {
        let mut grid = Grid::open(12, 12);
        let cells =
            (0..).zip(rows).flat_map(|(y, row)| (0..).zip(row.bytes()).map(move |(x, cell)| (x, y, cell)));
        cells.filter(|&(.., cell)| cell == b'@').for_each(|(x, y, _)| grid.set(Cell { x, y }, false));
        let name = format!("test map {number}");
        Place { name, grid, from: Cell { x: 0, y: 0 }, to: Cell { x: 11, y: 11 }, metres_per_cell: 1.3 }
    })
}

/// How many of the 49 spaces of lots 1 to 4 have a car: half to nine tenths. The lot's number is its seed.
const CARS: [u8; 4] = [25, 31, 37, 43];

/// Parking lots 1 to 4 (Fig. 6) with the cell size that IGWO chooses: the robot is called to the last car, which is the farthest or next to it.
pub fn parking_lots() -> impl Iterator<Item = Place> {
    lots(CellSize::M1_30)
}

/// The same with cells of another size.
pub fn lots(size: CellSize) -> impl Iterator<Item = Place> {
    (1u8..).zip(CARS).map(move |(number, cars)| {
        let lot = Lot::parked(size, cars, number.into());
        let to = lot.cars().last().map_or(lot.cabin(), |&car| lot.stop(car));
        let name = format!("parking lot {number}");
        Place { name, grid: lot.grid().clone(), from: lot.cabin(), to, metres_per_cell: size.metres() }
    })
}
