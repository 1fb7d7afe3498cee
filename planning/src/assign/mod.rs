//! Which robot goes to which pile: the assignment problem.
//!
//! Rows (robots) are paired with columns (piles), each with at most one. A pair has a cost or is
//! impossible. The best matching has **as many pairs as possible, and of those the least total
//! cost**. There may be more rows than columns or fewer.
//!
//! Solved by shortest augmenting paths (R. Jonker, A. Volgenant, "A shortest augmenting path algorithm
//! for dense and sparse linear assignment problems", Computing 38, 1987). The prices of rows and
//! columns are kept, so that a changed row or column costs one more path and not a new solution.
//!
//! One node stands for "no partner": the *idle* node is both a column that any number of rows may have,
//! at a cost beyond that of all pairs together, and a row that any number of columns may have for
//! nothing. With it every row and column always has a partner, whatever is impossible.
//!
//! Costs are whole numbers kept in doubles, where sums are exact up to 2^53 and every processor
//! compares several at once. So the same calls give the same matching on every machine; of equally
//! good matchings, which one depends on the calls before, as on the order of rows and columns.
//!
//! ```
//! use planning::assign::Assignment;
//!
//! // Metres from three robots to two piles; the last robot can't reach pile 0.
//! let metres = [[Some(5), Some(7)], [Some(4), Some(9)], [None, Some(8)]];
//! let mut assignment = Assignment::default();
//! assignment.solve(3, 2, |robot, pile| metres[robot][pile]);
//! assert_eq!(assignment.pairs().collect::<Vec<_>>(), [(0, 1), (1, 0)]);
//! assert_eq!(assignment.cost(), 11);
//!
//! // Robot 0 has driven off.
//! assignment.set_row(0, |_| None);
//! assert_eq!(assignment.pairs().collect::<Vec<_>>(), [(1, 0), (2, 1)]);
//! ```

mod reduction;
mod search;

use search::{Search, least};

/// How many columns are handled at once; a row is padded to a multiple of it.
const LANES: usize = 8;

/// What a pair costs, in any unit, such as centimetres.
pub type PairCost = u32;

/// A matching of rows with columns, and what it takes to change it.
#[derive(Clone, Debug, Default)]
pub struct Assignment {
    /// A row for each row, then the idle one; a column for each column, then the idle one, then
    /// padding. What is impossible is infinite, as is padding.
    costs: Vec<f64>,
    rows: usize,
    columns: usize,
    /// The prices: cost - row's - column's is never negative, and 0 where paired. The idle node's are 0.
    row_prices: Vec<f64>,
    column_prices: Vec<f64>,
    /// The partner of each row and column; the idle node's number where there is none.
    of_row: Vec<usize>,
    of_column: Vec<usize>,
    /// Rows that got no partner by bidding.
    left: Vec<usize>,
    /// The reduced costs of the row that bids.
    reduced: Vec<f64>,
    search: Search,
}

impl Assignment {
    /// Finds a best matching of `rows` with `columns`; `cost` says what a pair costs, `None` that it is
    /// impossible. What was known before is forgotten; its memory is used again.
    pub fn solve(
        &mut self,
        rows: usize,
        columns: usize,
        mut cost: impl FnMut(usize, usize) -> Option<PairCost>,
    ) {
        self.begin(rows, columns);
        for row in 0..rows {
            self.fill_row(row, |column| cost(row, column));
        }
        self.reduce_rows();
    }

    /// Changes what the pairs of `row` cost and mends the matching. Nothing happens outside.
    pub fn set_row(&mut self, row: usize, cost: impl FnMut(usize) -> Option<PairCost>) {
        if row >= self.rows {
            return;
        }
        self.fill_row(row, cost);
        let left = self.leave_row(row);
        self.row_prices[row] = least(self.row(row), &self.column_prices);
        self.augment(row, left);
    }

