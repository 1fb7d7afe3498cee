//! Maps whose rooms and doors are known.

use planning::{
    floor_plan::Scale,
    formats::{movingai::read_map, rmf::building},
    grid::{Cell, Grid},
    rooms::Subareas,
};

/// A map, and how a person divides it.
pub struct Known {
    pub grid: Grid,
    /// The room of each cell; none for walls, doors that are drawn as lines, and what is too small to be a room.
    rooms: Vec<Option<usize>>,
    /// The cells of each door.
    pub doors: Vec<Vec<Cell>>,
}

impl Known {
    pub fn room(&self, cell: Cell) -> Option<usize> {
        self.rooms[self.grid.index(cell)?]
    }

    pub fn count(&self) -> usize {
        self.rooms.iter().flatten().collect::<std::collections::BTreeSet<_>>().len()
    }

    fn new(grid: Grid, doors: Vec<Vec<Cell>>, room: impl Fn(Cell) -> Option<usize>) -> Self {
        let free = |cell: &Cell| grid.is_free(*cell);
        let rooms =
            (0..grid.len()).map(|index| Some(grid.cell(index)).filter(free).and_then(&room)).collect();
        Self { grid, rooms, doors }
    }

    /// Rooms are what is left between the doors, which are drawn as lines. What is smaller than
    /// `room_area` cells is none, such as a slit in the plan's walls.
    fn drawn(grid: Grid, doors: &[[(i32, i32); 2]], room_area: usize) -> Self {
        let doors: Vec<Vec<Cell>> = doors.iter().map(|&ends| line(ends)).collect();
        let mut left = grid.clone();
        doors.iter().flatten().for_each(|&cell| left.set(cell, false));
        let mut rooms = vec![None; grid.len()];
        let mut count = 0;
        for start in grid.free_cells() {
            if !left.is_free(start) {
                continue;
            }
            let (mut room, mut next) = (vec![start], 0);
            left.set(start, false);
            while let Some(&cell) = room.get(next) {
                next += 1;
                for side in [(0, -1), (-1, 0), (1, 0), (0, 1)].map(|(dx, dy)| cell.offset(dx, dy)) {
                    if left.is_free(side) {
                        left.set(side, false);
                        room.push(side);
                    }
                }
            }
            if room.len() >= room_area {
                room.iter().for_each(|&cell| rooms[grid.index(cell).unwrap()] = Some(count));
                count += 1;
            }
        }
        Self { grid, rooms, doors }
    }
}

/// The cells from end to end, without a gap for a straight move.
fn line([from, to]: [(i32, i32); 2]) -> Vec<Cell> {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let steps = 4 * dx.abs().max(dy.abs());
    let at = |way: i32, step: i32| (f64::from(way * step) / f64::from(steps)).round() as i32;
    let mut cells: Vec<Cell> = Vec::new();
    for step in 0..=steps {
        let cell = Cell { x: from.0 + at(dx, step), y: from.1 + at(dy, step) };
        let corner = cells.last().map(|last| Cell { x: cell.x, y: last.y });
        cells.extend(corner);
        cells.push(cell);
    }
    cells.dedup();
    cells
}

/// LMPP Fig. 7 with the rooms and doors of its site file, which counts from 1 and upwards.
pub fn fig7() -> Known {
    let grid = read_map(include_str!("../../../sites/lmpp-fig7/fig7.map")).unwrap();
    let subareas = Subareas::read(include_str!("../../../sites/lmpp-fig7/subareas.txt"), &grid).unwrap();
    let doors = [(24, 70), (26, 70), (70, 55), (75, 70), (33, 30), (27, 28), (55, 70)];
    let doors = doors.map(|(x, y)| vec![Cell { x: x - 1, y: 100 - y }]);
    Known::new(grid, doors.to_vec(), |cell| subareas.find(cell).map(|id| usize::from(id.0)))
}

