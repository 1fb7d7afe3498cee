//! Subareas and doors (LMPP section III.A, Algorithms 1 and 2).
//!
//! A site is divided into subareas, such as rooms; doors join two of them. A door is a cell in or
//! at the opening through which robots pass.

use std::{
    collections::{BTreeMap, BTreeSet},
    fmt,
};

use crate::{
    grid::{Cell, Grid},
    moves::{self, MoveSet},
};

/// A subarea of a site; its number counts the names in the order in which they appear.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SubareaId(pub u16);

/// A door of a site, as the site numbers it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct DoorId(pub u16);

impl fmt::Display for DoorId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// A boundary-crossing between two subareas.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Door {
    /// Its number.
    pub id: DoorId,
    /// Where robots pass.
    pub cell: Cell,
    /// The subareas it joins.
    pub joins: [SubareaId; 2],
}

/// Which subarea every free cell belongs to, and the doors between them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rooms {
    subareas: Subareas,
    doors: Vec<Door>,
}

/// A picture of the subareas: one character a cell, rows from the top, `@` for walls.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Subareas {
    names: Vec<char>,
    /// [`WALL`], or the subarea of the cell.
    labels: Vec<u16>,
    grid: Grid,
}

const WALL: u16 = u16::MAX;

/// What is wrong with a picture of subareas, and in which line (from 1).
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SubareasError {
    /// There are more or fewer rows than the map has.
    #[error("line {line}: {found} rows of subareas: expected {expected}, as the map has")]
    Rows {
        /// The last line.
        line: usize,
        /// How many rows there are.
        found: usize,
        /// The map's rows.
        expected: u32,
    },
    /// A row is too long or too short.
    #[error("line {line}: {found} cells: expected {expected}, as the map has")]
    Ragged {
        /// The line.
        line: usize,
        /// How many cells it has.
        found: usize,
        /// The map's columns.
        expected: u32,
    },
    /// A free cell is drawn as a wall, or a wall as part of a subarea.
    #[error("line {line}, column {column}: `{found}` on a {} cell: expected {}", if *.free { "free" } else { "blocked" }, if *.free { "a subarea's name" } else { "`@`" })]
    Terrain {
        /// The line.
        line: usize,
        /// The column, from 1.
        column: usize,
        /// What is drawn.
        found: char,
        /// Whether the map's cell is free.
        free: bool,
    },
    /// There are too many subareas.
    #[error("line {line}: more than {} subareas", WALL)]
    TooMany {
        /// The line that has one too many.
        line: usize,
    },
}

impl Subareas {
    /// Reads the picture of `grid`'s subareas.
    ///
    /// # Errors
    /// [`SubareasError`] names the first line that does not fit the map.
    pub fn read(text: &str, grid: &Grid) -> Result<Self, SubareasError> {
        let mut subareas =
            Self { names: Vec::new(), labels: Vec::with_capacity(grid.len()), grid: grid.clone() };
        let mut known: BTreeMap<char, u16> = BTreeMap::new();
        let rows: Vec<&str> = text.trim_end().lines().collect();
        if rows.len() != grid.height() as usize {
            let (line, found) = (rows.len().max(1), rows.len());
            return Err(SubareasError::Rows { line, found, expected: grid.height() });
        }
        for (y, row) in rows.into_iter().enumerate() {
            let (line, found) = (y + 1, row.chars().count());
            if found != grid.width() as usize {
                return Err(SubareasError::Ragged { line, found, expected: grid.width() });
            }
            for (x, name) in row.chars().enumerate() {
                let free = grid.is_free(Cell { x: x as i32, y: y as i32 });
                if free == (name == '@') {
                    return Err(SubareasError::Terrain { line, column: x + 1, found: name, free });
                }
                let next = u16::try_from(known.len()).ok().filter(|&next| next != WALL);
                let label = match (free, known.get(&name), next) {
                    (false, ..) => WALL,
                    (true, Some(&label), _) => label,
                    (true, None, Some(next)) => {
                        known.insert(name, next);
                        subareas.names.push(name);
                        next
                    }
                    (true, None, None) => return Err(SubareasError::TooMany { line }),
                };
                subareas.labels.push(label);
            }
        }
        Ok(subareas)
    }

