//! The parking lot of IGWO, section 2: 49 spaces in 6 areas, cars at random.
//!
//! The drawing of the lot (Fig. 2) is lost. Rebuilt from the text: 26 m by 39 m, which is 10 x 15 cells
//! of 2.6 m; a space is one of these wide and two long, so that 52 of the 150 are left for lanes, which
//! just suffices for two lanes along, one across and one at each end. The cabin of the charging
//! robot is in the upper left corner. Which space is where is ours.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::grid::{Cell, Grid};

/// How many spaces there are.
pub const SPACES: usize = 49;

/// Rows of spaces: how many cells of 2.6 m the first is from the upper edge, where the lane before it
/// is, and the area of each column's space.
const ROWS: [(u8, u8, &str); 4] = [
    (0, 2, ".AAAAAA.BBBBBBB"),
    (3, 2, ".CCCCCC.DDDDDD."),
    (5, 7, ".CCCCCC.DDDDDD."),
    (8, 7, ".EEEEEE.FFFFFF."),
];
/// Columns and rows, in cells of 2.6 m.
const COLUMNS_AND_ROWS: [u16; 2] = [15, 10];

/// How large the cells of a lot's map are (IGWO, 2.1.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CellSize {
    /// 2.6 m: 10 x 15 cells.
    M2_60,
    /// 1.3 m: 20 x 30 cells; what IGWO chooses.
    M1_30,
    /// 0.65 m: 40 x 60 cells.
    M0_65,
}

impl CellSize {
    /// All, the largest first.
    pub const ALL: [Self; 3] = [Self::M2_60, Self::M1_30, Self::M0_65];

    /// The side of a cell, in metres.
    #[must_use]
    pub const fn metres(self) -> f64 {
        match self {
            Self::M2_60 => 2.6,
            Self::M1_30 => 1.3,
            Self::M0_65 => 0.65,
        }
    }

    /// Cells along 2.6 m.
    const fn division(self) -> u16 {
        match self {
            Self::M2_60 => 1,
            Self::M1_30 => 2,
            Self::M0_65 => 4,
        }
    }
}

/// One parking space of the lot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Space {
    area: char,
    column: u8,
    top: u8,
    lane: u8,
}

impl Space {
    /// The area it is in, A to F.
    #[must_use]
    pub const fn area(self) -> char {
        self.area
    }
}

/// The spaces of the lot, area by area in rows from the upper left.
pub fn spaces() -> impl Iterator<Item = Space> {
    ROWS.into_iter().flat_map(|(top, lane, areas)| {
        let columns = (0u8..).zip(areas.chars()).filter(|&(_, area)| area != '.');
        columns.map(move |(column, area)| Space { area, column, top, lane })
    })
}

/// A lot with cars on some spaces; a space without a car can be driven over.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lot {
    size: CellSize,
    cars: Vec<Space>,
    grid: Grid,
}

impl Lot {
    /// A lot with so many cars (at most [`SPACES`]) on spaces that are drawn by `seed`: the same ones
    /// for every cell size.
    #[must_use]
    pub fn parked(size: CellSize, cars: u8, seed: u64) -> Self {
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let mut missing = u32::from(cars).min(SPACES as u32);
        let mut left = SPACES as u32;
        // Each set of spaces is as likely as any other.
        let drawn = spaces().filter(|_| {
            let taken = rng.random_range(0..left) < missing;
            missing -= u32::from(taken);
            left -= 1;
            taken
        });
        let cars: Vec<_> = drawn.collect();
        let grid = grid(size, &cars);
        Self { size, cars, grid }
    }

    /// The map.
    #[must_use]
    pub const fn grid(&self) -> &Grid {
        &self.grid
    }

    /// How large the map's cells are.
    #[must_use]
    pub const fn cell_size(&self) -> CellSize {
        self.size
    }

    /// The spaces with a car.
    #[must_use]
    pub fn cars(&self) -> &[Space] {
        &self.cars
    }

    /// Where the charging robot waits: in the upper left corner.
    #[must_use]
    pub const fn cabin(&self) -> Cell {
        middle(self.size, 0, 0)
    }

    /// Where the robot stands when it charges the car on `space`: on the lane before it.
    #[must_use]
    pub fn stop(&self, space: Space) -> Cell {
        middle(self.size, space.column.into(), space.lane.into())
    }

