//! From a wolf's nodes to a path on the grid.

use super::{Ground, line, point::Point};
use crate::{grid::Cell, path::shortcut};

/// How nodes become a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Routing {
    /// Straight from node to node (IGWO, 3.1); an obstacle on the way and there is no path.
    Joined,
    /// The nodes guide (IGWO, 3.2.2), and what is found is shortened and interpolated (3.2.1).
    Guided,
}

impl Routing {
    /// Puts the turns of the path into `turns`, start and goal included, or nothing if there is none.
    pub fn route(self, ground: Ground<'_>, nodes: &mut [Point], turns: &mut Vec<Cell>) {
        match self {
            Self::Joined => join(ground, nodes, turns),
            Self::Guided => {
                guide(ground, nodes, turns);
                self.improve(ground, nodes, turns);
            }
        }
    }

    /// Shortens a path and spreads the nodes over it, as far as that belongs to this routing.
    pub fn improve(self, ground: Ground<'_>, nodes: &mut [Point], turns: &mut Vec<Cell>) {
        if self == Self::Guided && !turns.is_empty() {
            shorten(ground, turns);
            spread(turns, nodes);
        }
    }
}

fn join(ground: Ground<'_>, nodes: &[Point], turns: &mut Vec<Cell>) {
    turns.clear();
    turns.push(ground.from);
    let mut here = ground.from;
    for next in nodes.iter().map(|node| node.cell()).chain([ground.to]) {
        if !line::is_open(ground.grid, here, next) {
            turns.clear();
            return;
        }
        if next != here {
            turns.push(next);
        }
        here = next;
    }
}

/// The location update (IGWO, 3.2.2): from where it is, the robot goes straight towards the next node
/// until an obstacle stops it, and on from there; once it sees the goal it goes there.
fn guide(ground: Ground<'_>, nodes: &[Point], turns: &mut Vec<Cell>) {
    turns.clear();
    turns.push(ground.from);
    let mut here = ground.from;
    let mut nodes = nodes.iter();
    while !line::is_open(ground.grid, here, ground.to) {
        let Some(node) = nodes.next() else {
            turns.clear();
            return;
        };
        let stop = line::advance(ground.grid, here, node.cell());
        if stop != here {
            turns.push(stop);
        }
        here = stop;
    }
    if here != ground.to {
        turns.push(ground.to);
    }
}

/// Steps 2 and 3 of the interpolation (IGWO, 3.2.1): of each turn's successors only the last that is
/// in sight stays.
fn shorten(ground: Ground<'_>, turns: &mut Vec<Cell>) {
    shortcut(turns, |here, next| line::is_open(ground.grid, here, next));
}

/// Step 4 of the interpolation (IGWO, 3.2.1): as many nodes as before, at equal distances.
pub(super) fn spread(turns: &[Cell], nodes: &mut [Point]) {
    let pieces = || turns.iter().zip(turns.iter().skip(1)).map(|(&from, &to)| (Point::from(from), to.into()));
    let spacing = pieces().fold(0.0, |sum, (from, to)| sum + from.distance(to)) / (nodes.len() + 1) as f64;
    let start = turns.first().copied().map(Point::from).unwrap_or_default();
    let mut pieces = pieces();
    let mut piece = (start, start);
    // Where the piece ends, in distance from the start.
    let mut end = 0.0;
    for (number, node) in nodes.iter_mut().enumerate() {
        let at = spacing * (number + 1) as f64;
        while end < at {
            let Some(next) = pieces.next() else { break };
            piece = next;
            end += piece.0.distance(piece.1);
        }
        let length = piece.0.distance(piece.1);
        let share = if length > 0.0 { 1.0 - (end - at).max(0.0) / length } else { 0.0 };
        *node = piece.0.towards(piece.1, share);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::movingai::read_map;

    const WALL: &str = "type octile\nheight 5\nwidth 7\nmap\n.......\n...@...\n...@...\n...@...\n...@...\n";

    fn route(routing: Routing, nodes: &mut [Point]) -> Vec<Cell> {
        let grid = read_map(WALL).unwrap();
        let ground = Ground { grid: &grid, from: (0, 4).into(), to: (6, 4).into() };
        let mut turns = vec![Cell::default(); 3];
        routing.route(ground, nodes, &mut turns);
        turns
    }

    fn points<const N: usize>(points: [(f64, f64); N]) -> [Point; N] {
        points.map(|(x, y)| Point { x, y })
    }

    #[test]
    fn joined_nodes_in_the_wall_are_no_path_and_guiding_nodes_are_one_round_it() {
        let through = points([(2.0, 0.4), (3.2, 1.9), (4.0, 0.0)]);
        assert_eq!(route(Routing::Joined, &mut through.clone()), []);
        let round = [(0, 4), (2, 0), (4, 0), (6, 4)].map(Cell::from);
        assert_eq!(route(Routing::Guided, &mut through.clone()), round);
        assert_eq!(route(Routing::Joined, &mut points([(2.0, 0.0), (4.0, 0.0)])), round);
    }

    #[test]
    fn guiding_nodes_that_never_show_the_goal_are_no_path() {
        assert_eq!(route(Routing::Guided, &mut points([(6.0, 4.0), (0.0, 0.0), (3.0, 3.0)])), []);
    }

    #[test]
    fn of_turns_in_sight_of_each_other_the_last_stays() {
        let grid = read_map(WALL).unwrap();
        let ground = Ground { grid: &grid, from: (0, 4).into(), to: (6, 4).into() };
        let mut turns = [(0, 4), (0, 1), (2, 1), (2, 0), (4, 0), (5, 0), (6, 4)].map(Cell::from).to_vec();
        shorten(ground, &mut turns);
        assert_eq!(turns, [(0, 4), (2, 0), (5, 0), (6, 4)].map(Cell::from));
    }

    #[test]
    fn nodes_are_spread_at_equal_distances() {
        let mut nodes = [Point::default(); 3];
        spread(&[(0, 0), (4, 0), (4, 4)].map(Cell::from), &mut nodes);
        assert_eq!(nodes, points([(2.0, 0.0), (4.0, 0.0), (4.0, 2.0)]));
        spread(&[Cell { x: 3, y: 3 }], &mut nodes);
        assert_eq!(nodes, [Point { x: 3.0, y: 3.0 }; 3]);
    }
}
