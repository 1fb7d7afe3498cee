//! The open list of a search whose moves have only a few different lengths.
//!
//! Distances come out in rising order; each is then put back longer by one of the lengths. What was put
//! back by the same length is therefore in order by itself: a queue for each length, and a look at the
//! first of each, are an exact priority queue without sorting.

use std::collections::VecDeque;

use super::metric::Metric;

/// Lengths that moves have: straight, diagonal, knight's.
const KINDS: usize = 3;

/// Cells by rising distance.
#[derive(Debug)]
pub(super) struct Frontier<M: Metric> {
    /// One queue for each length; the last is for what the search starts from.
    queues: [VecDeque<(M::Distance, u32)>; KINDS + 1],
}

impl<M: Metric> Default for Frontier<M> {
    fn default() -> Self {
        Self { queues: Default::default() }
    }
}

impl<M: Metric> Frontier<M> {
    /// Starts anew from these cells.
    pub fn start(&mut self, cells: &mut [(M::Distance, u32)]) {
        self.queues.iter_mut().for_each(VecDeque::clear);
        cells.sort_unstable();
        self.queues[KINDS].extend(cells.iter());
    }

    /// Puts in a cell that is reached from the last one taken out, by the move of this number.
    #[inline]
    pub fn push(&mut self, number: usize, distance: M::Distance, cell: u32) {
        let kind = usize::from(number >= 4) + usize::from(number >= 8);
        self.queues[kind].push_back((distance, cell));
    }

    /// Takes out a nearest cell.
    #[inline]
    pub fn pop(&mut self) -> Option<(M::Distance, u32)> {
        let mut nearest = None;
        for (kind, queue) in self.queues.iter().enumerate() {
            // With 8 neighbours there is no third length.
            if kind == 2 && M::MOVES.steps().len() <= 8 {
                continue;
            }
            if let Some(&(distance, _)) = queue.front()
                && nearest.is_none_or(|(least, _)| distance < least)
            {
                nearest = Some((distance, kind));
            }
        }
        self.queues[nearest?.1].pop_front()
    }
}
