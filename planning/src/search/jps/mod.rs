//! Jump point search (Harabor and Grastien) by blocks, for 8 neighbours that cut no corner.
//!
//! Of all shortest paths only those are followed that go diagonally first and turn where a wall makes
//! them. So nodes are the few cells where a straight run passes the end of a wall beside it, and a move
//! is a whole jump: some diagonal moves, then some straight ones to the next such cell. Where jumps end
//! is kept as `bitmaps` along rows, columns and both diagonals, so that a jump over 64 cells, straight
//! or diagonal, costs a few operations on a word, and a diagonal stops only where a straight jump from it
//! leads somewhere. They take 12 bits a cell and are made in a fraction of a millisecond.

mod bitmaps;
mod lines;
mod woven;

use bitmaps::{Bitmaps, FREE, STOPS, TURNS, WALLS};
use woven::Woven;

use super::{Open, Plan, Planner, SearchError, free_index};
use crate::{
    grid::{Cell, Grid},
    moves::{Cost, Length, MoveSet},
    path::Path,
};

/// Plans shortest paths with 8 neighbours by jump point search.
#[derive(Clone, Debug)]
pub struct Jps {
    grid: Grid,
    bitmaps: Bitmaps,
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
/// south-east, south-west, north-east and north-west.
type Ways = u8;

const EAST: usize = 0;
const WEST: usize = 1;
const SOUTH: usize = 2;
const NORTH: usize = 3;
const STRAIGHT: Ways = 0b1111;

const STRAIGHT_COST: Cost = Length::of((1, 0)).cost();
const DIAGONAL_COST: Cost = Length::of((1, 1)).cost();

/// Who passes the end of a wall on the side of the lower line, or of the higher, turns by these ways.
const TURNS_BY: [[Ways; 2]; 4] = [
    [1 << NORTH | 1 << 6, 1 << SOUTH | 1 << 4],
    [1 << NORTH | 1 << 7, 1 << SOUTH | 1 << 5],
    [1 << WEST | 1 << 5, 1 << EAST | 1 << 4],
    [1 << WEST | 1 << 7, 1 << EAST | 1 << 6],
];

impl Jps {
    /// A planner for `grid`.
    #[must_use]
    pub fn new(grid: Grid) -> Self {
        let bitmaps = Bitmaps::of(&grid);
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
        self.bitmaps.bytes()
    }
}

impl Planner for Jps {
    type Workspace = Workspace;

    fn plan<'w>(&self, from: Cell, to: Cell, workspace: &'w mut Workspace) -> Result<Plan<'w>, SearchError> {
        free_index(&self.grid, from)?;
        free_index(&self.grid, to)?;
        let mut query = Query {
            bitmaps: &self.bitmaps,
            width: self.grid.width() as usize + 2,
            cells: (self.grid.width() as usize + 2) * (self.grid.height() as usize + 2),
            start: Place::of(from),
            goal: Place::of(to),
            bound: Cost::MAX,
            last: Place::of(from),
            workspace,
        };
        let expanded = query.run();
        if query.bound == Cost::MAX {
            return Err(SearchError::NoPath { from, to });
        }
        query.trace();
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

struct Query<'a> {
    bitmaps: &'a Bitmaps,
    width: usize,
    cells: usize,
    start: Place,
    goal: Place,
    /// The length of the shortest way to the goal so far.
    bound: Cost,
    /// The last node on it.
    last: Place,
    workspace: &'a mut Workspace,
}

