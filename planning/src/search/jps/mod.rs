//! Jump point search (Harabor and Grastien) by blocks, for 8 or 16 neighbours that cut no corner.
//!
//! Of all shortest paths only those are followed that begin with the finer moves and turn where a wall makes
//! them: with 8 neighbours diagonally first, then straight; with 16 knight's moves first, then straight or
//! diagonally (the canonical paths of Rivera, Hernandez, Hormazabal and Baier, "The 2^k Neighborhoods for Grid
//! Path Planning", JAIR 2020). So nodes are the few cells where a run passes the end of a wall beside it, and a
//! move is a whole jump: some of the finer moves, then some others to the next such cell. Where jumps end
//! is kept as `bitmaps` along rows, columns and slanted lines, so that a jump over 64 moves, of
//! whatever kind, costs a few operations on a word, and a run of the finer moves stops only where another from
//! it leads somewhere. They take 12 bits a cell, or 32 with 16 neighbours, and are made in a fraction of a
//! millisecond, or in one or two.
//!
//! What is the same for both move sets is here; `eight` and `sixteen` have their bitmaps and slanted jumps.

mod bitmaps;
mod eight;
mod lines;
mod sixteen;
mod woven;

use bitmaps::{FREE, STOPS};
use eight::Eight;
use sixteen::Sixteen;
use woven::Woven;

use super::{Open, Plan, Planner, SearchError, free_index};
use crate::{
    grid::{Cell, Grid},
    moves::{Cost, Length, MoveSet},
    path::Path,
};

/// Plans shortest paths by jump point search.
#[derive(Clone, Debug)]
pub struct Jps {
    grid: Grid,
    bitmaps: Bitmaps,
}

#[derive(Clone, Debug)]
enum Bitmaps {
    Eight(Eight),
    Sixteen(Sixteen),
}

/// The memory of a search by [`Jps`], 16 bytes a cell.
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    nodes: Vec<Node>,
    /// Nodes of other rounds are as good as new: no need to clear them.
    round: u16,
    open: Open<Reached>,
    path: Path,
}

#[derive(Clone, Copy, Debug, Default)]
struct Node {
    cost: Cost,
    parent: Place,
    round: u16,
    /// The ways by which the node was reached at this cost.
    ways: Ways,
}

/// A node reached in one way.
#[derive(Clone, Copy, Debug)]
struct Reached {
    cost: Cost,
    place: Place,
    /// The ways to leave it by.
    onward: Ways,
}

/// A cell in the bitmaps' coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Place {
    x: u16,
    y: u16,
}

/// A set of directions: bits 0 to 3 for east, west, south, north; 4 to 7 for the diagonals to the
/// south-east, south-west, north-east and north-west; 8 to 11 for the knight's moves beside them that are two
/// columns wide, 12 to 15 for those that are two rows high.
type Ways = u16;

const EAST: usize = 0;
const WEST: usize = 1;
const SOUTH: usize = 2;
const NORTH: usize = 3;

const STRAIGHT_COST: Cost = Length::of((1, 0)).cost();
const DIAGONAL_COST: Cost = Length::of((1, 1)).cost();

/// Whether a straight way leads to higher places.
const fn is_forth(way: usize) -> bool {
    way == EAST || way == SOUTH
}

/// The diagonal between two straight ways.
const fn diagonal(one: usize, other: usize) -> usize {
    let (columns, rows) = if one < SOUTH { (one, other) } else { (other, one) };
    4 + columns + 2 * (rows - SOUTH)
}

/// The knight's move that goes by two to `by_two` and by one to `by_one`.
const fn knight(by_two: usize, by_one: usize) -> usize {
    diagonal(by_two, by_one) + if by_two < SOUTH { 4 } else { 8 }
}

