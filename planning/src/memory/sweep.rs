//! Goes over a map again and again until a rule has nothing to change any more.
//!
//! Down the rows and up again, each row from left to right and then back: all ways that lead only down and
//! sideways are followed in one pass, however long. Only what a change may matter to is visited again, by
//! segments of a row. On maps that people build a few passes are enough, and what a rule does at a cell it
//! can do for many fields at once.

use crate::{grid::Grid, search::neighbours::Moves};

/// The cells of a segment, if that makes no more than 64 a row.
const SEGMENT: usize = 16;

/// The moves that look back where a pass down has been: up, and to the left.
const DOWN: Moves = 0b1010_1010_1010_1010;
/// Where a pass up has been: down, and to the left.
const UP: Moves = 0b0101_0101_0101_0110;
/// Where the way back along a row has been: to the right.
const BACK: Moves = 1;

/// What is to hold at every cell.
pub(super) trait Rule {
    /// Whether a change matters only to cells that look at it as it has looked at others, with the same moves.
    const IS_ONE_WAY: bool;

    /// Looks from a cell along the moves in `MOVES` and makes it hold; whether that changed anything.
    fn look<const MOVES: Moves>(&mut self, index: usize) -> bool;
}

/// Segments of all rows, each a bit.
type Segments = Vec<u64>;

/// How the rows of a map are divided.
#[derive(Clone, Copy, Debug)]
pub(super) struct Division {
    width: usize,
    height: usize,
    /// Columns and rows that a move goes at most.
    reach: usize,
    /// Cells of a segment.
    segment: usize,
    /// The bits of a whole row.
    row: u64,
}

impl Division {
    pub fn of(grid: &Grid, reach: usize) -> Self {
        let (width, height) = (grid.width() as usize, grid.height() as usize);
        let segment = width.div_ceil(64).max(SEGMENT);
        Self {
            width,
            height,
            reach,
            segment,
            row: u64::MAX.checked_shr(64 - width.div_ceil(segment) as u32).unwrap_or(0),
        }
    }

    fn none(&self) -> Segments {
        vec![0; self.height]
    }

    /// The columns of a segment.
    fn columns(&self, segment: u64) -> std::ops::Range<usize> {
        let start = segment.trailing_zeros() as usize * self.segment;
        start..(start + self.segment).min(self.width)
    }

    /// The rows that a move may lead to from row `y`.
    fn rows(&self, y: usize) -> std::ops::Range<usize> {
        y.saturating_sub(self.reach)..(y + self.reach + 1).min(self.height)
    }
}

/// What is to be visited.
#[derive(Debug)]
pub(super) struct Sweep {
    division: Division,
    /// To visit on the way up, on the way down, and back along the row.
    up: Segments,
    down: Segments,
    back: Segments,
}

/// Where in a segment something has changed: anywhere, so near its left or right end that a move leads out.
#[derive(Clone, Copy, Debug, Default)]
struct Found {
    any: bool,
    left: bool,
    right: bool,
}

impl Sweep {
    pub fn new(division: Division) -> Self {
        let none = division.none();
        Self { division, up: none.clone(), down: none.clone(), back: none }
    }

    /// Wants all that look at the cell in this place to be visited.
    pub fn visit_around(&mut self, place: usize) {
        let division = self.division;
        let segment = 1 << (place % division.width / division.segment);
        let wide = (segment | segment << 1 | segment >> 1) & division.row;
        for y in division.rows(place / division.width) {
            self.visit(y, wide);
        }
    }

    /// Wants all cells to be visited.
    pub fn visit_all(&mut self) {
        (0..self.division.height).for_each(|y| self.visit(y, self.division.row));
    }

    fn visit(&mut self, y: usize, segments: u64) {
        self.up[y] |= segments;
        self.down[y] |= segments;
        self.back[y] |= segments;
    }

    /// Makes a rule hold everywhere.
    pub fn run<R: Rule>(&mut self, rule: &mut R) {
        let mut is_done = false;
        while !is_done {
            is_done = true;
            for y in 0..self.division.height {
                is_done &= self.row::<R, DOWN>(rule, y);
            }
            for y in (0..self.division.height).rev() {
                is_done &= self.row::<R, UP>(rule, y);
            }
        }
    }

    /// Visits a row on the way down or up; whether there was nothing to visit.
    #[inline]
    fn row<R: Rule, const WAY: Moves>(&mut self, rule: &mut R, y: usize) -> bool {
        let division = self.division;
        let (ahead, behind) = match WAY {
            DOWN => (&mut self.down, &mut self.up),
            _ => (&mut self.up, &mut self.down),
        };
        let mut forth = std::mem::take(&mut ahead[y]);
        let mut back = std::mem::take(&mut self.back[y]);
        if forth | back == 0 {
            return true;
        }
        let mut changed = 0;
        while forth != 0 {
            let segment = forth & forth.wrapping_neg();
            forth ^= segment;
            let found = look::<R, WAY>(rule, &division, y, segment, false);
            let [before, here, after] = found.segments(segment, division.row);
            forth |= after;
            back |= before | here;
            changed |= before | here | after;
        }
        while back != 0 {
            let segment = 1 << (63 - back.leading_zeros());
            back ^= segment;
            let found = look::<R, BACK>(rule, &division, y, segment, true);
            let [before, here, after] = found.segments(segment, division.row);
            back |= before;
            changed |= before | here | after;
        }
        if changed != 0 {
            for other in division.rows(y) {
                let is_ahead = if WAY == DOWN { other > y } else { other < y };
                if is_ahead {
                    ahead[other] |= changed;
                } else if other != y && !R::IS_ONE_WAY {
                    behind[other] |= changed;
                }
            }
        }
        false
    }
}

impl Found {
    /// The segments that it matters to: the one before, the one itself, the one after.
    const fn segments(self, segment: u64, row: u64) -> [u64; 3] {
        [
            if self.left { segment >> 1 } else { 0 },
            if self.any { segment } else { 0 },
            if self.right { segment << 1 & row } else { 0 },
        ]
    }
}

/// Looks from all cells of a segment, from the left or from the right.
#[inline(always)]
fn look<R: Rule, const MOVES: Moves>(
    rule: &mut R,
    division: &Division,
    y: usize,
    segment: u64,
    from_right: bool,
) -> Found {
    let columns = division.columns(segment);
    let (start, length) = (y * division.width + columns.start, columns.len());
    let mut found = Found::default();
    for step in 0..length {
        let place = if from_right { length - 1 - step } else { step };
        let changed = rule.look::<MOVES>(start + place);
        found.any |= changed;
        found.left |= changed & (place < division.reach);
        found.right |= changed & (place + division.reach >= length);
    }
    found
}