/// office500, which was generated of walls in every 36th row and column with openings of three cells.
pub fn office500() -> Known {
    let grid = read_map(include_str!("../data/bench/office500.map")).unwrap();
    let is_wall = |place: i32| place % 36 == 0 || place == 499;
    let number = |place: i32| usize::try_from((place - 1) / 36).unwrap();
    let is_door = |&cell: &Cell| {
        let (along_x, along_y) = (is_wall(cell.y) && !is_wall(cell.x), is_wall(cell.x) && !is_wall(cell.y));
        let middle = |dx, dy| (-1..=1).all(|step| grid.is_free(cell.offset(dx * step, dy * step)));
        along_x && middle(1, 0) || along_y && middle(0, 1)
    };
    let doors = grid.free_cells().filter(is_door).map(|cell| vec![cell]).collect();
    Known::new(grid, doors, |cell| Some(number(cell.y) * 14 + number(cell.x)))
}

/// Access Fig. 3, divided by hand. The paper has no rooms: all openings of at most 49 cells are taken for
/// doors; all others are as wide as the space on one side of them (82 cells and more, and one of 74).
pub fn access_fig3() -> Known {
    let grid = read_map(include_str!("../../../sites/access-fig3/access.map")).unwrap();
    let doors = [
        [(135, 124), (177, 124)],
        [(81, 206), (122, 206)],
        [(9, 372), (44, 372)],
        [(128, 468), (128, 490)],
        [(297, 356), (297, 397)],
        [(180, 356), (180, 361)],
        [(237, 289), (237, 334)],
        [(135, 225), (183, 225)],
        [(236, 133), (236, 146)],
        [(418, 311), (421, 311)],
        [(302, 345), (346, 366)],
    ];
    Known::drawn(grid, &doors, 30)
}

/// Cells of 5 cm, as `chargehand map` draws a building, but without lifts: it was divided by hand without them.
fn storey(text: &str, name: &str) -> Grid {
    let plans = building::read(text).unwrap();
    let mut plan = plans.into_iter().find(|plan| plan.name == name).unwrap();
    plan.lifts.clear();
    plan.draw(Scale { resolution_m: 0.05, wall_m: 0.1, lane_m: 1.0 }).unwrap().grid
}

/// The office of Open-RMF's demonstrations, divided by hand; two of the doors are also in the plan.
pub fn rmf_office() -> Known {
    let doors =
        [[(121, 89), (114, 105)], [(126, 39), (130, 17)], [(281, 103), (304, 103)], [(345, 177), (345, 195)]];
    Known::drawn(storey(include_str!("../data/rmf/office.building.yaml"), "L1"), &doors, 800)
}

/// The lower storey of Open-RMF's hotel, divided by hand; four of the doors, of up to 3 m, are also in the plan.
pub fn rmf_hotel_lobby() -> Known {
    let doors = [
        [(154, 512), (187, 558)],
        [(156, 251), (215, 251)],
        [(330, 81), (362, 81)],
        [(334, 270), (368, 270)],
        [(281, 313), (310, 313)],
        [(487, 468), (547, 468)],
    ];
    Known::drawn(storey(include_str!("../data/rmf/hotel.building.yaml"), "L1"), &doors, 800)
}

/// A storey of Open-RMF's hotel with guest rooms, divided by hand; seven of the doors are also in the plan.
pub fn rmf_hotel_rooms() -> Known {
    let doors = [
        // Along the corridor that goes down.
        [(219, 10), (219, 42)],
        [(218, 107), (218, 137)],
        [(218, 201), (218, 229)],
        [(219, 301), (219, 328)],
        [(218, 395), (218, 424)],
        [(261, 10), (261, 42)],
        [(261, 108), (261, 140)],
        [(263, 389), (263, 421)],
        // Along the corridor that goes across.
        [(396, 482), (422, 482)],
        [(93, 495), (93, 540)],
        [(144, 544), (168, 544)],
        [(240, 544), (267, 544)],
        [(335, 544), (364, 544)],
        [(433, 544), (459, 544)],
        [(528, 543), (554, 544)],
        // Bathrooms.
        [(92, 545), (92, 571)],
        [(188, 545), (188, 570)],
        [(286, 545), (286, 571)],
        [(383, 545), (383, 565)],
        [(477, 545), (477, 568)],
        [(573, 545), (573, 566)],
    ];
    Known::drawn(storey(include_str!("../data/rmf/hotel.building.yaml"), "L2"), &doors, 800)
}
