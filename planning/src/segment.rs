//! Subareas and doors derived from a map: room segmentation.
//!
//! Rooms are wide and doors are narrow. Cells are flooded in the order of their clearance, widest
//! first (a watershed of the distance transform): every room starts at its middle, and two rooms meet
//! in the door between them. Where they meet, they are one room after all if the opening is wider
//! than a door, or hardly narrower than the smaller of them is; else they stay apart. Small obstacles,
//! such as legs of tables, are looked through; small regions join the neighbour with the
//! longest border. Doors that a building's plan names cut the map before.
//!
//! Every border is given a door in each opening, so that whatever hangs together on the map does so
//! through doors, and the doors pass the checks of [`Rooms::new`].

use std::collections::{BTreeMap, BTreeSet};

use crate::{
    clearance,
    grid::{Cell, Grid},
    rooms::{Door, DoorId, Rooms, SubareaId, Subareas},
};

/// What counts as a door, a room or an obstacle; all in cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The widest opening that is a door.
    pub door_width: u32,
    /// The fewest cells of a room.
    pub room_area: u32,
    /// The most cells of an obstacle that is looked through.
    pub clutter_area: u32,
    /// How near a wall is to a door at least, as for [`Rooms::new`].
    pub reach: u32,
}

/// An opening whose clearance is above this share of the smaller room's is no door. A crossing of two
/// corridors is 1.41 times as wide as they are, and stays in one piece.
const NARROWER: f64 = 0.7;

const SIDES: [(i32, i32); 4] = [(0, -1), (-1, 0), (1, 0), (0, 1)];

/// Derives subareas and doors. Each of `doorways` is a line of cells that a door known from elsewhere
/// fills.
#[must_use]
pub fn segment(grid: &Grid, options: Options, doorways: &[Vec<Cell>]) -> Rooms {
    let mut regions = Regions::flooded(grid, options, doorways);
    regions.split_by_obstacles();
    regions.join_small(options.room_area as usize);
    // A border without a wall beside it is none.
    loop {
        match regions.doors(options.reach) {
            Ok(doors) => {
                if let Ok(rooms) = Rooms::new(regions.subareas(), doors, options.reach) {
                    return rooms;
                }
                regions.join_all();
            }
            Err(open) => open.into_iter().for_each(|(one, other)| regions.join(one, other)),
        }
    }
}

/// A region's number; it may have been joined to another.
type Region = u32;

/// Blocked cells.
const NONE: Region = Region::MAX;

struct Regions<'a> {
    grid: &'a Grid,
    /// The region that each cell was flooded from.
    of: Vec<Region>,
    /// What each region has been joined to, or itself.
    joined: Vec<Region>,
}

impl<'a> Regions<'a> {
    /// The watershed.
    fn flooded(grid: &'a Grid, options: Options, doorways: &[Vec<Cell>]) -> Self {
        let open = without_clutter(grid, options.clutter_area as usize);
        let mut cut = open.clone();
        doorways.iter().flatten().for_each(|&cell| cut.set(cell, false));
        let clearance = clearance::squared(&cut);
        let far = |index: usize| clearance.get(index).copied().unwrap_or(0);
        let mut order: Vec<usize> = (0..grid.len()).filter(|&index| open.is_free(grid.cell(index))).collect();
        order.sort_by_key(|&index| (std::cmp::Reverse(far(index)), index));

        let mut regions = Self { grid, of: vec![NONE; grid.len()], joined: Vec::new() };
        let mut peaks: Vec<f64> = Vec::new();
        let widest = f64::from(options.door_width);
        for index in order {
            let here = f64::from(far(index)).sqrt();
            let mut beside = regions.beside(grid.cell(index));
            let peak = |peaks: &[f64], region: Region| peaks.get(region as usize).copied().unwrap_or(0.0);
            // The highest peak first; its region takes the cell.
            beside.sort_by(|&one, &other| {
                peak(&peaks, other).total_cmp(&peak(&peaks, one)).then(one.cmp(&other))
            });
            let Some(&first) = beside.first() else {
                regions.set(index, regions.joined.len() as Region);
                regions.joined.push(regions.joined.len() as Region);
                peaks.push(here);
                continue;
            };
            regions.set(index, first);
            for &other in beside.iter().skip(1) {
                if 2.0 * here - 1.0 > widest || here > NARROWER * peak(&peaks, other) {
                    regions.join(first, other);
                }
            }
        }
        // Obstacles that were looked through are in no region.
        for index in 0..grid.len() {
            if !grid.is_free(grid.cell(index)) {
                regions.set(index, NONE);
            }
        }
        regions
    }

    fn set(&mut self, index: usize, region: Region) {
        if let Some(of) = self.of.get_mut(index) {
            *of = region;
        }
    }

