//! The best way through doors from every door to every target (LMPP Algorithm 6, parts II and III), put
//! together from the memory banks once.

use std::{cmp::Reverse, collections::BinaryHeap, ops::Range};

use crate::{
    grid::Cell,
    memory::{Banks, Direction, Leg, Target},
    moves::Length,
    path::Path,
    rooms::{Door, DoorId},
};

/// For every door, target by target, the best way.
#[derive(Clone, Debug, Default)]
pub(super) struct Chains {
    targets: usize,
    table: Vec<Option<Chain>>,
    /// The waypoints of all ways, and the doors that they pass.
    waypoints: Vec<Cell>,
    doors: Vec<DoorId>,
}

/// A way from a door to a target.
#[derive(Clone, Debug)]
struct Chain {
    length: Length,
    waypoints: Range<usize>,
    doors: Range<usize>,
}

/// How it goes on from a door to a target: how far it is, and over which stored path first.
#[derive(Clone, Copy)]
struct Link {
    length: Length,
    leg: Leg,
    direction: Direction,
    /// The next door, by its place in the site's list; none after the last.
    next: Option<usize>,
}

impl Chains {
    /// Finds them for the doors and targets of a site.
    pub fn find(doors: &[Door], targets: &[Target], banks: &Banks) -> Self {
        let table = vec![None; doors.len() * targets.len()];
        let mut chains = Self { targets: targets.len(), table, ..Self::default() };
        for (number, target) in targets.iter().enumerate() {
            let links = links(doors, target, banks);
            for first in 0..doors.len() {
                let chain = chains.join(doors, &links, first, banks);
                if let Some(entry) = chains.table.get_mut(first * targets.len() + number) {
                    *entry = chain;
                }
            }
        }
        chains
    }

    /// Puts the paths of a chain of doors together.
    fn join(&mut self, doors: &[Door], links: &[Option<Link>], first: usize, banks: &Banks) -> Option<Chain> {
        let mut path = Path::at(doors.get(first)?.cell);
        let doors_start = self.doors.len();
        let mut place = Some(first);
        while let Some(door) = place {
            let link = links.get(door).copied().flatten()?;
            self.doors.push(doors.get(door)?.id);
            path = path.then(&banks.recall(link.leg, link.direction))?;
            place = link.next;
        }
        let start = self.waypoints.len();
        self.waypoints.extend_from_slice(path.waypoints());
        Some(Chain {
            length: path.length(),
            waypoints: start..self.waypoints.len(),
            doors: doors_start..self.doors.len(),
        })
    }

    fn get(&self, door: usize, target: usize) -> Option<&Chain> {
        self.table.get(door * self.targets + target)?.as_ref()
    }

    /// The length of the best way from a door to a target, both by their places in the site's lists.
    #[inline]
    pub fn length(&self, door: usize, target: usize) -> Option<Length> {
        Some(self.get(door, target)?.length)
    }

    /// Goes on by it from the door that `path` leads to; returns the doors on it, that one first. None is
    /// returned and gone where there is no way.
    #[inline]
    pub fn recall_onto(&self, door: usize, target: usize, path: &mut Path) -> &[DoorId] {
        let Some(chain) = self.get(door, target) else { return &[] };
        path.append(self.waypoints.get(chain.waypoints.clone()).unwrap_or_default(), chain.length);
        self.doors.get(chain.doors.clone()).unwrap_or_default()
    }

    /// The doors on it, that one first; none where there is no way.
    pub fn doors(&self, door: usize, target: usize) -> &[DoorId] {
        self.get(door, target).and_then(|chain| self.doors.get(chain.doors.clone())).unwrap_or_default()
    }

    /// What they take, in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.table.as_slice())
            + size_of_val(self.waypoints.as_slice())
            + size_of_val(self.doors.as_slice())
    }
}

/// The best way on from each door to a target: Dijkstra's algorithm over the doors from the target, where
/// Algorithm 6 tries every pair of doors for every robot that asks.
fn links(doors: &[Door], target: &Target, banks: &Banks) -> Vec<Option<Link>> {
    let mut links: Vec<Option<Link>> = vec![None; doors.len()];
    let mut open = BinaryHeap::new();
    for (place, door) in doors.iter().enumerate() {
        if let (Some(leg), Some(link)) = (banks.to_target(door.id, target.id), links.get_mut(place)) {
            *link = Some(Link { length: leg.length, leg, direction: Direction::Forth, next: None });
            open.push(Reverse((leg.length, door.id, place)));
        }
    }
    while let Some(Reverse((length, door, place))) = open.pop() {
        if links.get(place).copied().flatten().is_some_and(|link| link.length < length) {
            continue;
        }
        for (before, leg, direction) in banks.from_door(door) {
            let Some(before_place) = doors.iter().position(|door| door.id == before) else { continue };
            let length = length + leg.length;
            let Some(link) = links.get_mut(before_place) else { continue };
            if link.is_none_or(|known| length < known.length) {
                *link = Some(Link { length, leg, direction: direction.turned(), next: Some(place) });
                open.push(Reverse((length, before, before_place)));
            }
        }
    }
    links
}
