//! One shortest augmenting path: who changes partners so that a row and a column find theirs.
//!
//! Dijkstra's algorithm from a row without partner to a column without, over reduced costs (cost
//! less both prices): from a row to any column, from a column back to its partner. Columns are kept
//! in plain arrays that are read from end to end, which for some hundreds beats any heap. Sums are
//! exact, so who reached a column first need not be noted: it is found again by comparing.

use std::array::from_fn;

use super::{Assignment, LANES};

/// The memory of a search.
#[derive(Clone, Debug, Default)]
pub(super) struct Search {
    /// How far each column is that was reached and is not done; infinite for all others.
    distances: Vec<f64>,
    /// The columns' prices; minus infinity for those that are done, which puts them out of reach.
    prices: Vec<f64>,
    done_columns: Vec<(usize, f64)>,
    /// Row, distance, and distance less the row's price.
    done_rows: Vec<(usize, f64, f64)>,
    /// Whether the idle node was reached through a column without partner; which.
    idle_through: Option<usize>,
    idle_done: bool,
}

impl Search {
    fn begin(&mut self, column_prices: &[f64]) {
        super::refill(&mut self.distances, column_prices.len(), f64::INFINITY);
        self.prices.clear();
        self.prices.extend_from_slice(column_prices);
        self.done_columns.clear();
        self.done_rows.clear();
        self.idle_through = None;
        self.idle_done = false;
    }

    fn finish_column(&mut self, column: usize, distance: f64) {
        self.distances[column] = f64::INFINITY;
        self.prices[column] = f64::NEG_INFINITY;
        self.done_columns.push((column, distance));
    }

    /// Reaches all columns through a row; returns the least distance of those not done.
    fn scan(&mut self, row: usize, distance: f64, price: f64, costs: &[f64]) -> f64 {
        let base = distance - price;
        self.done_rows.push((row, distance, base));
        let mut least = [f64::INFINITY; LANES];
        let lanes = self
            .distances
            .as_chunks_mut::<LANES>()
            .0
            .iter_mut()
            .zip(self.prices.as_chunks::<LANES>().0.iter());
        for ((distances, prices), costs) in lanes.zip(costs.as_chunks::<LANES>().0) {
            // Step by step over all lanes: only so do compilers take several at once.
            let through: [f64; LANES] = from_fn(|lane| base + (costs[lane] - prices[lane]));
            let nearer: [f64; LANES] = from_fn(|lane| lesser(through[lane], distances[lane]));
            least = from_fn(|lane| lesser(nearer[lane], least[lane]));
            *distances = nearer;
        }
        least.into_iter().fold(f64::INFINITY, lesser)
    }
}

/// The lesser of two, neither of which is NaN: one instruction, where `f64::min` takes several.
pub(super) fn lesser(one: f64, other: f64) -> f64 {
    if one < other { one } else { other }
}

/// The greater of two, likewise.
pub(super) fn greater(one: f64, other: f64) -> f64 {
    if one > other { one } else { other }
}

/// The least reduced cost of a row whose price is 0.
pub(super) fn least(costs: &[f64], prices: &[f64]) -> f64 {
    let mut least = [f64::INFINITY; LANES];
    for (costs, prices) in costs.as_chunks::<LANES>().0.iter().zip(prices.as_chunks::<LANES>().0) {
        least = from_fn(|lane| lesser(costs[lane] - prices[lane], least[lane]));
    }
    least.into_iter().fold(f64::INFINITY, lesser)
}

/// The place of the first of some values that is `value`.
pub(super) fn first(values: &[f64], value: f64) -> Option<usize> {
    // All of a chunk at once, and only then which.
    let has = |values: &[f64; LANES]| values.iter().fold(false, |any, &found| any | (found == value));
    let (chunk, values) = values.as_chunks::<LANES>().0.iter().enumerate().find(|(_, values)| has(values))?;
    Some(chunk * LANES + values.iter().position(|&found| found == value)?)
}

