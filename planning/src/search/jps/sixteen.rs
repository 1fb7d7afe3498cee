//! Jumps with 16 neighbours: by knight's moves, and straight or diagonally from wherever on such a run that
//! leads to a turn; or straight or diagonally from the start on.
//!
//! A path that is not pruned turns otherwise only beside a blocked cell. Two moves one after the other give
//! way to others that are no longer and come first in the canonical order, wherever one cell beside them
//! is free: the one behind the place between them on the side of the turn. Three tell of them all:
//!
//! - who comes straight past the end of a wall turns by all moves to its side, up to a right angle;
//! - who comes diagonally goes straight on, or by the knight's move between, beside a blocked cell in front;
//! - who comes by a knight's move turns to its shorter side, straight or by the other knight's move.

mod knights;

use knights::{Knights, TURNS, View, crossed, diagonals};

use super::{
    DIAGONAL_COST, EAST, Jumps, NORTH, Place, Query, SOUTH, STRAIGHT_COST, WEST, Ways, along,
    bitmaps::{STOPS, framed, straight},
    diagonal, is_forth, knight, opens, turns_by,
    woven::Woven,
};
use crate::{
    grid::Grid,
    moves::{Cost, Length, MoveSet},
};

/// In slanted lines: cells from which a move to the next row, or column, is allowed.
const OPEN: usize = 2;

const KNIGHT_COST: Cost = Length::of((2, 1)).cost();

/// All that is kept of a map: 32 bits a cell, and what the border takes.
#[derive(Clone, Debug)]
pub(super) struct Sixteen {
    /// Rows and columns.
    straights: [Woven<3>; 2],
    /// Diagonals to the right and to the left: line x - y or x + y, place y.
    diagonals: [Woven<3>; 2],
    /// The lines of knight's moves two columns wide, to the right and to the left: line x - 2 y or x + 2 y,
    /// place y.
    wide: Knights,
    /// Of those two rows high, downwards and upwards: line y - 2 x or y + 2 x, place x.
    high: Knights,
}

impl Sixteen {
    pub(super) fn of(grid: &Grid) -> Self {
        let free = framed(grid);
        let free = [free.crossing(0), free];
        let [(columns, down_up), (rows, right_left)] = free.each_ref().map(straight);
        let [by_columns, by_rows] = &free;
        let by_columns = View::new(by_columns, down_up);
        let by_rows = View::new(by_rows, right_left);
        let (diagonals, leads) = diagonals(&by_rows, &by_columns);
        let high = by_columns.knights(&crossed(&leads));
        Self { straights: [rows, columns], diagonals, wide: by_rows.knights(&leads), high }
    }
}

impl Jumps for Sixteen {
    const MOVES: MoveSet = MoveSet::Sixteen;
    const START: Ways = Ways::MAX;
    const TURNS_BY: [[Ways; 2]; 4] = turns_by(MoveSet::Sixteen);

    fn straights(&self) -> &[Woven<3>; 2] {
        &self.straights
    }

    fn bytes(&self) -> usize {
        let straights = self.straights.iter().chain(&self.diagonals).map(Woven::bytes);
        let knights = self.wide.iter().chain(&self.high).map(Woven::bytes);
        straights.chain(knights).sum()
    }

    fn leave_slanted(query: &mut Query<'_, Self>, node: Place, cost: Cost, ways: Ways) {
        query.corner::<EAST, SOUTH>(node, cost, ways);
        query.corner::<WEST, SOUTH>(node, cost, ways);
        query.corner::<EAST, NORTH>(node, cost, ways);
        query.corner::<WEST, NORTH>(node, cost, ways);
    }
}

/// Where a slanted run ends.
struct End {
    /// After how many moves.
    steps: usize,
    /// Whether at a turn, and not before a wall.
    is_turn: bool,
}

