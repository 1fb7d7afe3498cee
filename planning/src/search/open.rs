//! The open list of a search: a bucket queue on integer costs.
//!
//! Entries are sorted into buckets half a cell wide and come out of a bucket last in, first out, so
//! that of equally promising nodes the search follows the one it has just reached. Within a bucket the
//! order is not exact: a search must be ready to reach a node again by a shorter way, which never
//! happens where every move costs more than a bucket's width (Dijkstra).

use crate::moves::Cost;

/// A bucket is 2^31 of 2^32 parts of a cell wide.
const WIDTH_BITS: u32 = 31;
const END: u32 = u32::MAX;

/// Items by rising cost.
#[derive(Clone, Debug)]
pub(crate) struct Open<T> {
    /// The cost of the first bucket.
    base: Cost,
    /// For each bucket the last entry put in.
    buckets: Vec<u32>,
    /// The bucket entries are taken from.
    current: usize,
    entries: Vec<Entry<T>>,
    /// The last entry taken out, whose place is the next to be filled: few places are in use, and they
    /// stay in the processor's nearest memory.
    free: u32,
}

#[derive(Clone, Copy, Debug)]
struct Entry<T> {
    item: T,
    /// The entry put into the same bucket before, or taken out before.
    before: u32,
}

impl<T> Default for Open<T> {
    fn default() -> Self {
        Self { base: 0, buckets: Vec::new(), current: 0, entries: Vec::new(), free: END }
    }
}

impl<T: Copy> Open<T> {
    /// Empties the list; no later item may cost less than `base`.
    pub(crate) fn begin(&mut self, base: Cost) {
        self.base = base;
        self.buckets.clear();
        self.current = 0;
        self.entries.clear();
        self.free = END;
    }

    /// Puts in an item.
    #[inline]
    pub(crate) fn push(&mut self, cost: Cost, item: T) {
        // Where rounding made a cost sink, it sank by less than a bucket.
        let bucket = ((cost.saturating_sub(self.base) >> WIDTH_BITS) as usize).max(self.current);
        if bucket >= self.buckets.len() {
            self.buckets.resize(bucket + 1, END);
        }
        let before = self.buckets[bucket];
        let entry = Entry { item, before };
        match self.entries.get_mut(self.free as usize) {
            Some(free) => {
                self.buckets[bucket] = self.free;
                self.free = std::mem::replace(free, entry).before;
            }
            None => {
                self.buckets[bucket] = self.entries.len() as u32;
                self.entries.push(entry);
            }
        }
    }

    /// Takes out an item of the lowest bucket, unless all that are left cost `bound` or more.
    #[inline]
    pub(crate) fn pop(&mut self, bound: Cost) -> Option<T> {
        loop {
            let bucket = self.buckets.get_mut(self.current)?;
            if let Some(entry) = self.entries.get_mut(*bucket as usize) {
                let taken = std::mem::replace(bucket, entry.before);
                entry.before = std::mem::replace(&mut self.free, taken);
                return Some(entry.item);
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
        fn items_come_out_by_rising_cost_to_a_buckets_width(
            costs in prop::collection::vec(0u64..1 << 36, 0..50),
        ) {
            let mut open = Open::default();
            open.begin(0);
            (0..).zip(&costs).for_each(|(number, &cost)| open.push(cost, number));
            let out: Vec<_> = std::iter::from_fn(|| open.pop(Cost::MAX)).map(|number: usize| costs[number]).collect();
            prop_assert!(out.iter().zip(out.iter().skip(1)).all(|(one, next)| *next + (1 << WIDTH_BITS) > *one));
            prop_assert_eq!(out.len(), costs.len());
        }
    }
}
