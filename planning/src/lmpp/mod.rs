//! Local memorial path planning (LMPP Algorithm 6, keeping the shortest path).
//!
//! A path from a robot to a pile has three parts: from the robot to a door of its subarea, from door
//! to door, and from the last door to the pile. The paper searches for the first part and recalls
//! the others from memory. Here the first part is recalled too, from the [`Fields`] of the doors, and
//! the way to a pile in the robot's own subarea from that of the pile; the chain of doors is found for
//! every door and pile when the memory is planned. So nothing at all is searched for: the best of the
//! few doors of the robot's subarea is chosen, and stored paths are put together.
//!
//! A [`Survey`] answers for a robot's position; as a [`Planner`], [`Lmpp`] plans to its targets' cells.

mod chains;

use std::collections::BTreeSet;

use self::chains::Chains;
use crate::{
    grid::{Cell, Grid},
    memory::{Banks, DoorSets, Fields, FileError, Memory, Target},
    moves::{self, Length, MoveSet, Step},
    path::Path,
    rooms::{DoorId, Rooms, SubareaId},
    search::{Plan, Planner, SearchError, free_index},
};

/// A map, its rooms, its targets and the memory of paths between them.
#[derive(Clone, Debug)]
pub struct Lmpp {
    /// The map with all doors open; in that of the fields the closed ones are blocked.
    grid: Grid,
    rooms: Rooms,
    sets: DoorSets,
    targets: Vec<Target>,
    closed: BTreeSet<DoorId>,
    /// The ways to all doors, then to all targets, in the site's order.
    fields: Fields,
    banks: Banks,
    chains: Chains,
    /// For each subarea the open doors that a robot there may make for, by their places in the list.
    exits: Vec<Vec<usize>>,
    /// The subareas of the targets.
    subareas: Vec<Option<SubareaId>>,
}

/// A path to a target.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Route {
    /// The path.
    pub path: Path,
    /// The doors it passes, in order.
    pub doors: Vec<DoorId>,
}

impl Lmpp {
    /// Plans the memory of a site with all doors open. Every target must be on a free cell.
    #[must_use]
    pub fn new(grid: Grid, moves: MoveSet, rooms: Rooms, targets: Vec<Target>) -> Self {
        let sets = DoorSets::of(&rooms);
        Self::with_door_sets(grid, moves, rooms, targets, sets)
    }

    /// As [`Self::new`], with door sets of one's own.
    #[must_use]
    pub fn with_door_sets(
        grid: Grid,
        moves: MoveSet,
        rooms: Rooms,
        targets: Vec<Target>,
        sets: DoorSets,
    ) -> Self {
        let fields = Fields::build(grid, moves, &places(&rooms, &targets));
        Self::over(fields, rooms, targets, sets)
    }

    /// As [`Self::new`], with the fields in the bytes of a file that [`Fields::to_bytes`] gave of another
    /// `Lmpp` with all doors open.
    ///
    /// # Errors
    /// [`FileError`] if they are damaged, or the fields of something else.
    pub fn restore(
        grid: Grid,
        moves: MoveSet,
        rooms: Rooms,
        targets: Vec<Target>,
        bytes: Box<dyn Memory>,
    ) -> Result<Self, FileError> {
        let fields = Fields::open(grid, moves, &places(&rooms, &targets), bytes)?;
        let sets = DoorSets::of(&rooms);
        Ok(Self::over(fields, rooms, targets, sets))
    }

    /// The memory over fields of an open site's [`places`].
    fn over(fields: Fields, rooms: Rooms, targets: Vec<Target>, sets: DoorSets) -> Self {
        let subareas = targets.iter().map(|target| rooms.find_subarea(target.cell)).collect();
        let mut lmpp = Self {
            grid: fields.grid().clone(),
            rooms,
            sets,
            targets,
            closed: BTreeSet::new(),
            fields,
            banks: Banks::default(),
            chains: Chains::default(),
            exits: Vec::new(),
            subareas,
        };
        lmpp.memorise();
        lmpp
    }

