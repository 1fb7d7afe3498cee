//! Experiments 1 and 2: six charging points in one place, on the map of `sites/access-fig1`.
//!
//! It is drawn to the text, so that lengths are ours alone. What can be compared is who goes where, and
//! whether paths collide. Who goes where is what the coordinator answers ([`scenario`]).

use std::{collections::BTreeSet, sync::Arc};

use planning::{
    grid::{Cell, Grid},
    path::Path,
    search::{AStar, Planner, Workspace},
    virtual_obstacles::with_virtual_obstacles,
};

use super::{
    Failed, PAPER,
    published::{CHARGED_POINT, CHECK_S, DEPOT_START, EMPTY_POINT},
    scenario,
};
use crate::{
    reproduce::{
        Row, Value,
        figure::{Content, Figure, Line, Mark, Series},
    },
    site::{Site, SitePile},
};

/// Where the robot of Experiment 2 that leaves goes to; the paper does not print it.
const LEAVES_FOR: [i32; 2] = [90, 40];
/// How fast robots drive for Fig. 2a, in cells a second; the paper does not print it.
const SPEED: f64 = 1.0;

const DRAWN: &str = "on a map drawn to the text";

struct Depot {
    site: Arc<Site>,
    start: Cell,
    workspace: Workspace,
}

/// Experiment 1: the coordinator's path straight to the free point, and the one from point to point until it is
/// found.
struct Search {
    point: u16,
    direct: Path,
    in_turn: Path,
    checks: usize,
}

/// Experiment 2: whose point becomes free, the path of the robot that arrives, and both of the one that leaves.
struct Exchange {
    point: u16,
    arriving: Path,
    shortest: Path,
    avoiding: Path,
}

impl Depot {
    fn new() -> Result<Self, Failed> {
        let site = Arc::new(Site::access_fig1()?);
        let start = site.cell_at(DEPOT_START[0], DEPOT_START[1])?;
        Ok(Self { site, start, workspace: Workspace::default() })
    }

    fn path(&mut self, from: Cell, to: Cell) -> Result<Path, Failed> {
        path(&self.site.grid, &self.site, from, to, &mut self.workspace)
    }

    /// The traditional robot looks at point after point, the nearest first.
    fn search(&mut self) -> Result<Search, Failed> {
        let free = |pile: &SitePile| usize::from(pile.id.0) == EMPTY_POINT;
        let charged = |pile: &SitePile| pile.charged.filter(|_| !free(pile));
        let answer = scenario::ask(&self.site, self.start, charged);
        let mut lengths = Vec::new();
        for pile in self.site.piles.clone() {
            lengths.push((self.path(self.start, pile.cell)?.length(), pile));
        }
        lengths.sort_by_key(|&(length, pile)| (length, pile.id));
        let mut in_turn = Path::at(self.start);
        let mut checks = 0;
        for (_, pile) in lengths {
            let leg = self.path(in_turn.end(), pile.cell)?;
            in_turn = in_turn.clone().then(&leg).unwrap_or(in_turn);
            checks += 1;
            if free(&pile) {
                break;
            }
        }
        Ok(Search {
            point: answer.pile.map_or(0, |pile| pile.0),
            direct: answer.way.unwrap_or_else(|| Path::at(self.start)),
            in_turn,
            checks,
        })
    }

    /// All points are occupied: whose charge the coordinator cuts short, and where the robot goes that asked.
    fn exchange(&mut self) -> Result<Exchange, Failed> {
        let answer = scenario::ask(&self.site, self.start, |pile| pile.charged);
        let arriving = answer.way.unwrap_or_else(|| Path::at(self.start));
        let (point, dock) = (answer.makes_room.map_or(0, |pile| pile.0), arriving.end());
        let goal = self.site.cell_at(LEAVES_FOR[0], LEAVES_FOR[1])?;
        let shortest = self.path(dock, goal)?;
        let open = with_virtual_obstacles(&self.site.grid, &arriving, dock, goal);
        let avoiding = path(&open, &self.site, dock, goal, &mut self.workspace)?;
        Ok(Exchange { point, arriving, shortest, avoiding })
    }
}

fn path(grid: &Grid, site: &Site, from: Cell, to: Cell, workspace: &mut Workspace) -> Result<Path, Failed> {
    Ok(AStar::new(grid, site.moves).plan(from, to, workspace)?.path.clone())
}

/// Seconds from the request to the point, without planning, which takes well below a millisecond.
fn seconds(path: &Path, checks: usize) -> f64 {
    path.length().units() / SPEED + CHECK_S * checks as f64
}

/// How many cells besides the charging point are on both paths.
fn shared(arriving: &Path, leaving: &Path) -> usize {
    let cells: BTreeSet<_> = arriving.cells().collect();
    leaving.cells().filter(|&cell| cell != arriving.end() && cells.contains(&cell)).count()
}

