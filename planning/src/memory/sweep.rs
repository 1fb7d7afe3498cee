//! Goes over a map again and again until a rule has nothing to change any more.
//!
//! Down the rows and up again, each row from left to right and then back: all ways that lead only down and
//! sideways are followed in one pass, however long. Only what a change may matter to is visited again, by
//! segments of a row. On maps that people build a few passes are enough, and what a rule does at a cell it
//! can do for many fields at once.

use crate::{
    grid::{Cell, Grid},
    search::neighbours::Moves,
};

/// The cells of a segment, if that makes no more than 64 a row.
const SEGMENT: usize = 16;

/// The moves that look back where a pass down has been: up, and to the left.
pub(super) const DOWN: Moves = 0b1010_1010_1010_1010;
/// Where a pass up has been: down, and to the left.
pub(super) const UP: Moves = 0b0101_0101_0101_0110;
/// Where the way back along a row has been: to the right.
pub(super) const BACK: Moves = 1;

/// To which cells around one a change there may matter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Spread {
    /// To those that look at it as it has looked at others, with the same moves.
    Onward,
    /// To all that look at it.
    Around,
    /// To all, and a rule may find at any time what it has not been told of yet.
    Anywhere,
}

/// What is to hold at every cell.
pub(super) trait Rule {
    const SPREAD: Spread;

    /// Is called before the cells of a segment are looked at: bit `segment` of row `y`.
    fn enter(&mut self, y: usize, segment: u64);

    /// Looks from a cell along the moves in `MOVES` and makes it hold; whether that changed anything.
    fn look<const MOVES: Moves>(&mut self, index: usize) -> bool;
}

/// Segments of all rows, each a bit.
pub(super) type Segments = Vec<u64>;

/// How the rows of a map are divided.
#[derive(Clone, Copy, Debug)]
pub(super) struct Division {
    pub width: usize,
    pub height: usize,
    /// Columns and rows that a move goes at most.
    pub reach: usize,
    /// Cells of a segment.
    segment: usize,
    /// The bits of a whole row.
    row: u64,
}

impl Division {
    pub fn of(grid: &Grid, reach: usize) -> Self {
        let (width, height) = (grid.width() as usize, grid.height() as usize);
        let segment = width.div_ceil(64).max(SEGMENT);
        Self { width, height, reach, segment, row: u64::MAX.checked_shr(64 - width.div_ceil(segment) as u32).unwrap_or(0) }
    }

    /// How many segments there are.
    pub const fn len(&self) -> usize {
        self.row.count_ones() as usize * self.height
    }

    pub fn none(&self) -> Segments {
        vec![0; self.height]
    }

    pub fn all(&self) -> Segments {
        vec![self.row; self.height]
    }

    /// The columns of a segment.
    pub fn columns(&self, segment: u64) -> std::ops::Range<usize> {
        let start = segment.trailing_zeros() as usize * self.segment;
        start..(start + self.segment).min(self.width)
    }

    /// The segment that a cell is in.
    pub fn put(&self, cell: Cell, segments: &mut Segments) {
        let (x, y) = (cell.x as usize, cell.y as usize);
        segments[y] |= 1 << (x / self.segment);
    }

    /// The row and the segment of the cell in this place.
    pub const fn segment_of(&self, place: usize) -> (usize, u64) {
        (place / self.width, 1 << (place % self.width / self.segment))
    }

    /// The rows that a move may lead to from row `y`.
    pub fn rows(&self, y: usize) -> std::ops::Range<usize> {
        y.saturating_sub(self.reach)..(y + self.reach + 1).min(self.height)
    }

    /// Segments and those beside them.
    pub const fn widened(&self, segments: u64) -> u64 {
        (segments | segments << 1 | segments >> 1) & self.row
    }

    /// The segments above and below, too.
    pub fn heightened(&self, segments: &Segments) -> Segments {
        (0..self.height).map(|y| segments[self.rows(y)].iter().fold(0, |all, row| all | row)).collect()
    }
}

/// Each segment of a row, from the left.
pub(super) fn each(mut segments: u64) -> impl Iterator<Item = u64> {
    std::iter::from_fn(move || {
        let segment = segments & segments.wrapping_neg();
        segments ^= segment;
        (segment != 0).then_some(segment)
    })
}

/// What is to be visited, and what has changed.
#[derive(Debug)]
pub(super) struct Sweep {
    division: Division,
    /// To visit on the way up, on the way down, and back along the row.
    up: Segments,
    down: Segments,
    back: Segments,
    /// Where a cell or one that a row's moves lead to has changed.
    pub changed: Segments,
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
        Self { division, up: none.clone(), down: none.clone(), back: none.clone(), changed: none }
    }

    /// Wants these segments visited.
    pub fn visit(&mut self, segments: &Segments) {
        for all in [&mut self.up, &mut self.down, &mut self.back] {
            all.iter_mut().zip(segments).for_each(|(all, more)| *all |= more);
        }
    }

    /// Makes a rule hold everywhere. Gives up after so many visits of segments and returns `None`.
    pub fn run<R: Rule>(&mut self, rule: &mut R, mut most: usize) -> Option<()> {
        loop {
            let mut visits = 0;
            for y in 0..self.division.height {
                visits += self.row::<R, DOWN>(rule, y);
            }
            for y in (0..self.division.height).rev() {
                visits += self.row::<R, UP>(rule, y);
            }
            if visits == 0 {
                return Some(());
            }
            most = most.checked_sub(visits)?;
        }
    }

    /// Visits a row on the way down or up; returns how many visits that were.
    #[inline]
    fn row<R: Rule, const WAY: Moves>(&mut self, rule: &mut R, y: usize) -> usize {
        let division = self.division;
        let (ahead, behind) = match WAY {
            DOWN => (&mut self.down, &mut self.up),
            _ => (&mut self.up, &mut self.down),
        };
        let mut forth = std::mem::take(&mut ahead[y]);
        let mut back = std::mem::take(&mut self.back[y]);
        let (mut changed, mut visits) = (0, 0);
        while forth != 0 {
            let segment = forth & forth.wrapping_neg();
            forth ^= segment;
            visits += 1;
            rule.enter(y, segment);
            let found = look::<R, WAY>(rule, &division, y, segment, false);
            let [before, here, after] = found.segments(segment, division.row);
            forth |= after;
            back |= before | here;
            changed |= before | here | after;
        }
        while back != 0 {
            let segment = 1 << (63 - back.leading_zeros());
            back ^= segment;
            visits += 1;
            rule.enter(y, segment);
            let found = look::<R, BACK>(rule, &division, y, segment, true);
            let [before, here, after] = found.segments(segment, division.row);
            back |= before;
            changed |= before | here | after;
            if R::SPREAD == Spread::Anywhere {
                behind[y] |= here | after;
            }
        }
        if changed != 0 {
            self.changed[y] |= changed;
            for other in division.rows(y) {
                let is_ahead = if WAY == DOWN { other > y } else { other < y };
                if is_ahead {
                    ahead[other] |= changed;
                } else if other != y && R::SPREAD != Spread::Onward {
                    behind[other] |= changed;
                }
            }
        }
        visits
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
