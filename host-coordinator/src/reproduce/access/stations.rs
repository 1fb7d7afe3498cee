//! Experiments 3 and 4: twelve stations on the map of `sites/access-fig3`.

use std::time::Instant;

use planning::{
    grid::Cell,
    path::Path,
    search::{AStar, Dijkstra, Planner, Workspace},
};

use super::{
    Failed, PAPER,
    published::{PLANNING_MS, START, TABLE_3, TABLE_4, TABLE_5},
};
use crate::{
    reproduce::{
        Row, Value,
        figure::{Content, Figure, Line, Mark, Series},
    },
    site::Site,
};

const FITTED: &str = "the map was fitted to it";

struct Stations {
    site: Site,
    start: Cell,
    workspace: Workspace,
}

impl Stations {
    fn new() -> Result<Self, Failed> {
        let site = Site::access_fig3()?;
        let start = site.cell_at(START[0], START[1])?;
        Ok(Self { site, start, workspace: Workspace::default() })
    }

    /// The cell of a station, by Table 3.
    fn station(&self, name: &str) -> Result<Cell, Failed> {
        let found = TABLE_3.iter().find(|(known, _)| *known == name).map_or(START, |&(_, at)| at);
        Ok(self.site.cell_at(found[0], found[1])?)
    }

    fn path(&mut self, from: Cell, to: Cell) -> Result<Path, Failed> {
        let search = AStar::new(&self.site.grid, self.site.moves);
        Ok(search.plan(from, to, &mut self.workspace)?.path.clone())
    }

    /// From the start to each of these stations in turn.
    fn tour(&mut self, order: &[&str]) -> Result<Path, Failed> {
        let mut tour = Path::at(self.start);
        for name in order {
            let leg = self.path(tour.end(), self.station(name)?)?;
            tour = tour.clone().then(&leg).unwrap_or(tour);
        }
        Ok(tour)
    }

    /// From the start to each station alone.
    fn direct(&mut self) -> Result<Vec<(&'static str, Path)>, Failed> {
        let to = |(name, _)| Ok((name, self.tour(&[name])?));
        TABLE_3.into_iter().map(to).collect()
    }

    /// The stations that are nearer to `from` than `to` is.
    fn nearer(&mut self, from: Cell, to: Cell) -> Result<Vec<&'static str>, Failed> {
        let stations: Vec<_> = self.site.piles.iter().map(|pile| pile.cell).collect();
        let search = Dijkstra::new(&self.site.grid, self.site.moves);
        let ways = search.ways(from, &stations, &mut self.workspace)?;
        let names = TABLE_3.iter().map(|&(name, _)| name).zip(stations);
        let length = ways.length_to(to);
        Ok(names.filter(|&(_, cell)| ways.length_to(cell) < length).map(|(name, _)| name).collect())
    }
}

/// Table 3: the site file has what is printed.
pub(super) fn table_3() -> Result<Vec<Row>, Failed> {
    let site = Stations::new()?.site;
    let row = |((name, printed), pile): ((&str, [i32; 2]), &crate::site::SitePile)| {
        let (x, y) = site.coordinates(pile.cell);
        let text = |x, y| Value::Text(format!("({x}, {y})"));
        PAPER
            .compared("3", name, "position", text(printed[0], printed[1]), text(x, y))
            .noted("an input, as the site file has it")
    };
    Ok(TABLE_3.into_iter().zip(&site.piles).map(row).collect())
}

/// Table 4: searching all stations until the last, which is free.
pub(super) fn table_4() -> Result<Vec<Row>, Failed> {
    let mut stations = Stations::new()?;
    let row = |(name, order, printed): (&str, [&str; 12], _)| {
        let tour = stations.tour(&order)?.length().units();
        Ok(PAPER.compared("4", name, "distance", Value::printed(printed), Value::Number(tour)).noted(FITTED))
    };
    TABLE_4.into_iter().map(row).collect()
}

/// Fig. 6: straight to each station; and how much further the searches of Table 4 drive.
pub(super) fn fig_6() -> Result<Vec<Row>, Failed> {
    let why = "Fig. 6's numbers are not in the text";
    let row = |(name, path): (&str, Path)| {
        let length = Value::Number(path.length().units());
        PAPER.compared("Fig. 6", name, "distance", Value::Missing, length).uncompared(why)
    };
    Ok(Stations::new()?.direct()?.into_iter().map(row).collect())
}

