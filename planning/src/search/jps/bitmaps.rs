//! Where jumps end, as bitmaps along the lines that jumps follow.
//!
//! All are made from the map by operations on whole words. A border of one blocked cell is around the
//! map, so that every jump ends: cell (x, y) of the map is at (x + 1, y + 1) here.

use super::{lines::Lines, woven::Woven};
use crate::grid::Grid;

/// In straight lines, for who goes on by rising places: walls, and cells where a turn may be worth while.
/// The next bitmap is the same for who comes back.
pub(super) const STOPS: usize = 0;
/// In straight lines: the free cells.
pub(super) const FREE: usize = 2;
/// In diagonals, for who goes down: cells from which a straight jump leads to a turn. The next bitmap is
/// the same for who goes up.
pub(super) const TURNS: usize = 0;
/// In diagonals: cells from which no diagonal move leads to the next row.
pub(super) const WALLS: usize = 2;

/// All that is kept of a map: 12 bits a cell, and what the border takes.
#[derive(Clone, Debug)]
pub(super) struct Bitmaps {
    pub(super) rows: Woven,
    pub(super) columns: Woven,
    /// The diagonals from the upper left to the lower right; line x - y, place y.
    pub(super) falling: Woven,
    /// The diagonals from the upper right to the lower left; line x + y, place y.
    pub(super) rising: Woven,
}

impl Bitmaps {
    pub(super) fn of(grid: &Grid) -> Self {
        let mut free = Lines::new(grid.height() as usize + 2, grid.width() as usize + 2);
        for y in 0..grid.height() {
            shift_up(grid.row(y as i32), free.line_mut(y as usize + 1));
        }
        let (columns, to_turn) = straight(&free.crossing(0));
        let [south, north] = to_turn.map(|lines| lines.crossing(0));
        let (rows, [east, west]) = straight(&free);
        Self {
            rows,
            columns,
            falling: diagonal(&free, 1, [[&east, &south], [&west, &north]]),
            rising: diagonal(&free, -1, [[&west, &south], [&east, &north]]),
        }
    }

    pub(super) fn bytes(&self) -> usize {
        [&self.rows, &self.columns, &self.falling, &self.rising].map(Woven::bytes).iter().sum()
    }
}

/// Moves a line up by one cell.
fn shift_up(line: &[u64], to: &mut [u64]) {
    let mut carry = 0;
    for (to, from) in to.iter_mut().zip(line.iter().copied().chain([0])) {
        *to = from << 1 | carry;
        carry = from >> 63;
    }
}

/// The word of a line, each cell in its [lower, upper] neighbour's place.
fn neighbours(line: &[u64], index: usize) -> [u64; 2] {
    let word = line[index];
    let before = if index == 0 { 0 } else { line[index - 1] };
    let after = line.get(index + 1).copied().unwrap_or(0);
    [word << 1 | before >> 63, word >> 1 | after << 63]
}

/// Where straight jumps end, and from which cells they lead to a turn and not to a wall.
fn straight(free: &Lines) -> (Woven, [Lines; 2]) {
    let mut stops = [free.clone(), free.clone()];
    let mut to_turn = [free.clone(), free.clone()];
    for number in 0..free.count() {
        let line = free.line(number);
        // Neither the first nor the last line has a free cell, so what is beside them does not matter.
        let sides =
            [number.saturating_sub(1), (number + 1).min(free.count() - 1)].map(|side| free.line(side));
        for (way, stops) in stops.iter_mut().enumerate() {
            for (index, stop) in stops.line_mut(number).iter_mut().enumerate() {
                // To a side that opens beside a cell there may be no shorter way than through the cell.
                let opens = sides.map(|side| side[index] & !neighbours(side, index)[way]);
                *stop = !line[index] | opens[0] | opens[1];
            }
        }
        let [to_turn_forth, to_turn_back] = &mut to_turn;
        let mut carry = 0;
        for (index, word) in to_turn_forth.line_mut(number).iter_mut().enumerate().rev() {
            let [turn, pass] = turn_or_pass(stops[0].line(number), line, index, 1);
            *word = fill(turn.reverse_bits(), pass.reverse_bits(), carry).reverse_bits();
            carry = *word & 1;
        }
        carry = 0;
        for (index, word) in to_turn_back.line_mut(number).iter_mut().enumerate() {
            let [turn, pass] = turn_or_pass(stops[1].line(number), line, index, 0);
            *word = fill(turn, pass, carry);
            carry = *word >> 63;
        }
    }
    let [forth, back] = &stops;
    (Woven::of([forth, back, free]), to_turn)
}

/// The cells next to which there is a turn, and those next to which a jump goes on.
fn turn_or_pass(stops: &[u64], free: &[u64], index: usize, side: usize) -> [u64; 2] {
    let (stop, free) = (neighbours(stops, index)[side], neighbours(free, index)[side]);
    [stop & free, !stop & free]
}

/// Spreads `seed`, and the bit before it, over the bits of `pass` above.
const fn fill(mut seed: u64, mut pass: u64, carry: u64) -> u64 {
    seed |= pass & carry;
    let mut shift = 1;
    while shift < 64 {
        seed |= pass & seed << shift;
        pass &= pass << shift;
        shift *= 2;
    }
    seed
}

/// The cells from which a diagonal move down is allowed by `slant`: 1 to the right, -1 to the left.
fn diagonal(free: &Lines, slant: isize, to_turn: [[&Lines; 2]; 2]) -> Woven {
    let mut open = Lines::new(free.count(), free.length());
    for number in 0..free.count() - 1 {
        let [upper, lower] = [number, number + 1].map(|number| free.line(number));
        let aside = usize::from(slant > 0);
        for (index, open) in open.line_mut(number).iter_mut().enumerate() {
            let beside = neighbours(upper, index)[aside] & neighbours(lower, index)[aside];
            *open = upper[index] & lower[index] & beside;
        }
    }
    let [down, up] = to_turn.map(|[one, other]| one.joined(other).crossing(slant));
    Woven::of([&down, &up, &open.crossing(slant).inverted()])
}