/// Experiment 1: a point is free.
pub(super) fn experiment_1() -> Result<Vec<Row>, Failed> {
    let Search { point, direct, in_turn, checks } = Depot::new()?.search()?;
    let table = "Experiment 1";
    let text = |point: usize| Value::Text(format!("point {point}"));
    let ours = |column, value| PAPER.compared(table, "Fig. 2a", column, Value::Missing, Value::Number(value));
    let bars = "Fig. 2a's numbers are not in the text";
    Ok(vec![
        PAPER.compared(table, "proposed", "goes to", text(EMPTY_POINT), text(point.into())).noted(DRAWN),
        PAPER
            .compared(
                table,
                "traditional",
                "points looked at",
                Value::printed("5"),
                Value::Number(checks as f64),
            )
            .noted(DRAWN),
        ours("traditional, s", seconds(&in_turn, checks)).uncompared(format!("{bars}; {DRAWN}, at 1 cell/s")),
        ours("proposed, s", seconds(&direct, 0)).uncompared(format!("{bars}; {DRAWN}, at 1 cell/s")),
        ours("traditional / proposed", seconds(&in_turn, checks) / seconds(&direct, 0)).uncompared(bars),
    ])
}

/// Experiment 2: all points are occupied.
pub(super) fn experiment_2() -> Result<Vec<Row>, Failed> {
    let Exchange { point, arriving, shortest, avoiding } = Depot::new()?.exchange()?;
    let table = "Experiment 2";
    let text = |text: &str| Value::Text(text.to_owned());
    let meeting = |leaving| text(if shared(&arriving, leaving) > 0 { "collide" } else { "keep apart" });
    let [straight, around] = [&shortest, &avoiding].map(|path| path.length());
    let longer = text(if around > straight { "longer" } else { "as long" });
    let length = |row, path: &Path| {
        let length = Value::Number(path.length().units());
        PAPER
            .compared(table, row, "length", Value::Missing, length)
            .uncompared(format!("not printed; {DRAWN}"))
    };
    let (published, ours) = (format!("point {CHARGED_POINT}"), format!("point {point}"));
    Ok(vec![
        PAPER
            .compared(table, "makes room", "robot on", text(&published), text(&ours))
            .noted("92 % is printed; the others' charge is ours, and lower"),
        PAPER.compared(table, "traditional", "paths", text("collide"), meeting(&shortest)).noted(DRAWN),
        PAPER
            .compared(table, "proposed, eq. 7", "paths", text("keep apart"), meeting(&avoiding))
            .noted(DRAWN),
        PAPER.compared(table, "proposed, eq. 7", "way out", text("longer"), longer).noted(DRAWN),
        length("arriving", &arriving),
        length("leaving, shortest", &shortest),
        length("leaving, eq. 7", &avoiding),
    ])
}

/// Figs. 1a to 1c, 2a and 2b.
pub(super) fn figures() -> Result<Vec<Figure>, Failed> {
    let mut depot = Depot::new()?;
    let search = depot.search()?;
    let exchange = depot.exchange()?;
    let site = &depot.site;
    let mut marks: Vec<_> =
        site.piles.iter().map(|pile| Mark::on(format!("{}", pile.id), pile.cell)).collect();
    marks.push(Mark::on("start", depot.start));
    let map = |name: &str, title: &str, lines: Vec<Line>, more: Vec<Mark>| Figure {
        name: format!("access-{name}"),
        title: format!("Access, {title}"),
        content: Content::Map {
            grid: site.grid.clone(),
            frame: site.frame,
            lines,
            marks: [marks.clone(), more].concat(),
        },
    };
    let goal = || vec![Mark::on("goal", exchange.shortest.end())];
    let arriving = || Line::of_path("arriving", &exchange.arriving);
    let groups =
        |prefix: &str| -> Vec<_> { site.piles.iter().map(|pile| format!("{prefix} {}", pile.id)).collect() };
    let charge = site.piles.iter().map(|pile| 100.0 * pile.charged.unwrap_or_default()).collect();
    let times = vec![seconds(&search.in_turn, search.checks), seconds(&search.direct, 0)];
    let bars = |name: &str, title: &str, groups, y: &str, label: &str, values| Figure {
        name: format!("access-{name}"),
        title: format!("Access, {title}"),
        content: Content::Bars { groups, y: y.into(), series: vec![Series { label: label.into(), values }] },
    };
    Ok(vec![
        map(
            "experiment-1",
            "Experiment 1 (Fig. 1a): to the one free point",
            vec![
                Line::of_path("traditional, point after point", &search.in_turn),
                Line::of_path("proposed", &search.direct),
            ],
            vec![],
        ),
        map(
            "experiment-2-traditional",
            "Experiment 2 (Fig. 1b): shortest paths collide",
            vec![arriving(), Line::of_path("leaving, shortest", &exchange.shortest)],
            goal(),
        ),
        map(
            "experiment-2-proposed",
            "Experiment 2 (Fig. 1c): eq. 7 keeps them apart",
            vec![arriving(), Line::of_path("leaving, eq. 7", &exchange.avoiding)],
            goal(),
        ),
        bars(
            "fig-2a",
            "Fig. 2a: time to the free point of Experiment 1",
            vec!["traditional".into(), "proposed".into()],
            "time (s)",
            "15 s a check, driving 1 cell/s",
            times,
        ),
        bars(
            "fig-2b",
            "Fig. 2b: charge in Experiment 2",
            groups("point"),
            "charge (%)",
            "92 % is printed, the others are ours",
            charge,
        ),
    ])
}