/// By straight way: who passes the end of a wall on the side of the lower line, or of the higher, turns by
/// these ways.
const fn turns_by(moves: MoveSet) -> [[Ways; 2]; 4] {
    let mut turns_by = [[0; 2]; 4];
    let mut number = 0;
    while number < 8 {
        let way = number / 2;
        let side = match (way < SOUTH, number % 2) {
            (true, 0) => NORTH,
            (true, _) => SOUTH,
            (false, 0) => WEST,
            (false, _) => EAST,
        };
        let knights = match moves {
            MoveSet::Eight => 0,
            MoveSet::Sixteen => 1 << knight(way, side) | 1 << knight(side, way),
        };
        turns_by[way][number % 2] = 1 << side | 1 << diagonal(way, side) | knights;
        number += 1;
    }
    turns_by
}

/// The jumps of a move set.
trait Jumps: Sized {
    const MOVES: MoveSet;
    /// By which ways a start is left: all.
    const START: Ways;
    /// See [`turns_by`].
    const TURNS_BY: [[Ways; 2]; 4];

    /// Where straight jumps end, by rows and by columns.
    fn straights(&self) -> &[Woven<3>; 2];

    fn bytes(&self) -> usize;

    /// Jumps from a node by those of the ways that are not straight.
    fn leave_slanted(query: &mut Query<'_, Self>, node: Place, cost: Cost, ways: Ways);
}

impl Jps {
    /// A planner for `grid`.
    #[must_use]
    pub fn new(grid: Grid, moves: MoveSet) -> Self {
        let bitmaps = match moves {
            MoveSet::Eight => Bitmaps::Eight(Eight::of(&grid)),
            MoveSet::Sixteen => Bitmaps::Sixteen(Sixteen::of(&grid)),
        };
        Self { grid, bitmaps }
    }

    /// The map.
    #[must_use]
    pub const fn grid(&self) -> &Grid {
        &self.grid
    }

    /// What is kept of the map besides the map itself, in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        match &self.bitmaps {
            Bitmaps::Eight(bitmaps) => bitmaps.bytes(),
            Bitmaps::Sixteen(bitmaps) => bitmaps.bytes(),
        }
    }
}

impl Planner for Jps {
    type Workspace = Workspace;

    fn plan<'w>(&self, from: Cell, to: Cell, workspace: &'w mut Workspace) -> Result<Plan<'w>, SearchError> {
        free_index(&self.grid, from)?;
        free_index(&self.grid, to)?;
        let sides = [self.grid.width(), self.grid.height()].map(|side| side as usize + 2);
        let expanded = match &self.bitmaps {
            Bitmaps::Eight(bitmaps) => Query::new(bitmaps, sides, [from, to], workspace).answer(),
            Bitmaps::Sixteen(bitmaps) => Query::new(bitmaps, sides, [from, to], workspace).answer(),
        };
        let expanded = expanded.ok_or(SearchError::NoPath { from, to })?;
        Ok(Plan { path: &workspace.path, expanded })
    }
}

impl Place {
    const fn of(cell: Cell) -> Self {
        Self { x: cell.x as u16 + 1, y: cell.y as u16 + 1 }
    }

    fn cell(self) -> Cell {
        Cell { x: i32::from(self.x) - 1, y: i32::from(self.y) - 1 }
    }
}

struct Query<'a, J> {
    bitmaps: &'a J,
    width: usize,
    height: usize,
    start: Place,
    goal: Place,
    /// The length of the shortest way to the goal so far.
    bound: Cost,
    /// The last node on it.
    last: Place,
    workspace: &'a mut Workspace,
}

impl<'a, J: Jumps> Query<'a, J> {
    fn new(
        bitmaps: &'a J,
        [width, height]: [usize; 2],
        ends: [Cell; 2],
        workspace: &'a mut Workspace,
    ) -> Self {
        let [start, goal] = ends.map(Place::of);
        Self { bitmaps, width, height, start, goal, bound: Cost::MAX, last: start, workspace }
    }

    /// Puts the shortest path into the workspace and returns how many nodes were expanded; `None` if there is
    /// none.
    fn answer(&mut self) -> Option<u32> {
        let expanded = self.run();
        if self.bound == Cost::MAX {
            return None;
        }
        self.trace();
        Some(expanded)
    }

