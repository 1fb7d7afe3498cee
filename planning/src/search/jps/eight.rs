//! Jumps with 8 neighbours: diagonally, and straight from wherever on the diagonal that leads to a turn.

use super::{
    DIAGONAL_COST, EAST, Jumps, NORTH, Place, Query, SOUTH, STRAIGHT_COST, WEST, Ways,
    bitmaps::{boxes, framed, straight},
    lines::Lines,
    turns_by,
    woven::Woven,
};
use crate::{
    grid::Grid,
    moves::{Cost, MoveSet},
};

/// In diagonals, for who goes down: cells from which a straight jump leads to a turn. The next bitmap is
/// the same for who goes up.
const TURNS: usize = 0;
/// In diagonals: cells from which no diagonal move leads to the next row.
const WALLS: usize = 2;

/// All that is kept of a map: 12 bits a cell, and what the border takes.
#[derive(Clone, Debug)]
pub(super) struct Eight {
    /// Rows and columns.
    straights: [Woven<3>; 2],
    /// The diagonals from the upper left to the lower right; line x - y, place y.
    falling: Woven<3>,
    /// The diagonals from the upper right to the lower left; line x + y, place y.
    rising: Woven<3>,
}

impl Eight {
    pub(super) fn of(grid: &Grid) -> Self {
        let free = framed(grid);
        let (columns, to_turn) = straight(&free.crossing(0));
        let [south, north] = to_turn.map(|lines| lines.crossing(0));
        let (rows, [east, west]) = straight(&free);
        Self {
            straights: [rows, columns],
            falling: diagonal(&free, 1, [[&east, &south], [&west, &north]]),
            rising: diagonal(&free, -1, [[&west, &south], [&east, &north]]),
        }
    }
}

fn diagonal(free: &Lines, slant: isize, to_turn: [[&Lines; 2]; 2]) -> Woven<3> {
    let [down, up] = to_turn.map(|[one, other]| one.joined(other).crossing(slant));
    Woven::of([&down, &up, &boxes(free, slant).crossing(slant).inverted()])
}

impl Jumps for Eight {
    const MOVES: MoveSet = MoveSet::Eight;
    const START: Ways = 0b1111_1111;
    const TURNS_BY: [[Ways; 2]; 4] = turns_by(MoveSet::Eight);

    fn straights(&self) -> &[Woven<3>; 2] {
        &self.straights
    }

    fn bytes(&self) -> usize {
        let [rows, columns] = &self.straights;
        [rows, columns, &self.falling, &self.rising].map(Woven::bytes).iter().sum()
    }

    fn leave_slanted(query: &mut Query<'_, Self>, node: Place, cost: Cost, ways: Ways) {
        let leaves = |way: usize| ways >> way & 1 != 0;
        if leaves(4) {
            query.diagonal::<EAST, SOUTH>(node, cost);
        }
        if leaves(5) {
            query.diagonal::<WEST, SOUTH>(node, cost);
        }
        if leaves(6) {
            query.diagonal::<EAST, NORTH>(node, cost);
        }
        if leaves(7) {
            query.diagonal::<WEST, NORTH>(node, cost);
        }
    }
}

impl Query<'_, Eight> {
    /// Jumps from a node along a diagonal, and straight from wherever on it that leads to a turn.
    #[inline]
    fn diagonal<const COLUMNS: usize, const ROWS: usize>(&mut self, node: Place, cost: Cost) {
        let (x, y) = (usize::from(node.x), usize::from(node.y));
        let bitmaps = self.bitmaps;
        let lines = if (COLUMNS == EAST) == (ROWS == SOUTH) { &bitmaps.falling } else { &bitmaps.rising };
        let line = self.slanted::<COLUMNS, ROWS, 1>(node);
        let end =
            if ROWS == SOUTH { lines.next(WALLS, line, y) } else { lines.previous(WALLS, line, y - 1) + 1 };
        let steps = end.abs_diff(y);
        if steps == 0 {
            return;
        }
        self.cross::<COLUMNS, ROWS>(node, steps, cost);
        let (turns, first, last) = if ROWS == SOUTH { (TURNS, y + 1, end) } else { (TURNS + 1, end, y - 1) };
        lines.for_each(turns, line, first, last, |turn| {
            let steps = turn.abs_diff(y);
            let from =
                Place { x: if COLUMNS == EAST { x + steps } else { x - steps } as u16, y: turn as u16 };
            let cost = cost + steps as Cost * DIAGONAL_COST;
            self.turn::<COLUMNS>(node, from, cost);
            self.turn::<ROWS>(node, from, cost);
        });
    }

    /// Looks whether a diagonal of some moves comes to the goal's row or column within sight of it.
    #[inline]
    fn cross<const COLUMNS: usize, const ROWS: usize>(&mut self, node: Place, steps: usize, cost: Cost) {
        let [dx, dy] = self.to_goal(node);
        let dx = if COLUMNS == EAST { dx } else { -dx };
        let dy = if ROWS == SOUTH { dy } else { -dy };
        let before = dx.min(dy);
        if before < 1 || before as usize > steps {
            return;
        }
        let rest = dx.max(dy) - before;
        let towards = |goal: u16, away: bool| if away { goal - rest as u16 } else { goal + rest as u16 };
        let crossing = if dx > dy {
            Place { x: towards(self.goal.x, COLUMNS == EAST), y: self.goal.y }
        } else {
            Place { x: self.goal.x, y: towards(self.goal.y, ROWS == SOUTH) }
        };
        let (_, at, stop) =
            if dx > dy { self.stop::<COLUMNS>(crossing) } else { self.stop::<ROWS>(crossing) };
        if stop.abs_diff(at) >= rest as usize {
            self.arrive(node, cost + before as Cost * DIAGONAL_COST + rest as Cost * STRAIGHT_COST);
        }
    }
}