    /// The subareas that `label` numbers, from 0 without a gap, in the order in which the rows show
    /// them; they get letters and digits for names, then those of other alphabets.
    pub(crate) fn label(grid: &Grid, label: impl Fn(Cell) -> u16) -> Self {
        let labels: Vec<u16> = (0..grid.len())
            .map(|index| grid.cell(index))
            .map(|cell| if grid.is_free(cell) { label(cell).min(WALL - 1) } else { WALL })
            .collect();
        let count =
            labels.iter().filter(|&&label| label != WALL).max().map_or(0, |&last| usize::from(last) + 1);
        Self { names: names().take(count).collect(), labels, grid: grid.clone() }
    }

    /// The picture, as [`Self::read`] reads it.
    #[must_use]
    pub fn picture(&self) -> String {
        let mut picture = String::with_capacity(self.labels.len());
        for row in self.labels.chunks(self.grid.width().max(1) as usize) {
            picture.extend(row.iter().map(|&label| self.name(SubareaId(label)).unwrap_or('@')));
            picture.push('\n');
        }
        picture
    }

    /// The names of the subareas.
    pub fn iter(&self) -> impl Iterator<Item = (SubareaId, char)> + '_ {
        (0..).map(SubareaId).zip(self.names.iter().copied())
    }

    /// The subarea of that name.
    #[must_use]
    pub fn named(&self, name: char) -> Option<SubareaId> {
        self.iter().find_map(|(id, known)| (known == name).then_some(id))
    }

    /// The name of a subarea.
    #[must_use]
    pub fn name(&self, id: SubareaId) -> Option<char> {
        self.names.get(usize::from(id.0)).copied()
    }

    /// The subarea in which `cell` lies (LMPP Algorithm 1); `None` for walls and outside.
    #[must_use]
    pub fn find(&self, cell: Cell) -> Option<SubareaId> {
        let label = *self.labels.get(self.grid.index(cell)?)?;
        (label != WALL).then_some(SubareaId(label))
    }
}

/// Names for subareas, each a character.
fn names() -> impl Iterator<Item = char> {
    let others = ('\u{c0}'..).filter(|name| name.is_alphanumeric());
    ('A'..='Z').chain('a'..='z').chain('0'..='9').chain(others)
}

/// What is wrong with a door.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DoorError {
    /// Two doors have one number.
    #[error("door {0} is there twice: give each door its own number")]
    Twice(DoorId),
    /// Its cell is blocked or outside.
    #[error("door {0} is in a wall or outside the map: put it on a free cell of the opening")]
    Blocked(DoorId),
    /// It joins a subarea to itself.
    #[error("door {0} joins a subarea to itself: name the two that it joins")]
    JoinsOne(DoorId),
    /// One of its subareas is not near, or only behind a wall.
    #[error(
        "door {door} does not lead to subarea {subarea}: expected an opening to it within {reach} cells of the door"
    )]
    FarFrom {
        /// The door.
        door: DoorId,
        /// The subarea's name.
        subarea: char,
        /// How near it has to be.
        reach: u32,
    },
    /// No wall is near.
    #[error("door {door} is in no wall: expected a blocked cell within {reach} cells of it")]
    NoWall {
        /// The door.
        door: DoorId,
        /// How near a wall has to be.
        reach: u32,
    },
}

impl Rooms {
    /// Joins subareas by doors. Within `reach` cells of a door (straight or diagonal) must be a wall,
    /// and a robot must come to both its subareas without leaving these cells: a door beside an
    /// unbroken wall is none. Thicker walls need more reach.
    ///
    /// # Errors
    /// Everything that is wrong with every door.
    pub fn new(subareas: Subareas, doors: Vec<Door>, reach: u32) -> Result<Self, Vec<DoorError>> {
        let mut errors = Vec::new();
        let mut seen = BTreeMap::new();
        for door in &doors {
            if seen.insert(door.id, ()).is_some() {
                errors.push(DoorError::Twice(door.id));
            }
            errors.extend(check(&subareas, door, reach).err());
        }
        if errors.is_empty() { Ok(Self { subareas, doors }) } else { Err(errors) }
    }

    /// The subareas.
    #[must_use]
    pub const fn subareas(&self) -> &Subareas {
        &self.subareas
    }