impl Assignment {
    /// Finds partners for a row and a column that have none, by one shortest path from the one to the
    /// other; either may be the idle node.
    pub(super) fn augment(&mut self, row: usize, column: usize) {
        self.search.begin(&self.column_prices);
        let (end, distance) = self.find(row, column);
        self.change_partners(row, end, distance);
        self.reprice(distance);
    }

    /// Searches from `source` to `target`; returns the last column of the path, and how far it is.
    fn find(&mut self, source: usize, target: usize) -> (usize, f64) {
        let idle = self.columns;
        let mut least =
            if source == self.rows { self.reach_idle(source, 0.0) } else { self.scan(source, 0.0) };
        loop {
            if self.search.distances[target] <= least {
                return (target, least);
            }
            // There always is one: every row reaches the idle node, and that reaches every column.
            let Some(column) = first(&self.search.distances, least) else { return (target, least) };
            let partner = self.of_column.get(column).copied();
            if target == idle && partner == Some(self.rows) {
                return (column, least);
            }
            let distance = least;
            if column < idle {
                self.search.finish_column(column, distance);
            }
            least = match partner {
                Some(row) if row < self.rows => self.scan(row, distance),
                // A column without partner is the idle row's, and so leads to the idle node.
                Some(_) if self.search.idle_done => self.least_left(),
                Some(_) => {
                    self.search.idle_through = Some(column);
                    self.reach_idle(source, distance)
                }
                None => self.reach_idle(source, distance),
            };
        }
    }

    fn scan(&mut self, row: usize, distance: f64) -> f64 {
        let stride = self.stride();
        let costs = &self.costs[row * stride..][..stride];
        self.search.scan(row, distance, self.row_prices[row], costs)
    }

    /// The idle node was reached: it leads to every column, and to the columns of all rows it has.
    fn reach_idle(&mut self, source: usize, distance: f64) -> f64 {
        self.search.idle_done = true;
        self.search.finish_column(self.columns, distance);
        let mut least = self.scan(self.rows, distance);
        for row in (0..self.rows).filter(|&row| row != source) {
            if self.of_row[row] == self.columns {
                least = self.scan(row, distance);
            }
        }
        least
    }

    fn least_left(&self) -> f64 {
        self.search.distances.iter().copied().fold(f64::INFINITY, lesser)
    }

    /// Changes the prices so that the path found costs nothing and nothing costs less.
    fn reprice(&mut self, distance: f64) {
        for &(column, at) in &self.search.done_columns {
            self.column_prices[column] -= distance - at;
        }
        for &(row, at, _) in &self.search.done_rows {
            self.row_prices[row] += distance - at;
        }
        // The idle node's prices are 0: all others move instead.
        let shift = self.row_prices[self.rows];
        if shift != 0.0 {
            self.row_prices.iter_mut().for_each(|price| *price -= shift);
            self.column_prices.iter_mut().for_each(|price| *price += shift);
        }
    }

    /// Goes the path back from its last column; who reached a column becomes its partner.
    fn change_partners(&mut self, source: usize, end: usize, distance: f64) {
        let idle = self.columns;
        let mut column = end;
        loop {
            if column == idle {
                if source == self.rows {
                    return;
                }
                column = self.search.idle_through.unwrap_or(idle);
            }
            let done = self.search.done_columns.iter().find(|done| done.0 == column);
            let row = self.reached_by(column, done.map_or(distance, |done| done.1));
            let before = self.of_row.get(row).copied().unwrap_or(idle);
            self.pair(row, column);
            if row == source {
                return;
            }
            column = before;
        }
    }

    /// The first row through which a column has its distance.
    fn reached_by(&self, column: usize, distance: f64) -> usize {
        let (stride, price) = (self.stride(), self.column_prices[column]);
        let reaches = |&&(row, _, base): &&(usize, f64, f64)| {
            base + (self.costs[row * stride + column] - price) == distance
        };
        self.search.done_rows.iter().find(reaches).map_or(self.rows, |done| done.0)
    }
}