    /// Changes what the pairs of `column` cost and mends the matching. Nothing happens outside.
    pub fn set_column(&mut self, column: usize, mut cost: impl FnMut(usize) -> Option<PairCost>) {
        if column >= self.columns {
            return;
        }
        let stride = self.stride();
        // The idle row may always have the column, for nothing.
        let mut price = 0.0_f64;
        for (row, row_price) in self.row_prices.iter().take(self.rows).enumerate() {
            let new = value(cost(row));
            self.costs[row * stride + column] = new;
            price = price.min(new - row_price);
        }
        self.column_prices[column] = price;
        let left = self.leave_column(column);
        self.augment(left, column);
    }

    /// The partner of `row`; `None` if it has none.
    #[must_use]
    pub fn of_row(&self, row: usize) -> Option<usize> {
        self.of_row.get(row).copied().filter(|&column| column < self.columns)
    }

    /// The partner of `column`; `None` if it has none.
    #[must_use]
    pub fn of_column(&self, column: usize) -> Option<usize> {
        self.of_column.get(column).copied().filter(|&row| row < self.rows)
    }

    /// Row and column of each pair, by row.
    pub fn pairs(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.of_row.iter().enumerate().filter_map(|(row, _)| Some((row, self.of_row(row)?)))
    }

    /// By how much a pair has to become cheaper, at least, before a best matching has it: its reduced cost. 0
    /// for a pair that is there, `None` for one that is impossible.
    #[must_use]
    pub fn margin(&self, row: usize, column: usize) -> Option<u64> {
        if row >= self.rows || column >= self.columns {
            return None;
        }
        let cost = self.row(row)[column];
        cost.is_finite().then(|| (cost - self.row_prices[row] - self.column_prices[column]) as u64)
    }

    /// What all pairs cost together.
    #[must_use]
    pub fn cost(&self) -> u64 {
        self.pairs().map(|(row, column)| self.row(row)[column] as u64).sum()
    }

    fn begin(&mut self, rows: usize, columns: usize) {
        (self.rows, self.columns) = (rows, columns);
        let stride = self.stride();
        refill(&mut self.costs, (rows + 1) * stride, f64::INFINITY);
        // The idle row may have every column, itself too, for nothing.
        self.costs[rows * stride..][..=columns].fill(0.0);
        refill(&mut self.row_prices, rows + 1, 0.0);
        refill(&mut self.column_prices, stride, 0.0);
        refill(&mut self.reduced, stride, 0.0);
        refill(&mut self.of_row, rows, columns);
        refill(&mut self.of_column, columns, rows);
    }

    /// Columns, the idle one and padding.
    const fn stride(&self) -> usize {
        (self.columns + 1).next_multiple_of(LANES)
    }

    fn row(&self, row: usize) -> &[f64] {
        let stride = self.stride();
        &self.costs[row * stride..][..stride]
    }

    fn fill_row(&mut self, row: usize, mut cost: impl FnMut(usize) -> Option<PairCost>) {
        // More than all pairs cost together: no pair is given up to make others cheaper.
        let idle = self.rows.min(self.columns) as f64 * 4_294_967_296.0;
        let (columns, stride) = (self.columns, self.stride());
        let costs = &mut self.costs[row * stride..][..=columns];
        for (column, old) in costs.iter_mut().enumerate() {
            *old = if column < columns { value(cost(column)) } else { idle };
        }
    }

    fn pair(&mut self, row: usize, column: usize) {
        if let Some(partner) = self.of_row.get_mut(row) {
            *partner = column;
        }
        if let Some(partner) = self.of_column.get_mut(column) {
            *partner = row;
        }
    }

    /// Takes a row's partner away; returns it.
    fn leave_row(&mut self, row: usize) -> usize {
        let column = self.of_row[row];
        self.pair(row, self.columns);
        self.pair(self.rows, column);
        column
    }

    /// Takes a column's partner away; returns it.
    fn leave_column(&mut self, column: usize) -> usize {
        let row = self.of_column[column];
        self.pair(self.rows, column);
        self.pair(row, self.columns);
        row
    }
}

#[inline]
fn value(cost: Option<PairCost>) -> f64 {
    cost.map_or(f64::INFINITY, f64::from)
}

fn refill<T: Clone>(vector: &mut Vec<T>, length: usize, value: T) {
    vector.clear();
    vector.resize(length, value);
}