    /// The cells of a space.
    pub fn cells(&self, space: Space) -> impl Iterator<Item = Cell> + use<> {
        cells(self.size, space)
    }
}

/// The cell at the middle of a cell of 2.6 m, to the lower right of it where there is none.
const fn middle(size: CellSize, column: i32, row: i32) -> Cell {
    let division = size.division() as i32;
    Cell { x: column * division + division / 2, y: row * division + division / 2 }
}

fn cells(size: CellSize, space: Space) -> impl Iterator<Item = Cell> {
    let division = i32::from(size.division());
    let corner = Cell { x: i32::from(space.column) * division, y: i32::from(space.top) * division };
    (0..2 * division).flat_map(move |dy| (0..division).map(move |dx| corner.offset(dx, dy)))
}

fn grid(size: CellSize, cars: &[Space]) -> Grid {
    let [columns, rows] = COLUMNS_AND_ROWS.map(|cells| cells * size.division());
    let mut grid = Grid::open(columns, rows);
    cars.iter().flat_map(|&space| cells(size, space)).for_each(|cell| grid.set(cell, false));
    grid
}

#[cfg(test)]
mod tests {
    use std::collections::{BTreeSet, HashSet};

    use super::*;
    use crate::{
        moves::MoveSet,
        search::{Dijkstra, Workspace},
    };

    #[test]
    fn the_lot_has_49_spaces_in_6_areas_at_every_resolution() {
        assert_eq!(spaces().count(), SPACES);
        assert_eq!(spaces().map(Space::area).collect::<BTreeSet<_>>(), ('A'..='F').collect());
        for (size, sides) in CellSize::ALL.into_iter().zip([(15, 10), (30, 20), (60, 40)]) {
            let full = Lot::parked(size, u8::MAX, 1);
            assert_eq!((full.grid().width(), full.grid().height()), sides);
            assert_eq!(full.cars().len(), SPACES);
            let cells: HashSet<_> = spaces().flat_map(|space| full.cells(space)).collect();
            assert_eq!(cells.len(), SPACES * 2 * usize::from(size.division()).pow(2), "spaces overlap");
            assert!(cells.iter().all(|&cell| full.grid().index(cell).is_some()));
            assert_eq!(full.grid().free_cells().count(), full.grid().len() - cells.len());
            assert!((f64::from(sides.0) * size.metres() - 39.0).abs() < 1e-9);
        }
    }

    #[test]
    fn every_space_of_an_empty_lot_and_every_stop_of_a_full_one_can_be_reached() {
        for size in CellSize::ALL {
            let mut workspace = Workspace::default();
            let empty = Lot::parked(size, 0, 1);
            let ways =
                Dijkstra::new(empty.grid(), MoveSet::Eight).ways(empty.cabin(), &[], &mut workspace).unwrap();
            assert!(spaces().flat_map(|space| empty.cells(space)).all(|cell| ways.leads_to(cell)));
            let full = Lot::parked(size, 49, 1);
            let ways =
                Dijkstra::new(full.grid(), MoveSet::Eight).ways(full.cabin(), &[], &mut workspace).unwrap();
            assert!(spaces().all(|space| ways.leads_to(full.stop(space))));
        }
    }

    #[test]
    fn a_stop_is_before_its_own_space() {
        for size in CellSize::ALL {
            let lot = Lot::parked(size, 20, 5);
            for space in spaces() {
                let stop = lot.stop(space);
                let reach = i32::from(size.division());
                assert!(lot.cells(space).all(|cell| cell != stop));
                assert!(lot.cells(space).any(|cell| cell.x == stop.x && (cell.y - stop.y).abs() <= reach));
            }
        }
    }

    #[test]
    fn the_same_seed_parks_the_same_cars_and_another_seed_others() {
        let lot = Lot::parked(CellSize::M2_60, 30, 1);
        assert_eq!(lot.cars().len(), 30);
        assert_eq!(lot, Lot::parked(CellSize::M2_60, 30, 1));
        assert_eq!(lot.cars(), Lot::parked(CellSize::M0_65, 30, 1).cars());
        assert_ne!(lot.cars(), Lot::parked(CellSize::M2_60, 30, 2).cars());
        assert!(
            (0..200).any(|seed| Lot::parked(CellSize::M2_60, 1, seed).cars()[0] == spaces().last().unwrap())
        );
    }
}