    /// Closes these doors, such as those [`crate::congestion::avoided`] names, and opens all others.
    /// Fields are repaired, and the banks put together anew, if that changes anything.
    pub fn close(&mut self, closed: BTreeSet<DoorId>) {
        if closed == self.closed {
            return;
        }
        self.closed = closed;
        let doors = self.rooms.doors();
        let shut = doors.iter().filter(|door| self.closed.contains(&door.id)).map(|door| door.cell);
        let shut: BTreeSet<_> = shut.collect();
        self.fields.change(doors.iter().map(|door| (door.cell, !shut.contains(&door.cell))));
        self.memorise();
    }

    fn memorise(&mut self) {
        let Self { rooms, sets, targets, closed, fields, .. } = self;
        self.banks = Banks::build(fields, rooms, sets, targets, closed);
        self.chains = Chains::find(rooms.doors(), targets, &self.banks);
        let open = rooms.doors().iter().enumerate().filter(|(_, door)| !closed.contains(&door.id));
        self.exits = rooms.subareas().iter().map(|_| Vec::new()).collect();
        for (place, door) in open {
            for (subarea, _) in sets.exits.iter().filter(|(_, exits)| exits.contains(&door.id)) {
                self.exits.get_mut(usize::from(subarea.0)).into_iter().for_each(|exits| exits.push(place));
            }
        }
    }

    /// The doors that are closed now.
    #[must_use]
    pub const fn closed(&self) -> &BTreeSet<DoorId> {
        &self.closed
    }

    /// The map, with all doors open.
    #[must_use]
    pub const fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The memory banks.
    #[must_use]
    pub const fn banks(&self) -> &Banks {
        &self.banks
    }

    /// The ways to all doors, then to all targets, past the doors that are closed now.
    #[must_use]
    pub const fn fields(&self) -> &Fields {
        &self.fields
    }

    /// What the memory takes, in bytes; [`Fields::bytes`] has most of its parts.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.fields.bytes().total() + self.banks.bytes() + self.chains.bytes()
    }

    /// Looks from `from` to all targets.
    ///
    /// # Errors
    /// [`SearchError`] if `from` is outside the map or in a wall.
    pub fn survey(&self, from: Cell) -> Result<Survey<'_>, SearchError> {
        free_index(&self.grid, from)?;
        Ok(Survey { lmpp: self, from, own: self.rooms.find_subarea(from) })
    }

    /// How a robot in the opening of a closed door leaves it: the length of the whole way, and the first
    /// move.
    fn way_out(&self, from: Cell, field: usize) -> Option<(Length, Step)> {
        let grid = self.fields.grid();
        if grid.is_free(from) || !self.grid.is_free(from) {
            return None;
        }
        // As [`moves::allowed`] would say if the robot's own cell were free.
        let is_allowed =
            |&&step: &&Step| moves::bounds(from, step).all(|cell| cell == from || grid.is_free(cell));
        let steps = self.fields.moves().steps().iter().filter(is_allowed);
        let ways = (0..).zip(steps).filter_map(|(number, &step)| {
            let rest = self.fields.length(from.offset(step.0, step.1), field)?;
            Some((Length::of(step) + rest, number, step))
        });
        ways.min().map(|(length, _, step)| (length, step))
    }

    /// Puts the way to a field's target into `path`; whether there is one.
    #[inline]
    fn walk(&self, from: Cell, field: usize, path: &mut Path) -> bool {
        if self.fields.walk(from, field, path) {
            return true;
        }
        let Some((_, step)) = self.way_out(from, field) else { return false };
        let mut rest = Path::default();
        let is_way = self.fields.walk(from.offset(step.0, step.1), field, &mut rest);
        path.restart(from);
        path.step(step);
        path.append(rest.waypoints(), rest.length());
        is_way
    }
}

/// What the fields of a site lead to: all doors, then all targets.
fn places(rooms: &Rooms, targets: &[Target]) -> Vec<Cell> {
    let doors = rooms.doors().iter().map(|door| door.cell);
    doors.chain(targets.iter().map(|target| target.cell)).collect()
}

/// What a robot at one place can reach, and how.
#[derive(Clone, Copy, Debug)]
pub struct Survey<'a> {
    lmpp: &'a Lmpp,
    from: Cell,
    /// The subarea it is in.
    own: Option<SubareaId>,
}

