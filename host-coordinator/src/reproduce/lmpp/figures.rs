//! What Tests 1 to 5 draw: Figs. 8 to 12, and Table 7 as a curve.

use std::collections::BTreeMap;

use planning::{
    grid::Cell,
    lmpp::{Lmpp, Route},
    path::Path,
    search::{AStar, Planner},
};
use protocol::PileId;

use super::{
    Failed, Laboratory, at, choices, lengths,
    published::{
        TABLE_4, TABLE_7, TABLE_8, TABLE_9, TABLE_10, TABLE_11, TEST_3_CHOICES, TEST_3_START, TEST_4_REACHES,
    },
    times,
};
use crate::{
    reproduce::figure::{Content, Figure, Line, Mark, Series},
    selection::Rule,
};

pub(super) fn all(laboratory: &mut Laboratory) -> Result<Vec<Figure>, Failed> {
    let mut figures = vec![fig_8(laboratory)?, fig_9(laboratory)?, test_2(laboratory)?];
    for (reach, _) in TEST_3_CHOICES {
        figures.push(fig_10(laboratory, reach)?);
    }
    for reach in TEST_4_REACHES {
        figures.push(fig_11(laboratory, reach)?);
    }
    figures.push(fig_12(laboratory)?);
    Ok(figures)
}

/// Test 1: planning times.
fn fig_8(laboratory: &mut Laboratory) -> Result<Figure, Failed> {
    let mut times = Vec::new();
    for location in TABLE_4 {
        times.push(times::micros(laboratory, laboratory.cell(location)?)?);
    }
    let line = |label: &str, of: fn(&[f64; 2]) -> f64| Line {
        label: label.into(),
        points: (1..).zip(&times).map(|(number, pair)| (f64::from(number), of(pair).log10())).collect(),
    };
    Ok(Figure {
        name: "lmpp-fig-8".into(),
        title: "LMPP, Test 1 (Fig. 8): planning time to every pile that doors lead to".into(),
        content: Content::Curves {
            x: "location".into(),
            y: "log10 of the time in microseconds".into(),
            lines: vec![line("A*", |[_, astar]| *astar), line("LMPP", |[lmpp, _]| *lmpp)],
        },
    })
}

/// Test 1: to the nearest pile by A\* and by LMPP.
fn fig_9(laboratory: &mut Laboratory) -> Result<Figure, Failed> {
    let mut lines = Vec::new();
    for location in TABLE_4 {
        let from = laboratory.cell(location)?;
        if let Some(path) = nearest_by_astar(laboratory, from) {
            lines.push(Line::of_path("A*", &path));
        }
    }
    for location in TABLE_4 {
        let from = laboratory.cell(location)?;
        lines.extend(nearest(&laboratory.as_drawn, from)?.map(|route| Line::of_path("LMPP", &route.path)));
    }
    map(laboratory, "lmpp-fig-9", "LMPP, Test 1 (Fig. 9): to the nearest pile", lines, &TABLE_4)
}

fn nearest_by_astar(laboratory: &mut Laboratory, from: Cell) -> Option<Path> {
    let Laboratory { site, workspace, .. } = laboratory;
    let search = AStar::new(&site.grid, site.moves);
    let paths = site
        .piles
        .iter()
        .filter_map(|pile| search.plan(from, pile.cell, workspace).ok().map(|plan| plan.path.clone()));
    paths.min_by_key(Path::length)
}

fn nearest(lmpp: &Lmpp, from: Cell) -> Result<Option<Route>, Failed> {
    let survey = lmpp.survey(from)?;
    Ok(survey.nearest().and_then(|(pile, _)| survey.route_to(pile)))
}

/// Test 2: how many piles each threshold lets be searched.
fn test_2(laboratory: &mut Laboratory) -> Result<Figure, Failed> {
    let mut counts = Vec::new();
    for (threshold, ..) in TABLE_7 {
        counts.push(choices::searched(laboratory, threshold)?);
    }
    let series = |label: &str, values: Vec<f64>| Series { label: label.into(), values };
    Ok(Figure {
        name: "lmpp-test-2".into(),
        title: "LMPP, Test 2 (Table 7): piles that are searched".into(),
        content: Content::Bars {
            groups: TABLE_7.iter().map(|(threshold, ..)| format!("q_th {threshold}")).collect(),
            y: "piles".into(),
            series: vec![
                series("Q1", counts.iter().map(|[idle, _]| *idle).collect()),
                series("Q1 + Q2", counts.iter().map(|[idle, busy]| idle + busy).collect()),
            ],
        },
    })
}