impl Query<'_> {
    /// Searches until no shorter way to the goal can be found; returns how many nodes were expanded.
    fn run(&mut self) -> u32 {
        let Self { start, goal, .. } = *self;
        let cells = self.cells;
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
            Node { cost: 0, parent: start, round: self.workspace.round, ways: STRAIGHT };
        if start == goal {
            self.bound = 0;
            return 0;
        }
        self.leave(start, 0, u8::MAX);
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
        let long = place.x.abs_diff(self.goal.x);
        let short = place.y.abs_diff(self.goal.y);
        let (long, short) = (Cost::from(long.max(short)), Cost::from(long.min(short)));
        long * STRAIGHT_COST + short * (DIAGONAL_COST - STRAIGHT_COST)
    }

    /// By which ways to leave a turn.
    #[inline]
    fn onward<const WAY: usize>(&self, line: usize, at: usize) -> Ways {
        let lines = lines::<WAY>(self.bitmaps);
        let before = if WAY == EAST || WAY == SOUTH { at - 1 } else { at + 1 };
        let opens = |side| lines.bit(FREE, side, at) & !lines.bit(FREE, side, before);
        let [lower, higher] = TURNS_BY[WAY];
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
        if leaves(4) {
            self.diagonal::<EAST, SOUTH>(node, cost);
        }
        if leaves(5) {
            self.diagonal::<WEST, SOUTH>(node, cost);
        }
        if leaves(6) {
            self.diagonal::<EAST, NORTH>(node, cost);
        }
        if leaves(7) {
            self.diagonal::<WEST, NORTH>(node, cost);
        }
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

    /// Jumps from `from`, which is on a diagonal from `node`, straight to the next turn.
    #[inline]
    fn turn<const WAY: usize>(&mut self, node: Place, from: Place, cost: Cost) {
        let (line, at, stop) = self.stop::<WAY>(from);
        if lines::<WAY>(self.bitmaps).bit(FREE, line, stop) {
            let turn = match WAY {
                EAST | WEST => Place { x: stop as u16, ..from },
                _ => Place { y: stop as u16, ..from },
            };
            self.reach::<WAY>(node, turn, cost + stop.abs_diff(at) as Cost * STRAIGHT_COST);
        }
    }

    /// Where a straight jump from `from` ends: line, place of `from`, and place of the end.
    #[inline]
    fn stop<const WAY: usize>(&self, from: Place) -> (usize, usize, usize) {
        let (line, at) = along::<WAY>(from);
        let lines = lines::<WAY>(self.bitmaps);
        let stop = if WAY == EAST || WAY == SOUTH {
            lines.next(STOPS, line, at + 1)
        } else {
            lines.previous(STOPS + 1, line, at - 1)
        };
        (line, at, stop)
    }

    /// Jumps from a node along a diagonal, and straight from wherever on it that leads to a turn.
    #[inline]
    fn diagonal<const COLUMNS: usize, const ROWS: usize>(&mut self, node: Place, cost: Cost) {
        let (x, y) = (usize::from(node.x), usize::from(node.y));
        let (width, is_falling) = (self.width, (COLUMNS == EAST) == (ROWS == SOUTH));
        let bitmaps = self.bitmaps;
        let lines = if is_falling { &bitmaps.falling } else { &bitmaps.rising };
        // Rarely a map is higher than wide.
        let down = if y < width { y } else { y % width };
        let line = x + if is_falling { width - down } else { down };
        let line = if line < width { line } else { line - width };
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
        let (dx, dy) =
            (i32::from(self.goal.x) - i32::from(node.x), i32::from(self.goal.y) - i32::from(node.y));
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

    /// Notes a way to the goal.
    fn arrive(&mut self, node: Place, cost: Cost) {
        if cost < self.bound {
            (self.bound, self.last) = (cost, node);
        }
    }

    /// Notes a way to a node.
    #[inline]
    fn reach<const WAY: usize>(&mut self, parent: Place, place: Place, cost: Cost) {
        let (index, round) = (self.index(place), self.workspace.round);
        let node = &self.workspace.nodes[index];
        let is_known = node.round == round;
        let ways = 1 << WAY;
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
        let (line, at) = along::<WAY>(place);
        let onward = self.onward::<WAY>(line, at);
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
            // Backwards, so the straight moves come first.
            let (from, back) = (to.cell(), node.cell());
            let (dx, dy) = (back.x - from.x, back.y - from.y);
            let Length { straight, diagonal, .. } = MoveSet::Eight.open_length(dx, dy);
            let along = if dx.abs() > dy.abs() { (dx.signum(), 0) } else { (0, dy.signum()) };
            path.run(along, straight);
            path.run((dx.signum(), dy.signum()), diagonal);
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
    if WAY == EAST || WAY == WEST { (y, x) } else { (x, y) }
}

#[inline]
const fn lines<const WAY: usize>(bitmaps: &Bitmaps) -> &Woven {
    if WAY == EAST || WAY == WEST { &bitmaps.rows } else { &bitmaps.columns }
}