/// How a robot gets to a target: how far it is, and for which door it makes first; none on the way to a
/// target in its own subarea.
#[derive(Clone, Copy, Debug)]
struct Way {
    length: Length,
    first: Option<usize>,
}

impl Survey<'_> {
    /// The best way to a target, by its place in the site's list.
    #[inline]
    fn way_to(&self, target: usize) -> Option<Way> {
        let Self { lmpp, from, own } = *self;
        let doors = lmpp.rooms.doors();
        // Found once: all lengths from a cell lie side by side.
        let row = lmpp.fields.row(from);
        let length = |field| row.length(field).or_else(|| Some(lmpp.way_out(from, field)?.0));
        if *lmpp.subareas.get(target)? == own
            && let Some(length) = length(doors.len() + target)
        {
            return Some(Way { length, first: None });
        }
        let exits = lmpp.exits.get(usize::from(own?.0))?;
        let ways = exits.iter().filter_map(|&exit| {
            let rest = lmpp.chains.length(exit, target)?;
            let length = length(exit)? + rest;
            Some((length.cost(), length, doors.get(exit)?.id, exit))
        });
        ways.min().map(|(_, length, _, exit)| Way { length, first: Some(exit) })
    }

    fn place_of(&self, target: u16) -> Option<usize> {
        self.lmpp.targets.iter().position(|known| known.id == target)
    }

    /// The length of the path to a target; `None` if no chain of open doors leads there.
    #[must_use]
    pub fn length_to(&self, target: u16) -> Option<Length> {
        Some(self.way_to(self.place_of(target)?)?.length)
    }

    /// All reachable targets with the lengths of their paths, in the site's order.
    pub fn lengths(&self) -> impl Iterator<Item = (u16, Length)> + '_ {
        let targets = self.lmpp.targets.iter().enumerate();
        targets.filter_map(|(place, target)| Some((target.id, self.way_to(place)?.length)))
    }

    /// The nearest target; of equals the one with the lowest number.
    #[must_use]
    pub fn nearest(&self) -> Option<(u16, Length)> {
        self.lengths().min_by_key(|&(id, length)| (length, id))
    }

    /// The doors on the path to a target; none within the robot's own subarea, or if there is no path.
    #[must_use]
    pub fn doors_to(&self, target: u16) -> &[DoorId] {
        let way = self.place_of(target).and_then(|target| Some((target, self.way_to(target)?.first?)));
        way.map_or(&[], |(target, first)| self.lmpp.chains.doors(first, target))
    }

    /// The path to a target; `None` if no chain of open doors leads there.
    #[must_use]
    pub fn route_to(&self, target: u16) -> Option<Route> {
        let mut path = Path::default();
        let doors = self.recall(self.place_of(target)?, &mut path)?.to_vec();
        Some(Route { path, doors })
    }

    /// Puts the path to a target into `path` and returns the doors that it passes; `None` if no chain of
    /// open doors leads there.
    fn recall(&self, target: usize, path: &mut Path) -> Option<&[DoorId]> {
        let Self { lmpp, from, .. } = *self;
        let Some(first) = self.way_to(target)?.first else {
            let field = lmpp.rooms.doors().len() + target;
            return lmpp.walk(from, field, path).then_some(&[]);
        };
        if !lmpp.walk(from, first, path) {
            return None;
        }
        Some(lmpp.chains.recall_onto(first, target, path))
    }
}

/// Plans to the targets' cells only: another goal is [`SearchError::NoTarget`]. Paths are what Algorithm 6
/// gives, corrected to keep the shortest: of all paths through doors the shortest, which may be longer than
/// the shortest there is. Nothing is searched, so that nothing is expanded.
impl Planner for Lmpp {
    type Workspace = Path;

    fn plan<'w>(&self, from: Cell, to: Cell, path: &'w mut Path) -> Result<Plan<'w>, SearchError> {
        let survey = self.survey(from)?;
        free_index(&self.grid, to)?;
        let target = self.targets.iter().position(|target| target.cell == to);
        let target = target.ok_or(SearchError::NoTarget { cell: to })?;
        survey.recall(target, path).ok_or(SearchError::NoPath { from, to })?;
        Ok(Plan { path, expanded: 0 })
    }
}
