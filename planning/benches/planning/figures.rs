//! The figures to reach, beside ours.

use serde::Serialize;

use crate::report::Report;

/// One figure.
#[derive(Clone, Debug, Serialize)]
pub struct Figure {
    pub number: u8,
    pub what: String,
    pub ours: f64,
    pub asked: f64,
    pub unit: &'static str,
}

/// Mean microseconds a query at most: map, by jump point search, by index.
const QUERIES: [(&str, f64, f64); 5] = [
    ("office500", 50.0, 12.0),
    ("brc202d", 40.0, 12.0),
    ("arena2", 10.0, 5.0),
    ("maze512-4-0", 190.0, 20.0),
    ("random512-10-0", 500.0, 120.0),
];

/// All figures that this run has measured.
pub fn compare(report: &Report) -> Vec<Figure> {
    let mut figures = Vec::new();
    for (map, jps, indexed) in QUERIES {
        for (number, planner, asked) in [(2, "JPS", jps), (3, "indexed", indexed)] {
            if let Some(found) = report.planner(map, planner) {
                let what = format!("{map}, {planner}, mean");
                figures.push(Figure { number, what, ours: found.micros.mean, asked, unit: "us" });
            }
        }
    }
    for map in &report.maps {
        if let Some(found) = report.planner(&map.map, "indexed") {
            let what = format!("{}, index built", map.map);
            figures.push(Figure { number: 3, what, ours: found.index_seconds, asked: 1.0, unit: "s" });
        }
    }
    let known = |map: &str| report.maps.iter().find(|report| report.map == map).map(|report| &report.known);
    if let Some(known) = known("office500") {
        let mut add = |number, what: &str, ours, asked, unit| {
            figures.push(Figure { number, what: format!("office500, {what}"), ours, asked, unit });
        };
        add(1, "way with waypoints, mean", known.walk.mean, 0.6, "us");
        add(1, "way with waypoints, p99", known.walk.p99, 2.5, "us");
        add(1, "nearest with waypoints, mean", known.nearest.mean, 0.2, "us");
        add(1, "nearest with waypoints, p99", known.nearest.p99, 0.5, "us");
        add(5, "field build, a free cell and pile", known.build_ns, 12.0, "ns");
        if let Some(doors) = &known.doors {
            // A site's door is one cell; the gap it stands for may be wider, and closing all of it takes longer.
            add(5, "a door's cell is blocked, median", doors.narrow.median / 1e3, 0.15, "ms");
            add(5, "a door's cell is blocked, mean", doors.narrow.mean / 1e3, 1.5, "ms");
            add(5, "a whole door closes, median", doors.close.median / 1e3, 0.15, "ms");
            add(5, "a whole door closes, mean", doors.close.mean / 1e3, 1.5, "ms");
            add(5, "the slowest door, by full recompute", doors.slowest_close / doors.rebuild, 1.0, "times");
        }
        add(7, "memory of 13 piles", known.bytes as f64 / 1024.0 / 1024.0, 16.0, "MiB");
    }
    let mut assigned = |what: &str, ours, asked| {
        figures.push(Figure { number: 6, what: what.into(), ours, asked, unit: "us" });
    };
    if let Some(tick) = &report.tick {
        assigned("tick of 100 robots and 100 piles, mean", tick.all.mean, 200.0);
    }
    if let Some(assignment) = &report.assignment {
        assigned("assignment of 100 x 100, mean", assignment.solve.mean, 60.0);
        assigned("assignment, one row changed, mean", assignment.changed_row.mean, 5.0);
    }
    figures.sort_by_key(|figure| figure.number);
    figures
}
