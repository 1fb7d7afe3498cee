//! Where jumps end, as bitmaps along the lines that jumps follow: what all move sets need.
//!
//! All are made from the map by operations on whole words. A border of one blocked cell is around the
//! map, so that every jump ends: cell (x, y) of the map is at (x + 1, y + 1) here.

use super::{
    lines::{Lines, shift_up},
    woven::Woven,
};
use crate::grid::Grid;

/// For who goes on by rising places: cells that can't be come to, and cells where a turn may be worth while.
/// The next bitmap is the same for who comes back.
pub(super) const STOPS: usize = 0;
/// In straight lines: the free cells.
pub(super) const FREE: usize = 2;

/// The free cells of a map along its rows, with the border.
pub(super) fn framed(grid: &Grid) -> Lines {
    let mut free = Lines::new(grid.height() as usize + 2, grid.width() as usize + 2);
    for y in 0..grid.height() {
        shift_up(grid.row(y as i32), free.line_mut(y as usize + 1));
    }
    free
}

/// The word of a line, each cell `by` places before its own; up to 63 places, or as many after.
pub(super) fn shifted(line: &[u64], index: usize, by: isize) -> u64 {
    let distance = by.unsigned_abs();
    let word = line[index];
    if by < 0 {
        let before = if index == 0 { 0 } else { line[index - 1] };
        word << distance | before >> (64 - distance)
    } else {
        let after = line.get(index + 1).copied().unwrap_or(0);
        word >> distance | after << 1 << (63 - distance)
    }
}

/// Where straight jumps end, and from which cells they lead to a turn and not to a wall.
pub(super) fn straight(free: &Lines) -> (Woven<3>, [Lines; 2]) {
    let mut stops = [free.clone(), free.clone()];
    for number in 0..free.count() {
        let line = free.line(number);
        // Neither the first nor the last line has a free cell, so what is beside them does not matter.
        let sides =
            [number.saturating_sub(1), (number + 1).min(free.count() - 1)].map(|side| free.line(side));
        for (before, stops) in [-1, 1].into_iter().zip(&mut stops) {
            for (index, stop) in stops.line_mut(number).iter_mut().enumerate() {
                // To a side that opens beside a cell there may be no shorter way than through the cell.
                let opens = sides.map(|side| side[index] & !shifted(side, index, before));
                *stop = !line[index] | opens[0] | opens[1];
            }
        }
    }
    let [forth, back] = &stops;
    (Woven::of([forth, back, free]), leading([forth, back], [free, free]))
}

/// From which cells a jump leads to a turn, forth and back: `stops` end it, and where it can't come to by a
/// move is not `open`.
pub(super) fn leading(stops: [&Lines; 2], open: [&Lines; 2]) -> [Lines; 2] {
    let mut leading = stops.map(Lines::clone);
    let [forth, back] = &mut leading;
    for number in 0..stops[0].count() {
        // The cells next to which there is a turn, and those next to which a jump goes on.
        let turn_or_pass = |way: usize, index: usize| {
            let next = if way == 0 { 1 } else { -1 };
            let stop = shifted(stops[way].line(number), index, next);
            let open = shifted(open[way].line(number), index, next);
            [stop & open, !stop & open]
        };
        let mut carry = 0;
        for (index, word) in forth.line_mut(number).iter_mut().enumerate().rev() {
            let [turn, pass] = turn_or_pass(0, index);
            *word = fill(turn.reverse_bits(), pass.reverse_bits(), carry).reverse_bits();
            carry = *word & 1;
        }
        carry = 0;
        for (index, word) in back.line_mut(number).iter_mut().enumerate() {
            let [turn, pass] = turn_or_pass(1, index);
            *word = fill(turn, pass, carry);
            carry = *word >> 63;
        }
    }
    leading
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

/// The cells from which a move to the next line is allowed that goes `slant` places on: its box is free.
pub(super) fn boxes(free: &Lines, slant: isize) -> Lines {
    let mut open = Lines::new(free.count(), free.length());
    for number in 0..free.count() - 1 {
        let [upper, lower] = [number, number + 1].map(|number| free.line(number));
        for (index, open) in open.line_mut(number).iter_mut().enumerate() {
            let column = |aside: isize| {
                let by = aside * slant.signum();
                shifted(upper, index, by) & shifted(lower, index, by)
            };
            *open = (1..=slant.abs()).fold(upper[index] & lower[index], |open, aside| open & column(aside));
        }
    }
    open
}
