//! The best chain of doors from every door to every target (LMPP Algorithm 6, part II), found once.

use std::{
    cmp::Reverse,
    collections::{BTreeMap, BinaryHeap},
};

use crate::{
    memory::{Banks, Direction, Leg, Target},
    moves::Length,
    rooms::{Door, DoorId},
};

/// How it goes on from a door to a target: how long, and over which stored path first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chain {
    pub length: Length,
    pub next: Next,
}

/// The next stored path of a chain.
#[derive(Clone, Copy, Debug)]
pub(super) enum Next {
    /// From the door to the target: M1.
    Target(Leg),
    /// To another door, by its place in the site's list: M2.
    Door(usize, Leg, Direction),
}

/// For every door, target by target, the best chain.
#[derive(Clone, Debug, Default)]
pub(super) struct Chains {
    targets: usize,
    table: Vec<Option<Chain>>,
}

impl Chains {
    /// Dijkstra's algorithm over the doors from each target, where Algorithm 6 tries every pair of doors
    /// for every robot that asks.
    pub fn find(doors: &[Door], targets: &[Target], banks: &Banks) -> Self {
        let mut chains = Self { targets: targets.len(), table: vec![None; doors.len() * targets.len()] };
        let places: BTreeMap<DoorId, usize> = doors.iter().map(|door| door.id).zip(0..).collect();
        for (number, target) in targets.iter().enumerate() {
            let mut open = BinaryHeap::new();
            for (place, door) in doors.iter().enumerate() {
                if let Some(leg) = banks.to_target(door.id, target.id) {
                    let chain = Chain { length: leg.length, next: Next::Target(leg) };
                    chains.shorten(place, number, chain);
                    open.push(Reverse((leg.length, door.id)));
                }
            }
            while let Some(Reverse((length, door))) = open.pop() {
                let Some(&place) = places.get(&door) else { continue };
                if chains.get(place, number).is_some_and(|chain| chain.length < length) {
                    continue;
                }
                for (before, leg, direction) in banks.from_door(door) {
                    let Some(&before_place) = places.get(&before) else { continue };
                    let length = length + leg.length;
                    let next = Next::Door(place, leg, direction.turned());
                    if chains.shorten(before_place, number, Chain { length, next }) {
                        open.push(Reverse((length, before)));
                    }
                }
            }
        }
        chains
    }

    /// Keeps a chain if it is the shortest so far.
    fn shorten(&mut self, door: usize, target: usize, chain: Chain) -> bool {
        let Some(known) = self.table.get_mut(door * self.targets + target) else { return false };
        let is_shorter = known.is_none_or(|known| chain.length < known.length);
        if is_shorter {
            *known = Some(chain);
        }
        is_shorter
    }

    /// The best chain from a door to a target, by their places in the site's lists.
    #[inline]
    pub fn get(&self, door: usize, target: usize) -> Option<Chain> {
        self.table.get(door * self.targets + target).copied().flatten()
    }

    /// What they take, in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.table.as_slice())
    }
}
