//! The memory banks: paths that never change, planned once (LMPP section IV.A).
//!
//! M1 holds the path from each pile to the doors of its subarea (Algorithm 3), M2 the paths between
//! the doors of each subarea (Algorithm 4). Paths are planned on the whole map, as in the paper, and
//! kept as waypoints in one array, four bytes each. [`Banks::recall`] looks a path up by the place
//! it was stored at, where Algorithm 5 scans the bank.

use std::collections::{BTreeMap, BTreeSet};

use super::Fields;
use crate::{
    grid::Cell,
    moves::Length,
    path::Path,
    rooms::{Door, DoorId, Rooms, SubareaId},
};

/// A known target, such as a charging pile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Target {
    /// Its number.
    pub id: u16,
    /// Where it is.
    pub cell: Cell,
}

/// Which doors LMPP may use from where.
///
/// [`DoorSets::of`] is what Algorithms 2 and 4 say. A site whose subareas hang together by more
/// than its listed doors may add to it; the runs behind some of the paper's tables did.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DoorSets {
    /// The doors a robot in a subarea may make for first.
    pub exits: BTreeMap<SubareaId, BTreeSet<DoorId>>,
    /// The pairs of doors between which M2 holds a path, the lower number first.
    pub pairs: BTreeSet<(DoorId, DoorId)>,
}

impl DoorSets {
    /// The doors of each subarea, and all pairs of them.
    #[must_use]
    pub fn of(rooms: &Rooms) -> Self {
        let exits: BTreeMap<_, BTreeSet<_>> = rooms
            .subareas()
            .iter()
            .map(|(subarea, _)| (subarea, rooms.doors_of(subarea).map(|door| door.id).collect()))
            .collect();
        let pairs = exits
            .values()
            .flat_map(|doors: &BTreeSet<DoorId>| {
                doors.iter().flat_map(|&one| doors.range(one..).skip(1).map(move |&other| (one, other)))
            })
            .collect();
        Self { exits, pairs }
    }
}

/// A stored path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Leg {
    start: u32,
    end: u32,
    /// How long it is.
    pub length: Length,
}

/// Both memory banks.
#[derive(Clone, Debug, Default)]
pub struct Banks {
    waypoints: Vec<(u16, u16)>,
    /// M1: from a door to a target.
    targets: BTreeMap<(DoorId, u16), Leg>,
    /// M2: from the first door to the second, and the leg back.
    doors: BTreeMap<DoorId, Vec<(DoorId, Leg, Direction)>>,
}

/// Whether a stored path is meant as it is stored or the other way round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// As it is stored.
    Forth,
    /// From its end to its start.
    Back,
}

impl Direction {
    /// The other way round.
    #[must_use]
    pub const fn turned(self) -> Self {
        match self {
            Self::Forth => Self::Back,
            Self::Back => Self::Forth,
        }
    }
}

impl Banks {
    /// Stores M1 and M2 without the doors in `closed`. Targets and pairs of doors between which there is
    /// no path are left out.
    ///
    /// Paths are walks through `fields`, of the ways to all doors and then to all targets on the map where
    /// closed doors are blocked: nothing is searched twice.
    #[must_use]
    pub fn build(
        fields: &Fields,
        rooms: &Rooms,
        sets: &DoorSets,
        targets: &[Target],
        closed: &BTreeSet<DoorId>,
    ) -> Self {
        let mut banks = Self::default();
        let mut path = Path::default();
        let doors = rooms.doors();
        let is_open = |door: &Door| !closed.contains(&door.id);
        for door in doors.iter().filter(|door| is_open(door)) {
            for (field, target) in (doors.len()..).zip(targets) {
                let subarea = rooms.find_subarea(target.cell);
                if subarea.is_some_and(|subarea| door.joins.contains(&subarea))
                    && fields.walk(door.cell, field, &mut path)
                    && let Some(leg) = banks.store(&path)
                {
                    banks.targets.insert((door.id, target.id), leg);
                }
            }
            for (field, other) in doors.iter().enumerate().filter(|(_, other)| is_open(other)) {
                if sets.pairs.contains(&(door.id, other.id))
                    && fields.walk(door.cell, field, &mut path)
                    && let Some(leg) = banks.store(&path)
                {
                    banks.doors.entry(door.id).or_default().push((other.id, leg, Direction::Forth));
                    banks.doors.entry(other.id).or_default().push((door.id, leg, Direction::Back));
                }
            }
        }
        banks
    }

    fn store(&mut self, path: &Path) -> Option<Leg> {
        let start = u32::try_from(self.waypoints.len()).ok()?;
        for cell in path.waypoints() {
            self.waypoints.push((u16::try_from(cell.x).ok()?, u16::try_from(cell.y).ok()?));
        }
        let end = u32::try_from(self.waypoints.len()).ok()?;
        Some(Leg { start, end, length: path.length() })
    }

    /// M1: the path from a door to a target in a subarea of it.
    #[must_use]
    pub fn to_target(&self, door: DoorId, target: u16) -> Option<Leg> {
        self.targets.get(&(door, target)).copied()
    }

    /// M2: the paths from a door to others.
    pub fn from_door(&self, door: DoorId) -> impl Iterator<Item = (DoorId, Leg, Direction)> + '_ {
        self.doors.get(&door).into_iter().flatten().copied()
    }

    /// The stored path (LMPP Algorithm 5, by place).
    #[must_use]
    pub fn recall(&self, leg: Leg, direction: Direction) -> Path {
        let stored = self.waypoints.get(leg.start as usize..leg.end as usize).unwrap_or_default();
        let waypoints = stored.iter().map(|&(x, y)| Cell { x: x.into(), y: y.into() }).collect();
        let path = Path::from_parts(waypoints, leg.length);
        match direction {
            Direction::Forth => path,
            Direction::Back => path.reversed(),
        }
    }

    /// How many paths are stored.
    #[must_use]
    pub fn len(&self) -> usize {
        self.targets.len() + self.doors.values().map(Vec::len).sum::<usize>() / 2
    }

    /// Whether no path is stored.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What the stored waypoints and legs take, in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(self.waypoints.as_slice()) + self.len() * size_of::<Leg>()
    }
}