    /// The region that `region` has been joined to in the end.
    fn root(&self, region: Region) -> Region {
        let mut region = region;
        while let Some(&joined) = self.joined.get(region as usize).filter(|&&joined| joined != region) {
            region = joined;
        }
        region
    }

    /// Joins two regions; the one with the lower number gives its name.
    fn join(&mut self, one: Region, other: Region) {
        let root = self.root(one).min(self.root(other));
        // All on the way there are joined to it at once, so that ways stay short on any map.
        for mut region in [one, other] {
            while let Some(joined) = self.joined.get_mut(region as usize).filter(|joined| **joined != root) {
                region = std::mem::replace(joined, root);
            }
        }
    }

    fn join_all(&mut self) {
        self.joined.fill(0);
    }

    /// The region of a cell, none if it is blocked or outside.
    fn at(&self, cell: Cell) -> Option<Region> {
        let of = *self.of.get(self.grid.index(cell)?)?;
        (of != NONE).then(|| self.root(of))
    }

    /// The regions on the four sides of a cell.
    fn beside(&self, cell: Cell) -> Vec<Region> {
        let mut beside: Vec<_> = SIDES.iter().filter_map(|&(dx, dy)| self.at(cell.offset(dx, dy))).collect();
        beside.sort_unstable();
        beside.dedup();
        beside
    }

    /// Makes a region of every part that hangs together by straight moves: an obstacle that was looked
    /// through may part a room.
    fn split_by_obstacles(&mut self) {
        let mut of = vec![NONE; self.of.len()];
        let mut count = 0;
        for start in self.grid.free_cells() {
            let Some(region) = self.at(start) else { continue };
            let mut open = vec![start];
            let mut found = false;
            while let Some(cell) = open.pop() {
                let place = self.grid.index(cell).and_then(|index| of.get_mut(index));
                let Some(place) = place.filter(|place| **place == NONE) else { continue };
                if self.at(cell) == Some(region) {
                    *place = count;
                    found = true;
                    open.extend(SIDES.map(|(dx, dy)| cell.offset(dx, dy)));
                }
            }
            count += u32::from(found);
        }
        (self.of, self.joined) = (of, (0..count).collect());
    }

    /// Joins regions of fewer cells than `least` to the neighbour with the longest border, as long as
    /// there are any; those without a neighbour become one.
    fn join_small(&mut self, least: usize) {
        loop {
            let mut areas: BTreeMap<Region, usize> = BTreeMap::new();
            let mut borders: BTreeMap<Region, BTreeMap<Region, usize>> = BTreeMap::new();
            for cell in self.grid.free_cells() {
                let Some(region) = self.at(cell) else { continue };
                *areas.entry(region).or_default() += 1;
                for other in self.beside(cell).into_iter().filter(|&other| other != region) {
                    *borders.entry(region).or_default().entry(other).or_default() += 1;
                }
            }
            let small = |region: &Region| areas.get(region).is_some_and(|&area| area < least);
            let (with, alone): (Vec<Region>, Vec<Region>) =
                areas.keys().copied().filter(small).partition(|region| borders.contains_key(region));
            alone.iter().for_each(|&region| self.join(region, alone.first().copied().unwrap_or(region)));
            if with.is_empty() {
                return;
            }
            for region in with {
                let longest = borders.get(&region).into_iter().flatten();
                if let Some((&other, _)) =
                    longest.max_by_key(|&(&other, &length)| (length, std::cmp::Reverse(other)))
                {
                    self.join(region, other);
                }
            }
        }
    }

    /// A door in every opening between two regions, or the pairs of regions with an opening that has
    /// no wall near.
    fn doors(&self, reach: u32) -> Result<Vec<Door>, BTreeSet<(Region, Region)>> {
        let mut borders: BTreeMap<(Region, Region), BTreeSet<Cell>> = BTreeMap::new();
        for cell in self.grid.free_cells() {
            let Some(region) = self.at(cell) else { continue };
            for other in self.beside(cell).into_iter().filter(|&other| other != region) {
                borders.entry((region.min(other), region.max(other))).or_default().insert(cell);
            }
        }
        let ids = self.ids();
        let id = |region| SubareaId(ids.get(&region).copied().unwrap_or(0));
        let clearance = clearance::squared(self.grid);
        let far =
            |cell: Cell| self.grid.index(cell).and_then(|index| clearance.get(index).copied()).unwrap_or(0);
        let (mut doors, mut open) = (Vec::new(), BTreeSet::new());
        for (&(one, other), cells) in &borders {
            for opening in parts(cells) {
                let beside_wall = opening.iter().filter(|&&cell| far(cell) <= reach.saturating_mul(reach));
                let Some(&cell) = beside_wall.max_by_key(|&&cell| (far(cell), std::cmp::Reverse(cell)))
                else {
                    open.insert((one, other));
                    continue;
                };
                let number = u16::try_from(doors.len() + 1).unwrap_or(u16::MAX);
                doors.push(Door { id: DoorId(number), cell, joins: [id(one), id(other)] });
            }
        }
        if open.is_empty() { Ok(doors) } else { Err(open) }
    }

