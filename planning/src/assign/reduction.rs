//! The start of a solution: rows bid for columns, which is cheap and pairs most of them.
//!
//! The augmenting row reduction of Jonker and Volgenant. A row takes the column that is best for it and
//! lowers its price until the second best is as good; who had the column before bids next. Only columns
//! that have a partner ever get a price below 0, as the idle row demands.

use std::array::from_fn;

use super::{
    Assignment, LANES,
    search::{self, greater, least, lesser},
};

/// So many bids a row, on average; whoever has no column then gets one by an augmenting path.
const BIDS: usize = 2;

impl Assignment {
    /// Finds partners for all rows, none of which has one.
    pub(super) fn reduce_rows(&mut self) {
        let mut left = std::mem::take(&mut self.left);
        left.clear();
        let mut bids = BIDS * self.rows;
        for row in 0..self.rows {
            let mut bidder = Some(row);
            while let Some(row) = bidder.take_if(|_| bids > 0) {
                bids -= 1;
                match self.bid(row) {
                    Bid::Took { outbid } => bidder = outbid,
                    Bid::Tied => left.push(row),
                }
            }
            left.extend(bidder);
        }
        for &row in &left {
            self.row_prices[row] = least(self.row(row), &self.column_prices);
            self.augment(row, self.columns);
        }
        self.left = left;
    }

    fn bid(&mut self, row: usize) -> Bid {
        let stride = self.stride();
        let costs = &self.costs[row * stride..][..stride];
        let (first, second) = two_least(costs, &self.column_prices, &mut self.reduced);
        let is_free = |column: usize| self.of_column.get(column).is_none_or(|&row| row == self.rows);
        let best = if second > first {
            search::first(&self.reduced, first)
        } else {
            (0..=self.columns).find(|&column| self.reduced[column] == first && is_free(column))
        };
        let Some(best) = best else { return Bid::Tied };
        if best == self.columns {
            // The idle node takes everybody: nobody is outbid and its price stays 0.
            self.row_prices[row] = first;
            return Bid::Took { outbid: None };
        }
        self.row_prices[row] = second;
        self.column_prices[best] -= second - first;
        let before = self.of_column[best];
        self.pair(before, self.columns);
        self.pair(row, best);
        Bid::Took { outbid: (before < self.rows).then_some(before) }
    }
}

/// What came of a bid.
enum Bid {
    /// The row has a column now.
    Took {
        /// The row that had it before.
        outbid: Option<usize>,
    },
    /// Several columns are equally good, and all of them taken.
    Tied,
}

/// The two least reduced costs of a row whose price is 0; all of them go into `reduced`.
fn two_least(costs: &[f64], prices: &[f64], reduced: &mut [f64]) -> (f64, f64) {
    let mut firsts = [f64::INFINITY; LANES];
    let mut seconds = [f64::INFINITY; LANES];
    let lanes = costs.as_chunks::<LANES>().0.iter().zip(prices.as_chunks::<LANES>().0.iter());
    for ((costs, prices), reduced) in lanes.zip(reduced.as_chunks_mut::<LANES>().0.iter_mut()) {
        *reduced = from_fn(|lane| costs[lane] - prices[lane]);
        let losers: [f64; LANES] = from_fn(|lane| greater(reduced[lane], firsts[lane]));
        seconds = from_fn(|lane| lesser(losers[lane], seconds[lane]));
        firsts = from_fn(|lane| lesser(reduced[lane], firsts[lane]));
    }
    firsts.into_iter().chain(seconds).fold((f64::INFINITY, f64::INFINITY), |(first, second), cost| {
        if cost < first { (cost, first) } else { (first, lesser(cost, second)) }
    })
}
