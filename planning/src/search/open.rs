//! The open list of a search: a bucket queue on integer costs.
//!
//! Entries are sorted into buckets half a cell wide and come out of a bucket last in, first out, so
//! that of equally promising nodes the search follows the one it has just reached. Within a bucket the
//! order is not exact: a search must be ready to reach a node again by a shorter way, which never
//! happens where every move costs more than a bucket's width (Dijkstra).

use crate::{grid::Cell, moves::Cost};

/// A bucket is 2^31 of 2^32 parts of a cell wide.
const WIDTH_BITS: u32 = 31;
const END: u32 = u32::MAX;

/// Cells by rising cost.
#[derive(Clone, Debug, Default)]
pub(crate) struct Open {
    /// The cost of the first bucket.
    base: Cost,
    /// For each bucket the last entry put in.
    buckets: Vec<u32>,
    /// The bucket entries are taken from.
    current: usize,
    entries: Vec<Entry>,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    /// The entry put into the same bucket before.
    before: u32,
    x: u16,
    y: u16,
}

impl Open {
    /// Empties the list; no later entry may cost less than `base`.
    pub(crate) fn begin(&mut self, base: Cost) {
        self.base = base;
        self.buckets.clear();
        self.current = 0;
        self.entries.clear();
    }

    /// Puts in `cell`, which is inside a grid.
    #[inline]
    pub(crate) fn push(&mut self, cost: Cost, cell: Cell) {
        // Where rounding made a cost sink, it sank by less than a bucket.
        let bucket = (((cost - self.base) >> WIDTH_BITS) as usize).max(self.current);
        if bucket >= self.buckets.len() {
            self.buckets.resize(bucket + 1, END);
        }
        let entry = self.entries.len() as u32;
        let before = std::mem::replace(&mut self.buckets[bucket], entry);
        self.entries.push(Entry { before, x: cell.x as u16, y: cell.y as u16 });
    }

    /// Takes out a cell of the lowest bucket, unless all that are left cost `bound` or more.
    #[inline]
    pub(crate) fn pop(&mut self, bound: Cost) -> Option<Cell> {
        loop {
            let bucket = self.buckets.get_mut(self.current)?;
            if *bucket != END {
                let entry = self.entries[*bucket as usize];
                *bucket = entry.before;
                return Some(Cell { x: entry.x.into(), y: entry.y.into() });
            }
            self.current += 1;
            if self.base.saturating_add((self.current as Cost) << WIDTH_BITS) >= bound {
                return None;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn cells_come_out_by_rising_cost_to_a_buckets_width(
            costs in prop::collection::vec(0u64..1 << 36, 0..50),
        ) {
            let mut open = Open::default();
            open.begin(0);
            (0..).zip(&costs).for_each(|(x, &cost)| open.push(cost, Cell { x, y: 65_534 }));
            let out: Vec<_> = std::iter::from_fn(|| open.pop(Cost::MAX)).map(|cell| costs[cell.x as usize]).collect();
            prop_assert!(out.iter().zip(out.iter().skip(1)).all(|(one, next)| *next + (1 << WIDTH_BITS) > *one));
            prop_assert_eq!(out.len(), costs.len());
        }
    }
}
