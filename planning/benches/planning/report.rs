//! What was measured, as a table for people or as JSON.

use serde::Serialize;

use crate::Failure;
use crate::assignment::AssignmentReport;
use crate::doors::DoorsReport;
use crate::figures::Figure;
use crate::known::KnownReport;
use crate::queries::METHOD;
use crate::statistics::Summary;
use crate::tick::TickReport;

/// All that was measured.
#[derive(Debug, Default, Serialize)]
pub struct Report {
    pub maps: Vec<MapReport>,
    pub tick: Option<TickReport>,
    pub assignment: Option<AssignmentReport>,
    pub figures: Vec<Figure>,
}

/// What was measured on one map.
#[derive(Debug, Serialize)]
pub struct MapReport {
    pub map: String,
    pub width: u32,
    pub height: u32,
    pub free_cells: usize,
    pub planners: Vec<PlannerReport>,
    pub known: KnownReport,
}

/// What one planner took on a map.
#[derive(Debug, Serialize)]
pub struct PlannerReport {
    pub planner: &'static str,
    pub queries: usize,
    pub micros: Summary,
    /// Nodes, on average.
    pub expanded: Option<f64>,
    pub index_seconds: f64,
    pub index_bytes: Option<usize>,
    /// Queries whose length is not the optimal one or whose path can't be gone; not of peers with other rules.
    pub off: Option<usize>,
    /// How many times as long the peer takes for the same queries.
    pub times_pathfinding: Option<f64>,
    pub times_grid_pathfinding: Option<f64>,
}

impl Report {
    /// What a planner took on a map.
    pub fn planner(&self, map: &str, planner: &str) -> Option<&PlannerReport> {
        let map = self.maps.iter().find(|report| report.map == map)?;
        map.planners.iter().find(|report| report.planner == planner)
    }

    /// Prints it.
    pub fn print(&self, json: bool) -> Result<(), Failure> {
        if json {
            let text = serde_json::to_string_pretty(&serde_json::json!({ "method": METHOD, "report": self }));
            println!("{}", text.map_err(|error| Failure(format!("the report is no JSON: {error}")))?);
            return Ok(());
        }
        println!("{METHOD}\n");
        self.maps.iter().for_each(MapReport::print);
        if let Some(tick) = &self.tick {
            tick.print();
        }
        if let Some(assignment) = &self.assignment {
            assignment.print();
        }
        self.figures.iter().for_each(Figure::print);
        Ok(())
    }
}

impl MapReport {
    fn print(&self) {
        let Self { map, width, height, free_cells, planners, known } = self;
        println!("{map}: {width} x {height} cells, {free_cells} of them free");
        println!(
            "  {:<38} {:>7} {:>9} {:>9} {:>9} {:>9} {:>8} {:>9} {:>5} {:>12} {:>17}",
            "planner",
            "queries",
            "mean us",
            "median",
            "p99",
            "expanded",
            "index s",
            "KiB",
            "off",
            "/pathfinding",
            "/grid_pathfinding"
        );
        for planner in planners {
            let Summary { mean, median, p99 } = planner.micros;
            println!(
                "  {:<38} {:>7} {mean:>9.2} {median:>9.2} {p99:>9.2} {:>9} {:>8.3} {:>9} {:>5} {:>12} {:>17}",
                planner.planner,
                planner.queries,
                or_dash(planner.expanded.map(|nodes| format!("{nodes:.0}"))),
                planner.index_seconds,
                or_dash(planner.index_bytes.map(|bytes| bytes.div_ceil(1024))),
                or_dash(planner.off),
                or_dash(planner.times_pathfinding.map(|times| format!("{times:.1} x"))),
                or_dash(planner.times_grid_pathfinding.map(|times| format!("{times:.1} x"))),
            );
        }
        known.print();
        println!();
    }
}

impl KnownReport {
    fn print(&self) {
        let Self { piles, length, walk, nearest, off, build_ns, bytes_a_pile, bytes, doors } = self;
        println!("  {piles} known piles, {off} answers off");
        print_micros("length of a way", length);
        print_micros("way with waypoints", walk);
        print_micros("nearest with waypoints", nearest);
        println!(
            "  fields built in {build_ns:.1} ns a free cell and pile; {} KiB a pile, {} KiB in all",
            bytes_a_pile.div_ceil(1024),
            bytes.div_ceil(1024)
        );
        if let Some(DoorsReport { doors, narrow, close, slowest_close, open, rebuild }) = doors {
            print_micros(&format!("the middle of one of {doors} doors is blocked"), narrow);
            print_micros("one of them closes", close);
            print_micros("and opens again", open);
            println!("  the slowest door {slowest_close:.0} us; all fields built anew {rebuild:.0} us");
        }
    }
}

impl TickReport {
    fn print(&self) {
        println!("a tick of {0} robots and {0} piles on {1}", self.side, self.map);
        print_micros("matrix from fields", &self.matrix);
        print_micros("assignment", &self.assignment);
        print_micros("ways with waypoints", &self.paths);
        print_micros("all", &self.all);
        println!();
    }
}

fn print_micros(what: &str, Summary { mean, median, p99 }: &Summary) {
    println!("  {what:<38} mean {mean:>8.3}, median {median:>8.3}, p99 {p99:>8.3} us");
}

impl AssignmentReport {
    fn print(&self) {
        println!("assignment of {0} x {0} ({1} costs off)", self.side, self.off);
        let lines = [
            ("solved", self.solve),
            ("solved by lapjv 0.3.0", self.lapjv),
            ("one row changed", self.changed_row),
            ("one column changed", self.changed_column),
        ];
        lines.iter().for_each(|(what, micros)| print_micros(what, micros));
        println!();
    }
}

impl Figure {
    fn print(&self) {
        let Self { number, what, ours, asked, unit } = self;
        let verdict = if ours <= asked { "reached" } else { "not reached" };
        println!("figure {number}: {what}: {ours:.2} {unit}, asked {asked} {unit}: {verdict}");
    }
}

fn or_dash(value: Option<impl ToString>) -> String {
    value.map_or_else(|| "-".into(), |value| value.to_string())
}
