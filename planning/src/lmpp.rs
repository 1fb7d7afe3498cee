//! Local memorial path planning (LMPP Algorithm 6, keeping the shortest path).
//!
//! A path from a robot to a pile has three parts: from the robot to a door of its subarea, which is
//! searched; from door to door, and from the last door to the pile, which are recalled. In the
//! robot's own subarea the pile itself is searched for.
//!
//! A [`Survey`] makes the one search a robot's position needs and then answers for every pile: the
//! search stops at the subarea's doors and piles, and a walk over the doors' graph finds the best
//! chain of doors for all piles at once, where Algorithm 6 tries every pair.

use std::{
    cmp::Reverse,
    collections::{BTreeMap, BTreeSet, BinaryHeap},
};

use crate::{
    grid::{Cell, Grid},
    memory::{Banks, Direction, DoorSets, Leg, Target, without},
    moves::{Length, MoveSet},
    path::Path,
    rooms::{DoorId, Rooms},
    search::{SearchError, Workspace, dijkstra},
};

/// A map, its rooms, its targets and the memory of paths between them.
#[derive(Clone, Debug)]
pub struct Lmpp {
    grid: Grid,
    moves: MoveSet,
    rooms: Rooms,
    sets: DoorSets,
    targets: Vec<Target>,
    closed: BTreeSet<DoorId>,
    /// The map with the closed doors' cells blocked.
    open_grid: Grid,
    banks: Banks,
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
        let closed = BTreeSet::new();
        let banks = Banks::build(&grid, moves, &rooms, &sets, &targets, &closed);
        Self { open_grid: grid.clone(), grid, moves, rooms, sets, targets, closed, banks }
    }

    /// Closes these doors, such as those [`crate::congestion::avoided`] names, and opens all others.
    /// The memory is planned anew if that changes anything.
    pub fn close(&mut self, closed: BTreeSet<DoorId>) {
        if closed != self.closed {
            self.open_grid = without(&self.grid, &self.rooms, &closed);
            self.banks =
                Banks::build(&self.grid, self.moves, &self.rooms, &self.sets, &self.targets, &closed);
            self.closed = closed;
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

    /// Looks from `from` to all targets.
    ///
    /// # Errors
    /// [`SearchError`] if `from` is outside the map or in a wall.
    pub fn survey(&self, from: Cell, workspace: &mut Workspace) -> Result<Survey<'_>, SearchError> {
        let own = self.rooms.find_subarea(from);
        let exits = own.and_then(|subarea| self.sets.exits.get(&subarea));
        let exits: Vec<_> = self
            .rooms
            .doors()
            .iter()
            .filter(|door| {
                !self.closed.contains(&door.id) && exits.is_some_and(|exits| exits.contains(&door.id))
            })
            .collect();
        let near: Vec<_> =
            self.targets.iter().filter(|target| self.rooms.find_subarea(target.cell) == own).collect();
        let goals: Vec<_> =
            exits.iter().map(|door| door.cell).chain(near.iter().map(|target| target.cell)).collect();

        // A robot may stand at a door that has just been closed; it is let out.
        let freed;
        let grid = if self.grid.is_free(from) && !self.open_grid.is_free(from) {
            let mut grid = self.open_grid.clone();
            grid.set(from, true);
            freed = grid;
            &freed
        } else {
            &self.open_grid
        };
        if goals.is_empty() {
            // Nothing to search for, but `from` is still checked.
            let ways = dijkstra(grid, self.moves, from, &[from], workspace)?;
            return Ok(Survey::new(self, ways.expanded()));
        }
        let ways = dijkstra(grid, self.moves, from, &goals, workspace)?;
        let mut survey = Survey::new(self, ways.expanded());
        for target in near {
            if let Some(path) = ways.path_to(target.cell) {
                survey.near.insert(target.id, path);
            }
        }
        for door in exits {
            if let Some(path) = ways.path_to(door.cell) {
                survey.exits.insert(door.id, path);
            }
        }
        survey.chain_doors();
        Ok(survey)
    }
}

