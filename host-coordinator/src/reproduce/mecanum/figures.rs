//! What the paper's figures show, on maps of ours.

use planning::{
    dwa::{Chassis, Velocity},
    grid::{Cell, Grid},
    rrt::{ImprovedWorkspace, Rrt, Tree, keep_necessary_nodes},
    search::{AStar, Planner, Workspace},
};

use super::{
    drive::{self, SEED},
    maps::{Drawn, MOVES},
    measure::improved,
};
use crate::{
    reproduce::{
        Failed,
        figure::{Content, Figure, Line, Mark},
    },
    site::SiteFrame,
};

/// Cells as they are counted here, as the paper counts none.
const FRAME: SiteFrame = SiteFrame { origin: 0, y_up: false };

/// All of them.
pub fn figures() -> Result<Vec<Figure>, Failed> {
    let map = drive::map()?;
    let mut figures = Vec::new();
    for (name, bias, title) in [
        ("mecanum-fig3a", 0.0, "Mecanum Fig. 3(a): a tree without goal bias"),
        ("mecanum-fig3b", Rrt::PAPER.goal_bias, "Mecanum Fig. 3(b): a tree with goal bias 0.7"),
    ] {
        let mut tree = Tree::default();
        let rrt = Rrt { goal_bias: bias, ..Rrt::PAPER };
        // A tree that gave up is drawn as it is.
        let reached = rrt.grow(&map.grid, map.from, map.to, SEED, &mut tree).is_ok();
        let mut lines: Vec<Line> = tree.branches().map(|(start, end)| line("tree", &[start, end])).collect();
        if reached {
            lines.push(line("path", &tree.path()));
        }
        figures.push(on_map(name, title, &map, lines));
    }
    figures.push(necessary(&map));
    figures.push(paths(&map)?);
    figures.extend(drives(&map)?);
    Ok(figures)
}

/// Figs. 4, 5: what is necessary of a path.
fn necessary(map: &Drawn) -> Figure {
    let mut tree = Tree::default();
    let path = match Rrt::PAPER.grow(&map.grid, map.from, map.to, SEED, &mut tree) {
        Ok(()) => tree.path(),
        Err(_) => Vec::new(),
    };
    let mut kept = path.clone();
    keep_necessary_nodes(&map.grid, &mut kept);
    let lines = vec![line("the tree's path", &path), line("its necessary nodes", &kept)];
    on_map("mecanum-fig5", "Mecanum Fig. 5: a path before and after", map, lines)
}

/// Figs. 7, 12: both planners' paths.
fn paths(map: &Drawn) -> Result<Figure, Failed> {
    let mut workspace = ImprovedWorkspace::default();
    let cells: Vec<Cell> =
        improved(&map.grid, SEED).plan(map.from, map.to, &mut workspace)?.path.waypoints().to_vec();
    let mut astar = Workspace::default();
    let shortest = AStar::new(&map.grid, MOVES).plan(map.from, map.to, &mut astar)?.path.waypoints().to_vec();
    let lines =
        vec![line("A*", &shortest), line("improved A*", &cells), line("necessary nodes", workspace.nodes())];
    Ok(on_map("mecanum-fig12", "Mecanum Fig. 12: A* and the improved A*", map, lines))
}

/// The drive along the improved path, and its velocities.
fn drives(map: &Drawn) -> Result<[Figure; 2], Failed> {
    let drive = drive::drive()?;
    let curve = |label: &str, of: fn(&Velocity) -> f64| {
        let points = drive.velocities.iter().enumerate();
        let points = points.map(|(tick, velocity)| (tick as f64 * Chassis::PAPER.tick_s, of(velocity)));
        Line { label: label.into(), points: points.collect() }
    };
    let lines = vec![
        curve("forward", |velocity| velocity.forward_mps),
        curve("left", |velocity| velocity.left_mps),
        curve("turn, at the wheels", |velocity| velocity.turn_radps * Chassis::PAPER.arm_m),
    ];
    let track = vec![Line { label: "driven".into(), points: drive.track.clone() }];
    Ok([
        Figure {
            name: "mecanum-dwa-velocities".into(),
            title: "The dynamic window approach on the Mecanum chassis".into(),
            content: Content::Curves { x: "time, s".into(), y: "speed, m/s".into(), lines },
        },
        on_map("mecanum-dwa-track", "The way that the robot drove", map, track),
    ])
}

fn on_map(name: &str, title: &str, map: &Drawn, lines: Vec<Line>) -> Figure {
    let mark = |label: &str, cell: Cell| Mark { label: label.into(), at: point(cell) };
    let marks = vec![mark("start", map.from), mark("goal", map.to)];
    let grid: Grid = map.grid.clone();
    Figure {
        name: name.into(),
        title: title.into(),
        content: Content::Map { grid, frame: FRAME, lines, marks },
    }
}

fn line(label: &str, cells: &[Cell]) -> Line {
    Line { label: label.into(), points: cells.iter().copied().map(point).collect() }
}

fn point(cell: Cell) -> (f64, f64) {
    (cell.x.into(), cell.y.into())
}