    /// All doors, in the site's order.
    #[must_use]
    pub fn doors(&self) -> &[Door] {
        &self.doors
    }

    /// The subarea in which `cell` lies (LMPP Algorithm 1).
    #[must_use]
    pub fn find_subarea(&self, cell: Cell) -> Option<SubareaId> {
        self.subareas.find(cell)
    }

    /// The doors of a subarea (LMPP Algorithm 2).
    pub fn doors_of(&self, subarea: SubareaId) -> impl Iterator<Item = &Door> + '_ {
        self.doors.iter().filter(move |door| door.joins.contains(&subarea))
    }
}

fn check(subareas: &Subareas, door: &Door, reach: u32) -> Result<(), DoorError> {
    if !subareas.grid.is_free(door.cell) {
        return Err(DoorError::Blocked(door.id));
    }
    let [one, other] = door.joins;
    if one == other {
        return Err(DoorError::JoinsOne(door.id));
    }
    let radius = i32::try_from(reach).unwrap_or(i32::MAX);
    let around =
        || (-radius..=radius).flat_map(move |dy| (-radius..=radius).map(move |dx| door.cell.offset(dx, dy)));
    if around().all(|cell| subareas.grid.is_free(cell)) {
        return Err(DoorError::NoWall { door: door.id, reach });
    }
    let entered = entered(subareas, door.cell, reach);
    if let Some(far) = door.joins.into_iter().find(|id| !entered.contains(id)) {
        let subarea = subareas.name(far).unwrap_or('?');
        return Err(DoorError::FarFrom { door: door.id, subarea, reach });
    }
    Ok(())
}

/// The subareas to which a robot comes from `door` without going further than `reach` from it.
fn entered(subareas: &Subareas, door: Cell, reach: u32) -> BTreeSet<SubareaId> {
    let is_near = |cell: Cell| cell.x.abs_diff(door.x).max(cell.y.abs_diff(door.y)) <= reach;
    let mut seen = BTreeSet::from([door]);
    let mut open = vec![door];
    while let Some(cell) = open.pop() {
        for &step in MoveSet::Eight.steps() {
            let next = cell.offset(step.0, step.1);
            if is_near(next) && moves::allowed(&subareas.grid, cell, step) && seen.insert(next) {
                open.push(next);
            }
        }
    }
    seen.into_iter().filter_map(|cell| subareas.find(cell)).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::formats::movingai::read_map;

    fn grid() -> Grid {
        read_map("type octile\nheight 2\nwidth 5\nmap\n..@..\n..@..\n").unwrap()
    }

    fn error(text: &str) -> String {
        Subareas::read(text, &grid()).unwrap_err().to_string()
    }

    #[test]
    fn every_cell_is_in_the_subarea_that_is_drawn() {
        let subareas = Subareas::read("aa@bb\r\naa@bb\r\n", &grid()).unwrap();
        let [a, b] = ['a', 'b'].map(|name| subareas.named(name));
        assert_eq!(subareas.iter().map(|(_, name)| name).collect::<String>(), "ab");
        assert_eq!((subareas.find(Cell { x: 1, y: 0 }), subareas.find(Cell { x: 3, y: 1 })), (a, b));
        assert_eq!((subareas.find(Cell { x: 2, y: 1 }), subareas.find(Cell { x: 5, y: 0 })), (None, None));
    }

    #[test]
    fn a_picture_that_does_not_fit_the_map_is_named_by_line_and_column() {
        assert_eq!(error("aa@bb\n"), "line 1: 1 rows of subareas: expected 2, as the map has");
        assert_eq!(error("aa@bb\naa@b\n"), "line 2: 4 cells: expected 5, as the map has");
        assert_eq!(error("aa@bb\naacbb\n"), "line 2, column 3: `c` on a blocked cell: expected `@`");
        assert_eq!(
            error("aa@bb\n@a@bb\n"),
            "line 2, column 1: `@` on a free cell: expected a subarea's name"
        );
    }

    proptest! {
        #[test]
        fn no_text_makes_the_reader_panic(text in "([ab@\u{e9}]{0,6}\r?\n?){0,4}") {
            let _ = Subareas::read(&text, &grid());
        }
    }
}
