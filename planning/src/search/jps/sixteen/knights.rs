//! The bitmaps for 16 neighbours.
//!
//! A way is known by the sign of its part across the lines of a view, rows or columns, and of that along them:
//! 0 to higher lines or places, 1 to lower.

use super::super::{
    bitmaps::{boxes, leading, shifted},
    lines::Lines,
    woven::Woven,
};

/// In the lines of knight's moves, for who goes by rising places: cells from which a straight or diagonal jump
/// leads to a turn. The next bitmap is the same for who comes back. Those before are as in diagonals.
pub(super) const TURNS: usize = 3;

/// The lines of the knight's moves two places along a line and one across, for both slants.
pub(super) type Knights = [Woven<5>; 2];

/// By across and along.
type ByWay = [[Lines; 2]; 2];

const SIGNS: [isize; 2] = [1, -1];

/// A map along its rows, or its columns.
pub(super) struct View<'a> {
    pub(super) free: &'a Lines,
    /// Cells beside which a line opens across, for who moves along: free, and blocked a place before.
    pub(super) openings: ByWay,
    /// Cells from which straight jumps lead to a turn, by along.
    pub(super) straight: [Lines; 2],
}

impl<'a> View<'a> {
    pub(super) fn new(free: &'a Lines, straight: [Lines; 2]) -> Self {
        let openings = SIGNS.map(|across| SIGNS.map(|along| opening(free, across, along)));
        Self { free, openings, straight }
    }

    /// The lines of knight's moves, when `diagonal` jumps lead to a turn from those cells.
    pub(super) fn knights(&self, diagonal: &ByWay) -> Knights {
        [0, 1].map(|along| {
            let slant = 2 * SIGNS[along];
            let ways = [(0, along), (1, 1 - along)];
            let turns = ways
                .map(|(across, along)| self.straight[along].joined(&diagonal[across][along]).crossing(slant));
            let runs = Runs::new(self.free, slant, ways.map(|(across, along)| &self.openings[across][along]));
            let [forth, back] = &runs.stops;
            Woven::of([forth, back, &runs.open[1], &turns[0], &turns[1]])
        })
    }
}

/// Cells beside which a line opens.
fn opening(free: &Lines, across: isize, along: isize) -> Lines {
    let mut opening = Lines::new(free.count(), free.length());
    for number in 0..free.count() {
        // The first and the last line have no free cell to stand on.
        let Some(side) = number.checked_add_signed(across).filter(|&side| side < free.count()) else {
            continue;
        };
        let side = free.line(side);
        for (index, opening) in opening.line_mut(number).iter_mut().enumerate() {
            *opening = side[index] & !shifted(side, index, -along);
        }
    }
    opening
}

/// Diagonals to the right and to the left, and the cells from which jumps along them lead to a turn.
pub(super) fn diagonals(rows: &View<'_>, columns: &View<'_>) -> ([Woven<3>; 2], ByWay) {
    let [(falling, [right_down, left_up]), (rising, [left_down, right_up])] = [0, 1].map(|along| {
        let slant = SIGNS[along];
        let turns = [(0, along), (1, 1 - along)].map(|(down, right)| {
            rows.openings[down][right].joined(&columns.openings[right][down].crossing(0))
        });
        let Runs { open, stops } = Runs::new(rows.free, slant, turns.each_ref());
        let leads = leading(stops.each_ref(), open.each_ref()).map(|lines| lines.uncrossed(slant));
        (Woven::of([&stops[0], &stops[1], &open[1]]), leads)
    });
    ([falling, rising], [[right_down, left_down], [right_up, left_up]])
}

/// The same diagonals by columns.
pub(super) fn crossed(by_rows: &ByWay) -> ByWay {
    [0, 1].map(|across| [0, 1].map(|along| by_rows[along][across].crossing(0)))
}

/// Slanted runs, along their lines.
struct Runs {
    /// The places that a move leads to, forth and back. Where one leads to coming back, it leads on from forth.
    open: [Lines; 2],
    /// The places where a run ends: where none leads to, and turns.
    stops: [Lines; 2],
}

impl Runs {
    fn new(free: &Lines, slant: isize, turns: [&Lines; 2]) -> Self {
        let open = boxes(free, slant).crossing(slant);
        let open = [open.later(), open];
        let [forth, back] = &open;
        let stops = [(forth, turns[0]), (back, turns[1])]
            .map(|(open, turns)| open.clone().inverted().joined(&turns.crossing(slant)));
        Self { open, stops }
    }
}