/// Test 3: one location, six conditions; eq. 9 as printed.
fn fig_10(laboratory: &mut Laboratory, reach: u32) -> Result<Figure, Failed> {
    let mut conditions: BTreeMap<PileId, Vec<String>> = BTreeMap::new();
    for (condition, p) in (1..).zip(&TABLE_8) {
        if let Some(pile) = choices::chosen(laboratory, TEST_3_START, p, reach, Rule::PaperLiteral)? {
            conditions.entry(pile).or_default().push(format!("({condition})"));
        }
    }
    let mut lines = Vec::new();
    for (pile, conditions) in conditions {
        let label = |pile: &str| format!("{pile} in {}", conditions.join(", "));
        lines.extend(line(laboratory, TEST_3_START, Some(pile), label)?);
    }
    let title = format!("LMPP, Test 3 (Fig. 10): six conditions, reach {reach}");
    map(laboratory, &format!("lmpp-fig-10-reach-{reach}"), &title, lines, &[TEST_3_START])
}

/// Test 4: six locations, one set of probabilities; only piles in reach.
fn fig_11(laboratory: &mut Laboratory, reach: u32) -> Result<Figure, Failed> {
    let starts = TABLE_10.map(|(location, _)| location);
    let mut lines = Vec::new();
    for start in starts {
        let chosen = choices::chosen(laboratory, start, &TABLE_9, reach, Rule::Corrected)?;
        lines.extend(line(laboratory, start, chosen, |pile| format!("{} to {pile}", at(start)))?);
    }
    let title = format!("LMPP, Test 4 (Fig. 11): six locations, reach {reach}");
    map(laboratory, &format!("lmpp-fig-11-reach-{reach}"), &title, lines, &starts)
}

/// Test 5: to the nearest pile, without and with avoidance of congested doors.
fn fig_12(laboratory: &mut Laboratory) -> Result<Figure, Failed> {
    let routes = lengths::test_5(laboratory)?;
    let labelled = |number: usize, label: &str| -> Vec<Line> {
        let routes = routes.iter().filter_map(|routes| routes.get(number)?.as_ref());
        routes.map(|route| Line::of_path(label, &route.path)).collect()
    };
    let lines = [labelled(0, "theta >= 1"), labelled(1, "0 < theta < 1")].concat();
    map(laboratory, "lmpp-fig-12", "LMPP, Test 5 (Fig. 12): avoiding congested doors", lines, &TABLE_11)
}

/// The way from a location to a pile, with the doors of Tests 3 and 4.
fn line(
    laboratory: &Laboratory,
    location: [i32; 2],
    chosen: Option<PileId>,
    label: impl Fn(&str) -> String,
) -> Result<Option<Line>, Failed> {
    let survey = laboratory.as_run.survey(laboratory.cell(location)?)?;
    let route = chosen.and_then(|pile| Some((pile, survey.route_to(pile.0)?)));
    Ok(route.map(|(pile, route)| Line::of_path(label(&format!("s{pile}")), &route.path)))
}

/// Paths on the map with its piles, its doors and the locations where robots ask.
fn map(
    laboratory: &Laboratory,
    name: &str,
    title: &str,
    lines: Vec<Line>,
    locations: &[[i32; 2]],
) -> Result<Figure, Failed> {
    let site = &laboratory.site;
    let piles = site.piles.iter().map(|pile| Mark::on(format!("s{}", pile.id), pile.cell));
    let doors = site.rooms.doors().iter().map(|door| Mark::on(format!("D{}", door.id.0), door.cell));
    let mut marks: Vec<_> = doors.chain(piles).collect();
    for (number, &location) in (1..).zip(locations) {
        marks.push(Mark::on(format!("({number})"), laboratory.cell(location)?));
    }
    let (grid, frame) = (site.grid.clone(), site.frame);
    Ok(Figure { name: name.into(), title: title.into(), content: Content::Map { grid, frame, lines, marks } })
}