/// Experiment 3: planning times of both searches and of direct access.
pub(super) fn experiment_3() -> Result<Vec<Row>, Failed> {
    let mut stations = Stations::new()?;
    let tours = TABLE_4.map(|(_, order, _)| order);
    let (random, sequential) = tours.split_at(tours.len() - 1);
    let mut millis = |orders: &[&[&str]]| -> Result<f64, Failed> {
        let begun = Instant::now();
        for order in orders {
            stations.tour(order)?;
        }
        Ok(begun.elapsed().as_secs_f64() * 1_000.0 / orders.len().max(1) as f64)
    };
    let whole = |tours: &'_ [[&'static str; 12]]| tours.to_vec();
    let random = whole(random);
    let sequential = whole(sequential);
    let direct: Vec<[&str; 1]> = TABLE_3.map(|(name, _)| [name]).into();
    // Once for nothing, so that all find the workspace ready.
    millis(&[&["A1"]])?;
    let ours = [
        millis(&random.iter().map(<[_; 12]>::as_slice).collect::<Vec<_>>())?,
        millis(&sequential.iter().map(<[_; 12]>::as_slice).collect::<Vec<_>>())?,
        millis(&direct.iter().map(<[_; 1]>::as_slice).collect::<Vec<_>>())?,
    ];
    let mut rows = Vec::new();
    let names = ["random search", "sequential search", "direct access"];
    for ((name, printed), ours) in names.into_iter().zip(PLANNING_MS).zip(ours) {
        let row =
            PAPER.compared("Experiment 3", name, "planning, ms", Value::Number(printed), Value::Number(ours));
        rows.push(row.uncompared("another computer, Python"));
    }
    let ratio = |[random, _, direct]: [f64; 3]| Value::Number(random / direct);
    let row = PAPER.compared("Experiment 3", "random / direct", "planning", ratio(PLANNING_MS), ratio(ours));
    rows.push(row.uncompared("the ratio on either computer"));
    Ok(rows)
}

/// Table 5: from random starts to the nearest free station.
pub(super) fn table_5() -> Result<Vec<Row>, Failed> {
    let mut stations = Stations::new()?;
    let mut rows = Vec::new();
    for ([y, x], name, printed) in TABLE_5 {
        let (from, to) = (stations.site.cell_at(x, y)?, stations.station(name)?);
        let length = stations.path(from, to)?.length().units();
        let row = format!("({y}, {x}) to {name}");
        let mut row = PAPER.compared("5", row, "distance", Value::printed(printed), Value::Number(length));
        row.add_note("the start is printed as (y, x)");
        let nearer = stations.nearer(from, to)?;
        if !nearer.is_empty() {
            row.add_note(&format!("{} nearer here, so they must have been occupied", nearer.join(", ")));
        }
        rows.push(row.noted(FITTED));
    }
    Ok(rows)
}

/// Figs. 4 to 7.
pub(super) fn figures() -> Result<Vec<Figure>, Failed> {
    let mut stations = Stations::new()?;
    let mut figures = Vec::new();
    for (name, order, _) in TABLE_4 {
        let tour = stations.tour(&order)?;
        let title = format!("Access, Experiment 3 (Fig. 4): {name}, the last station is free");
        let line = Line::of_path(format!("search, {:.1} cells", tour.length().units()), &tour);
        figures.push(stations.map(
            format!("access-fig-4-{}", name.to_lowercase()),
            title,
            vec![line],
            true,
        )?);
    }
    let direct = stations.direct()?;
    let of_place = |(name, path): &(&str, Path)| {
        let place = name.chars().next().unwrap_or_default();
        Line::of_path(format!("to {place}1, {place}2, {place}3"), path)
    };
    let lines = direct.iter().map(of_place).collect();
    let title = "Access, Experiment 3 (Fig. 5): straight to the free station".to_owned();
    figures.push(stations.map("access-fig-5".into(), title, lines, true)?);
    figures.push(Figure {
        name: "access-fig-6".into(),
        title: "Access, Fig. 6: distance from the start to each station".into(),
        content: Content::Bars {
            groups: direct.iter().map(|(name, _)| (*name).to_owned()).collect(),
            y: "distance (cells)".into(),
            series: vec![Series {
                label: "direct access".into(),
                values: direct.iter().map(|(_, path)| path.length().units()).collect(),
            }],
        },
    });
    let mut lines = Vec::new();
    for ([y, x], name, _) in TABLE_5 {
        let (from, to) = (stations.site.cell_at(x, y)?, stations.station(name)?);
        lines.push(Line::of_path("to the nearest free station", &stations.path(from, to)?));
    }
    let title = "Access, Experiment 4 (Fig. 7): from random starts".to_owned();
    let mut figure = stations.map("access-experiment-4".into(), title, lines, false)?;
    if let Content::Map { marks, .. } = &mut figure.content {
        for (number, ([y, x], ..)) in (1..).zip(TABLE_5) {
            marks.push(Mark::on(format!("({number})"), stations.site.cell_at(x, y)?));
        }
    }
    figures.push(figure);
    Ok(figures)
}

impl Stations {
    fn map(&self, name: String, title: String, lines: Vec<Line>, with_start: bool) -> Result<Figure, Failed> {
        let mut marks = Vec::new();
        for (name, _) in TABLE_3 {
            marks.push(Mark::on(name, self.station(name)?));
        }
        if with_start {
            marks.push(Mark::on("S", self.start));
        }
        let (grid, frame) = (self.site.grid.clone(), self.site.frame);
        Ok(Figure { name, title, content: Content::Map { grid, frame, lines, marks } })
    }
}