    /// The subareas' numbers, in the order in which their pictures' rows show them.
    fn ids(&self) -> BTreeMap<Region, u16> {
        let mut ids = BTreeMap::new();
        for region in self.grid.free_cells().filter_map(|cell| self.at(cell)) {
            let next = u16::try_from(ids.len()).unwrap_or(0);
            ids.entry(region).or_insert(next);
        }
        ids
    }

    fn subareas(&self) -> Subareas {
        let ids = self.ids();
        Subareas::label(self.grid, |cell| {
            self.at(cell).and_then(|region| ids.get(&region).copied()).unwrap_or(0)
        })
    }
}

/// The parts of `cells` that hang together, straight or diagonally.
fn parts(cells: &BTreeSet<Cell>) -> Vec<Vec<Cell>> {
    let mut left = cells.clone();
    let mut parts = Vec::new();
    while let Some(start) = left.pop_first() {
        let mut part = vec![start];
        let mut next = 0;
        while let Some(&cell) = part.get(next) {
            next += 1;
            for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))) {
                part.extend(left.take(&cell.offset(dx, dy)));
            }
        }
        parts.push(part);
    }
    parts
}

/// The map without obstacles of at most `most` cells that touch no edge of it.
fn without_clutter(grid: &Grid, most: usize) -> Grid {
    let mut open = grid.clone();
    let mut seen = vec![false; grid.len()];
    for start in (0..grid.len()).map(|index| grid.cell(index)) {
        let mut obstacle: Vec<Cell> = Vec::new();
        let (mut stack, mut at_edge) = (vec![start], false);
        while let Some(cell) = stack.pop() {
            if grid.is_free(cell) {
                continue;
            }
            let place = grid.index(cell).and_then(|index| seen.get_mut(index));
            at_edge |= place.is_none();
            if place.is_none_or(|seen| std::mem::replace(seen, true)) {
                continue;
            }
            obstacle.push(cell);
            stack.extend((-1..=1).flat_map(|dy| (-1..=1).map(move |dx| cell.offset(dx, dy))));
        }
        if !at_edge && obstacle.len() <= most {
            obstacle.into_iter().for_each(|cell| open.set(cell, true));
        }
    }
    open
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::movingai::read_map;

    const OPTIONS: Options = Options { door_width: 4, room_area: 6, clutter_area: 1, reach: 5 };

    fn map(rows: &[&str]) -> Grid {
        let head = format!("type octile\nheight {}\nwidth {}\nmap\n", rows.len(), rows[0].len());
        read_map(&(head + &rows.join("\n"))).unwrap()
    }

    fn picture(rooms: &Rooms) -> Vec<String> {
        rooms.subareas().picture().lines().map(str::to_owned).collect()
    }

    const TWO_ROOMS: [&str; 7] = [
        ".......@.......",
        ".......@.......",
        ".......@.......",
        "...@...........",
        ".......@.......",
        ".......@.......",
        ".......@.......",
    ];

    #[test]
    fn two_rooms_and_the_door_between_them_are_found_though_there_is_a_pillar() {
        let rooms = segment(&map(&TWO_ROOMS), OPTIONS, &[]);
        assert_eq!(rooms.subareas().iter().map(|(_, name)| name).collect::<String>(), "AB");
        assert_eq!(rooms.doors().len(), 1);
        let Cell { x, y } = rooms.doors()[0].cell;
        assert!((6..=8).contains(&x) && y == 3, "{:#?}", picture(&rooms));
    }

    #[test]
    fn a_wide_opening_is_no_door_but_a_known_door_is() {
        let grid = map(&["......@......", ".............", ".............", "............."]);
        assert_eq!(segment(&grid, OPTIONS, &[]).subareas().iter().count(), 1);
        let line: Vec<Cell> = (1..4).map(|y| Cell { x: 6, y }).collect();
        let rooms = segment(&grid, OPTIONS, &[line]);
        assert_eq!((rooms.subareas().iter().count(), rooms.doors().len()), (2, 1), "{:#?}", picture(&rooms));
    }

    #[test]
    fn pockets_that_lead_nowhere_share_a_subarea() {
        let grid = map(&["....@.@.@", "....@@@@@", "....@.@.@"]);
        assert_eq!(picture(&segment(&grid, OPTIONS, &[])), ["AAAA@B@B@", "AAAA@@@@@", "AAAA@B@B@"]);
    }

    #[test]
    fn a_map_without_a_free_cell_has_no_subarea() {
        let rooms = segment(&map(&["@@@"]), OPTIONS, &[]);
        assert_eq!((rooms.subareas().iter().count(), rooms.doors().len()), (0, 0));
    }
}