/// What a robot at one place can reach, and how.
#[derive(Clone, Debug)]
pub struct Survey<'a> {
    lmpp: &'a Lmpp,
    expanded: u32,
    /// Paths to targets in the robot's own subarea.
    near: BTreeMap<u16, Path>,
    /// Paths to the doors of the robot's own subarea: part I.
    exits: BTreeMap<DoorId, Path>,
    /// The best way to every door.
    doors: BTreeMap<DoorId, Chain>,
}

/// The best way to a door: its length, and the door before with the leg from there.
#[derive(Clone, Copy, Debug)]
struct Chain {
    length: Length,
    before: Option<(DoorId, Leg, Direction)>,
}

impl<'a> Survey<'a> {
    const fn new(lmpp: &'a Lmpp, expanded: u32) -> Self {
        Self { lmpp, expanded, near: BTreeMap::new(), exits: BTreeMap::new(), doors: BTreeMap::new() }
    }

    /// Dijkstra's algorithm over the doors, from all exits at once: part II for all targets.
    fn chain_doors(&mut self) {
        let mut open: BinaryHeap<_> = BinaryHeap::new();
        for (&door, path) in &self.exits {
            self.doors.insert(door, Chain { length: path.length(), before: None });
            open.push(Reverse((path.length(), door)));
        }
        while let Some(Reverse((length, door))) = open.pop() {
            if self.doors.get(&door).is_some_and(|chain| chain.length < length) {
                continue;
            }
            for (next, leg, direction) in self.lmpp.banks.from_door(door) {
                let length = length + leg.length;
                if self.doors.get(&next).is_none_or(|chain| length < chain.length) {
                    self.doors.insert(next, Chain { length, before: Some((door, leg, direction)) });
                    open.push(Reverse((length, next)));
                }
            }
        }
    }

    /// How many nodes the search expanded.
    #[must_use]
    pub const fn expanded(&self) -> u32 {
        self.expanded
    }

    /// The length of the path to a target; `None` if no chain of open doors leads there.
    #[must_use]
    pub fn length_to(&self, target: u16) -> Option<Length> {
        match self.near.get(&target) {
            Some(path) => Some(path.length()),
            None => Some(self.last_door(target)?.0),
        }
    }

    /// All reachable targets with the lengths of their paths, in the site's order.
    pub fn lengths(&self) -> impl Iterator<Item = (u16, Length)> + '_ {
        self.lmpp.targets.iter().filter_map(|target| Some((target.id, self.length_to(target.id)?)))
    }

    /// The nearest target; of equals the one with the lowest number.
    #[must_use]
    pub fn nearest(&self) -> Option<(u16, Length)> {
        self.lengths().min_by_key(|&(id, length)| (length, id))
    }

    /// The path to a target; `None` if no chain of open doors leads there.
    #[must_use]
    pub fn route_to(&self, target: u16) -> Option<Route> {
        if let Some(path) = self.near.get(&target) {
            return Some(Route { path: path.clone(), doors: Vec::new() });
        }
        let banks = &self.lmpp.banks;
        let (_, mut door, last) = self.last_door(target)?;
        let mut legs = vec![(last, Direction::Forth)];
        let mut doors = vec![door];
        while let Some((before, leg, direction)) = self.doors.get(&door)?.before {
            legs.push((leg, direction));
            doors.push(before);
            door = before;
        }
        doors.reverse();
        let path =
            legs.into_iter().rev().try_fold(self.exits.get(&door)?.clone(), |path, (leg, direction)| {
                path.then(&banks.recall(leg, direction))
            })?;
        Some(Route { path, doors })
    }

    /// The door from which a target is reached best: the whole length, the door and part III.
    fn last_door(&self, target: u16) -> Option<(Length, DoorId, Leg)> {
        self.doors
            .iter()
            .filter_map(|(&door, chain)| {
                let leg = self.lmpp.banks.to_target(door, target)?;
                Some((chain.length + leg.length, door, leg))
            })
            .min_by_key(|&(length, door, _)| (length, door))
    }
}