    /// Searches until no shorter way to the goal can be found; returns how many nodes were expanded.
    fn run(&mut self) -> u32 {
        let Self { start, goal, .. } = *self;
        let cells = self.width * self.height;
        let workspace = &mut *self.workspace;
        if workspace.nodes.len() < cells || workspace.round == u16::MAX {
            workspace.nodes.clear();
            workspace.nodes.resize(cells, Node::default());
            workspace.round = 0;
        }
        workspace.round += 1;
        let index = self.index(start);
        let estimate = self.estimate(start);
        self.workspace.open.begin(estimate);
        self.workspace.nodes[index] =
            Node { cost: 0, parent: start, round: self.workspace.round, ways: J::START };
        if start == goal {
            self.bound = 0;
            return 0;
        }
        self.leave(start, 0, J::START);
        let mut expanded = 1;
        while let Some(Reached { cost, place, onward }) = self.workspace.open.pop(self.bound) {
            // Since then it may have been reached by a shorter way.
            let is_stale = cost > self.workspace.nodes[self.index(place)].cost;
            if is_stale || cost + self.estimate(place) >= self.bound {
                continue;
            }
            expanded += 1;
            self.leave(place, cost, onward);
        }
        expanded
    }

    fn index(&self, place: Place) -> usize {
        usize::from(place.y) * self.width + usize::from(place.x)
    }

    fn estimate(&self, place: Place) -> Cost {
        let [dx, dy] = self.to_goal(place);
        J::MOVES.open_length(dx, dy).cost()
    }

    /// Columns and rows to the goal.
    fn to_goal(&self, place: Place) -> [i32; 2] {
        let (Place { x, y }, goal) = (place, self.goal);
        [i32::from(goal.x) - i32::from(x), i32::from(goal.y) - i32::from(y)]
    }

