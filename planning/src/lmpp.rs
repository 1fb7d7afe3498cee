//! Local memorial path planning (LMPP Algorithm 6, keeping the shortest path).
//!
//! A path from a robot to a pile has three parts: from the robot to a door of its subarea, from door
//! to door, and from the last door to the pile. The paper searches for the first part and recalls
//! the others from memory. Here the first part is recalled too: every door keeps a [`Field`] of the
//! ways to it from the subareas around, and every pile one of its own subarea, so that nothing is
//! searched for but the chain of doors.
//!
//! A [`Survey`] of a robot's position answers for all piles at once: one walk over the doors' graph
//! finds the best chain to each, where Algorithm 6 tries every pair of doors.

use std::{
    cmp::Reverse,
    collections::{BTreeMap, BTreeSet, BinaryHeap},
};

use crate::{
    field::Field,
    grid::{Cell, Grid},
    memory::{Banks, Direction, DoorSets, Leg, Target},
    moves::{Length, MoveSet},
    path::Path,
    rooms::{DoorId, Rooms, SubareaId},
    search::{SearchError, Workspace, free_index},
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
    banks: Banks,
    /// The ways to each open door from the subareas whose robots may make for it.
    to_doors: BTreeMap<DoorId, Field>,
    /// The ways to each target from its own subarea.
    to_targets: BTreeMap<u16, Field>,
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
        let mut lmpp = Self {
            grid,
            moves,
            rooms,
            sets,
            targets,
            closed: BTreeSet::new(),
            banks: Banks::default(),
            to_doors: BTreeMap::new(),
            to_targets: BTreeMap::new(),
        };
        lmpp.memorise();
        lmpp
    }

    /// Closes these doors, such as those [`crate::congestion::avoided`] names, and opens all others.
    /// The memory is planned anew if that changes anything.
    pub fn close(&mut self, closed: BTreeSet<DoorId>) {
        if closed != self.closed {
            self.closed = closed;
            self.memorise();
        }
    }

    fn memorise(&mut self) {
        let Self { grid, moves, rooms, sets, targets, closed, .. } = self;
        self.banks = Banks::build(grid, *moves, rooms, sets, targets, closed);

        let mut workspace = Workspace::default();
        let shut = rooms.doors().iter().filter(|door| closed.contains(&door.id)).map(|door| door.cell);
        let shut: BTreeSet<_> = shut.collect();
        let mut field = |place: Cell, subareas: &[SubareaId]| {
            let inside = |&cell: &Cell| {
                cell == place || rooms.find_subarea(cell).is_some_and(|subarea| subareas.contains(&subarea))
            };
            let around: Vec<_> = grid.free_cells().filter(inside).collect();
            Field::build(grid, *moves, place, &around, &shut, &mut workspace)
        };
        self.to_doors = rooms
            .doors()
            .iter()
            .filter(|door| !closed.contains(&door.id))
            .map(|door| {
                let users = sets.exits.iter().filter(|(_, exits)| exits.contains(&door.id));
                let users: Vec<_> = users.map(|(&subarea, _)| subarea).collect();
                (door.id, field(door.cell, &users))
            })
            .collect();
        self.to_targets = targets
            .iter()
            .map(|target| {
                let own: Vec<_> = rooms.find_subarea(target.cell).into_iter().collect();
                (target.id, field(target.cell, &own))
            })
            .collect();
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

    /// What the memory takes, in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let fields = self.to_doors.values().chain(self.to_targets.values());
        self.banks.bytes() + fields.map(Field::bytes).sum::<usize>()
    }

    /// Looks from `from` to all targets.
    ///
    /// # Errors
    /// [`SearchError`] if `from` is outside the map or in a wall.
    pub fn survey(&self, from: Cell) -> Result<Survey<'_>, SearchError> {
        free_index(&self.grid, from)?;
        let own = self.rooms.find_subarea(from);
        let exits = own.and_then(|subarea| self.sets.exits.get(&subarea)).into_iter().flatten();
        let exits =
            exits.filter_map(|&door| Some((door, self.to_doors.get(&door)?.length(&self.grid, from)?)));
        let near = self.targets.iter().filter(|target| self.rooms.find_subarea(target.cell) == own);
        let near = near.filter_map(|target| {
            Some((target.id, self.to_targets.get(&target.id)?.length(&self.grid, from)?))
        });
        let mut survey =
            Survey { lmpp: self, from, expanded: 0, near: near.collect(), doors: BTreeMap::new() };
        survey.chain_doors(exits.collect());
        Ok(survey)
    }
}

/// What a robot at one place can reach, and how.
#[derive(Clone, Debug)]
pub struct Survey<'a> {
    lmpp: &'a Lmpp,
    from: Cell,
    expanded: u32,
    /// The lengths of the ways to targets in the robot's own subarea.
    near: BTreeMap<u16, Length>,
    /// The best way to every door.
    doors: BTreeMap<DoorId, Chain>,
}

/// The best way to a door: its length, and the door before with the leg from there; none before the
/// first door, to which part I leads.
#[derive(Clone, Copy, Debug)]
struct Chain {
    length: Length,
    before: Option<(DoorId, Leg, Direction)>,
}

impl Survey<'_> {
    /// Dijkstra's algorithm over the doors, from all exits at once: part II for all targets.
    fn chain_doors(&mut self, exits: Vec<(DoorId, Length)>) {
        let mut open: BinaryHeap<_> = BinaryHeap::new();
        for (door, length) in exits {
            self.doors.insert(door, Chain { length, before: None });
            open.push(Reverse((length, door)));
        }
        while let Some(Reverse((length, door))) = open.pop() {
            if self.doors.get(&door).is_some_and(|chain| chain.length < length) {
                continue;
            }
            self.expanded += 1;
            for (next, leg, direction) in self.lmpp.banks.from_door(door) {
                let length = length + leg.length;
                if self.doors.get(&next).is_none_or(|chain| length < chain.length) {
                    self.doors.insert(next, Chain { length, before: Some((door, leg, direction)) });
                    open.push(Reverse((length, next)));
                }
            }
        }
    }

    /// How many nodes of the doors' graph were expanded: no cell is searched.
    #[must_use]
    pub const fn expanded(&self) -> u32 {
        self.expanded
    }

    /// The length of the path to a target; `None` if no chain of open doors leads there.
    #[must_use]
    pub fn length_to(&self, target: u16) -> Option<Length> {
        match self.near.get(&target) {
            Some(&length) => Some(length),
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
        let Lmpp { grid, banks, to_doors, to_targets, .. } = self.lmpp;
        if self.near.contains_key(&target) {
            let path = to_targets.get(&target)?.path(grid, self.from)?;
            return Some(Route { path, doors: Vec::new() });
        }
        let (_, mut door, last) = self.last_door(target)?;
        let mut legs = vec![(last, Direction::Forth)];
        let mut doors = vec![door];
        while let Some((before, leg, direction)) = self.doors.get(&door)?.before {
            legs.push((leg, direction));
            doors.push(before);
            door = before;
        }
        doors.reverse();
        let path = legs
            .into_iter()
            .rev()
            .try_fold(to_doors.get(&door)?.path(grid, self.from)?, |path, (leg, direction)| {
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