impl Query<'_, Sixteen> {
    /// Jumps from a node by those ways that are between two straight ones.
    #[inline]
    fn corner<const COLUMNS: usize, const ROWS: usize>(&mut self, node: Place, cost: Cost, ways: Ways) {
        let leaves = |way: usize| ways >> way & 1 != 0;
        if leaves(diagonal(COLUMNS, ROWS)) {
            self.diagonal::<COLUMNS, ROWS>(node, cost);
        }
        if leaves(knight(COLUMNS, ROWS)) {
            self.knight::<COLUMNS, ROWS>(node, cost);
        }
        if leaves(knight(ROWS, COLUMNS)) {
            self.knight::<ROWS, COLUMNS>(node, cost);
        }
    }

    /// Jumps from a node diagonally to the next turn or the goal.
    fn diagonal<const COLUMNS: usize, const ROWS: usize>(&mut self, node: Place, cost: Cost) {
        let end = self.diagonal_end::<COLUMNS, ROWS>(node);
        let (right, down) = self.ahead::<COLUMNS, ROWS>(node);
        if right == down && right > 0 && right as usize <= end.steps {
            self.arrive(node, cost + right as Cost * DIAGONAL_COST);
        }
        self.turn_diagonal::<COLUMNS, ROWS>(node, node, &end, cost);
    }

    /// Jumps from `from`, from which a diagonal run has this end, to the turn there.
    #[inline]
    fn turn_diagonal<const COLUMNS: usize, const ROWS: usize>(
        &mut self,
        node: Place,
        from: Place,
        end: &End,
        cost: Cost,
    ) {
        if !end.is_turn {
            return;
        }
        let turn = moved::<COLUMNS>(moved::<ROWS>(from, end.steps), end.steps);
        let cost = cost + end.steps as Cost * DIAGONAL_COST;
        self.reach(diagonal(COLUMNS, ROWS), node, turn, cost, |query| {
            1 << diagonal(COLUMNS, ROWS)
                | query.turns::<COLUMNS, ROWS>(turn)
                | query.turns::<ROWS, COLUMNS>(turn)
        });
    }

    /// By which ways to leave a turn that was come to by a move with a part along `ALONG`: those to the side of
    /// `ASIDE` if that opens here.
    #[inline]
    fn turns<const ALONG: usize, const ASIDE: usize>(&self, turn: Place) -> Ways {
        let (line, at) = along::<ALONG>(turn);
        let before = if is_forth(ALONG) { at - 1 } else { at + 1 };
        let side = if is_forth(ASIDE) { line + 1 } else { line - 1 };
        if opens(self.lines::<ALONG>(), side, at, before) {
            1 << ASIDE | 1 << knight(ASIDE, ALONG)
        } else {
            0
        }
    }

    #[inline]
    fn diagonal_end<const COLUMNS: usize, const ROWS: usize>(&self, from: Place) -> End {
        let [falling, rising] = &self.bitmaps.diagonals;
        let lines = if is_forth(COLUMNS) == is_forth(ROWS) { falling } else { rising };
        end::<3, ROWS>(lines, self.slanted::<COLUMNS, ROWS, 1>(from), usize::from(from.y))
    }

    /// Jumps from a node by knight's moves, two to `BY_TWO` and one to `BY_ONE`, and straight or diagonally from
    /// wherever on that run it leads to a turn or the goal.
    #[inline]
    fn knight<const BY_TWO: usize, const BY_ONE: usize>(&mut self, node: Place, cost: Cost) {
        let [falling, rising] = if BY_TWO < SOUTH { &self.bitmaps.wide } else { &self.bitmaps.high };
        let lines = if is_forth(BY_TWO) == is_forth(BY_ONE) { falling } else { rising };
        let line = self.slanted::<BY_TWO, BY_ONE, 2>(node);
        let (at, _) = along::<BY_TWO>(node);
        let end = end::<5, BY_ONE>(lines, line, at);
        if end.steps == 0 {
            return;
        }
        self.cross::<BY_TWO, BY_ONE>(node, end.steps, cost);
        let after = |steps: usize| moved::<BY_TWO>(moved::<BY_ONE>(node, steps), 2 * steps);
        let mut last = end.steps;
        if end.is_turn {
            // From there on the turn itself is left.
            last -= 1;
            let turn = after(end.steps);
            let cost = cost + end.steps as Cost * KNIGHT_COST;
            self.reach(knight(BY_TWO, BY_ONE), node, turn, cost, |query| {
                let onward = 1 << knight(BY_TWO, BY_ONE) | 1 << BY_TWO | 1 << diagonal(BY_TWO, BY_ONE);
                onward | query.turns::<BY_TWO, BY_ONE>(turn)
            });
        }
        if last == 0 {
            return;
        }
        let (turns, first, last) =
            if is_forth(BY_ONE) { (TURNS, at + 1, at + last) } else { (TURNS + 1, at - last, at - 1) };
        lines.for_each(turns, line, first, last, |turn| {
            let steps = turn.abs_diff(at);
            let (from, cost) = (after(steps), cost + steps as Cost * KNIGHT_COST);
            self.turn::<BY_TWO>(node, from, cost);
            self.turn_from_knight::<BY_TWO, BY_ONE>(node, from, cost);
        });
    }

    /// Jumps from a place on a run of knight's moves diagonally to the next turn.
    #[inline]
    fn turn_from_knight<const BY_TWO: usize, const BY_ONE: usize>(
        &mut self,
        node: Place,
        from: Place,
        cost: Cost,
    ) {
        // The columns' way comes first.
        if BY_TWO < SOUTH {
            let end = self.diagonal_end::<BY_TWO, BY_ONE>(from);
            self.turn_diagonal::<BY_TWO, BY_ONE>(node, from, &end, cost);
        } else {
            let end = self.diagonal_end::<BY_ONE, BY_TWO>(from);
            self.turn_diagonal::<BY_ONE, BY_TWO>(node, from, &end, cost);
        }
    }

    /// Looks whether a run of some knight's moves comes within sight of the goal straight or diagonally.
    #[inline]
    fn cross<const BY_TWO: usize, const BY_ONE: usize>(&mut self, node: Place, steps: usize, cost: Cost) {
        let (by_two, by_one) = self.ahead::<BY_TWO, BY_ONE>(node);
        let is_straight = by_two >= 2 * by_one;
        let knights = if is_straight { by_one } else { by_two - by_one };
        if knights < 1 || knights as usize > steps {
            return;
        }
        let rest = by_two - 2 * knights;
        if rest < 0 {
            return;
        }
        let from = moved::<BY_TWO>(moved::<BY_ONE>(node, knights as usize), 2 * knights as usize);
        let seen = if is_straight {
            let (_, at, stop) = self.stop::<BY_TWO>(from);
            stop.abs_diff(at)
        } else if BY_TWO < SOUTH {
            self.diagonal_end::<BY_TWO, BY_ONE>(from).steps
        } else {
            self.diagonal_end::<BY_ONE, BY_TWO>(from).steps
        };
        if seen >= rest as usize {
            let each = if is_straight { STRAIGHT_COST } else { DIAGONAL_COST };
            self.arrive(node, cost + knights as Cost * KNIGHT_COST + rest as Cost * each);
        }
    }

    /// How far the goal is ahead by two straight ways; less than 0 if behind.
    #[inline]
    fn ahead<const ONE: usize, const OTHER: usize>(&self, node: Place) -> (i32, i32) {
        let [dx, dy] = self.to_goal(node);
        let by = |way: usize| {
            let distance = if way < SOUTH { dx } else { dy };
            if is_forth(way) { distance } else { -distance }
        };
        (by(ONE), by(OTHER))
    }
}

/// Where the run from place `at` of a slanted line ends that goes as `WAY` from line to line of the map.
#[inline]
fn end<const BITMAPS: usize, const WAY: usize>(lines: &Woven<BITMAPS>, line: usize, at: usize) -> End {
    let stop =
        if is_forth(WAY) { lines.next(STOPS, line, at + 1) } else { lines.previous(STOPS + 1, line, at - 1) };
    let is_turn = lines.bit(OPEN, line, if is_forth(WAY) { stop - 1 } else { stop });
    End { steps: stop.abs_diff(at) - usize::from(!is_turn), is_turn }
}

/// The place so many straight steps on.
#[inline]
const fn moved<const WAY: usize>(Place { x, y }: Place, steps: usize) -> Place {
    let steps = steps as u16;
    match WAY {
        EAST => Place { x: x + steps, y },
        WEST => Place { x: x - steps, y },
        SOUTH => Place { x, y: y + steps },
        _ => Place { x, y: y - steps },
    }
}