    /// The bitmaps that a straight way follows.
    #[inline]
    fn lines<const WAY: usize>(&self) -> &'a Woven<3> {
        let [rows, columns] = self.bitmaps.straights();
        if WAY < SOUTH { rows } else { columns }
    }

    /// The line through a place of those that go by `BY` along `ALONG` and by one across: their number. The
    /// place on it is the row, or the column if `ALONG` is one of these.
    #[inline]
    fn slanted<const ALONG: usize, const ACROSS: usize, const BY: usize>(&self, place: Place) -> usize {
        let (across, at) = along::<ALONG>(place);
        let length = if ALONG < SOUTH { self.width } else { self.height };
        let mut back = across * BY;
        if back >= length {
            back -= length;
            // Rarely a map is longer across.
            back = if back < length { back } else { back % length };
        }
        let line = at + if is_forth(ALONG) == is_forth(ACROSS) { length - back } else { back };
        if line < length { line } else { line - length }
    }

    /// By which ways to leave a turn that was come to straight.
    #[inline]
    fn onward<const WAY: usize>(&self, line: usize, at: usize) -> Ways {
        let lines = self.lines::<WAY>();
        let before = if is_forth(WAY) { at - 1 } else { at + 1 };
        let opens = |side| opens(lines, side, at, before);
        let [lower, higher] = J::TURNS_BY[WAY];
        let lower = if opens(line - 1) { lower } else { 0 };
        let higher = if opens(line + 1) { higher } else { 0 };
        1 << WAY | lower | higher
    }

    /// Jumps from a node by some ways.
    fn leave(&mut self, node: Place, cost: Cost, ways: Ways) {
        let leaves = |way: usize| ways >> way & 1 != 0;
        if leaves(EAST) {
            self.straight::<EAST>(node, cost);
        }
        if leaves(WEST) {
            self.straight::<WEST>(node, cost);
        }
        if leaves(SOUTH) {
            self.straight::<SOUTH>(node, cost);
        }
        if leaves(NORTH) {
            self.straight::<NORTH>(node, cost);
        }
        J::leave_slanted(self, node, cost, ways);
    }

    /// Jumps from a node straight to the next turn or the goal.
    fn straight<const WAY: usize>(&mut self, node: Place, cost: Cost) {
        let (line, at, stop) = self.stop::<WAY>(node);
        let (goal_line, goal_at) = along::<WAY>(self.goal);
        let (low, high) = (at.min(stop), at.max(stop));
        if line == goal_line && (low..=high).contains(&goal_at) {
            self.arrive(node, cost + goal_at.abs_diff(at) as Cost * STRAIGHT_COST);
        }
        self.turn::<WAY>(node, node, cost);
    }

    /// Jumps from `from`, which is on a slanted run from `node`, straight to the next turn.
    #[inline]
    fn turn<const WAY: usize>(&mut self, node: Place, from: Place, cost: Cost) {
        let (line, at, stop) = self.stop::<WAY>(from);
        if self.lines::<WAY>().bit(FREE, line, stop) {
            let turn = match WAY {
                EAST | WEST => Place { x: stop as u16, ..from },
                _ => Place { y: stop as u16, ..from },
            };
            let cost = cost + stop.abs_diff(at) as Cost * STRAIGHT_COST;
            self.reach(WAY, node, turn, cost, |query| query.onward::<WAY>(line, stop));
        }
    }

    /// Where a straight jump from `from` ends: line, place of `from`, and place of the end.
    #[inline]
    fn stop<const WAY: usize>(&self, from: Place) -> (usize, usize, usize) {
        let (line, at) = along::<WAY>(from);
        let lines = self.lines::<WAY>();
        let stop = if is_forth(WAY) {
            lines.next(STOPS, line, at + 1)
        } else {
            lines.previous(STOPS + 1, line, at - 1)
        };
        (line, at, stop)
    }

    /// Notes a way to the goal.
    fn arrive(&mut self, node: Place, cost: Cost) {
        if cost < self.bound {
            (self.bound, self.last) = (cost, node);
        }
    }

    /// Notes a way to a node, which is `onward` to be left by.
    #[inline]
    fn reach(
        &mut self,
        way: usize,
        parent: Place,
        place: Place,
        cost: Cost,
        onward: impl FnOnce(&Self) -> Ways,
    ) {
        let (index, round) = (self.index(place), self.workspace.round);
        let node = &self.workspace.nodes[index];
        let is_known = node.round == round;
        let ways = 1 << way;
        if is_known && (cost > node.cost || cost == node.cost && node.ways & ways != 0) {
            return;
        }
        let sum = cost + self.estimate(place);
        if sum >= self.bound {
            return;
        }
        let node = &mut self.workspace.nodes[index];
        if is_known && cost == node.cost {
            node.ways |= ways;
        } else {
            *node = Node { cost, parent, round, ways };
        }
        let onward = onward(self);
        self.workspace.open.push(sum, Reached { cost, place, onward });
    }

    /// Puts the way that was found into the workspace's path.
    fn trace(&mut self) {
        let Self { start, goal, .. } = *self;
        let width = self.width;
        let Workspace { nodes, path, .. } = &mut *self.workspace;
        path.restart(goal.cell());
        let (mut to, mut node) = (goal, self.last);
        while to != start {
            // Backwards, so the finer moves come last.
            let (from, back) = (to.cell(), node.cell());
            let [finer, other] = J::MOVES.open_way(back.x - from.x, back.y - from.y);
            [other, finer].into_iter().for_each(|(step, count)| path.run(step, count));
            to = node;
            node = nodes[usize::from(node.y) * width + usize::from(node.x)].parent;
        }
        path.reverse();
    }
}

/// The line of a place and its place on it.
#[inline]
fn along<const WAY: usize>(place: Place) -> (usize, usize) {
    let (x, y) = (usize::from(place.x), usize::from(place.y));
    if WAY < SOUTH { (y, x) } else { (x, y) }
}

/// Whether a line, which is beside a place `at`, is free there and blocked at the place `before`.
#[inline]
fn opens(lines: &Woven<3>, line: usize, at: usize, before: usize) -> bool {
    lines.bit(FREE, line, at) & !lines.bit(FREE, line, before)
}
