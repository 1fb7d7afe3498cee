//! IGWO's figures: paths on the maps, and curves.

use planning::{grid::Cell, parking::CellSize, swarm::Algorithm};

use super::{
    Failed,
    matters::{FACTORS, FITNESS_1, FITNESS_2, ac2_steps, by_ac2, by_factor},
    places::{self, Place},
    planners::PLAIN_IGWO,
    sizes::LOTS,
    trials::{Trials, astar},
};
use crate::{
    reproduce::figure::{Content, Figure, Line, Mark, Series},
    site::SiteFrame,
};

/// Draws all: Figs. 4, 11 to 13, 15 and 16, and how the swarms of Tables VIII and IX converge.
///
/// # Errors
/// Only if one of the built-in maps is faulty.
pub fn figures() -> Result<Vec<Figure>, Failed> {
    let mut figures = Vec::new();
    for size in CellSize::ALL {
        for place in places::lots(size).take(LOTS) {
            figures.push(size_figure(&place)?);
        }
    }
    for place in places::test_maps() {
        let planners = [("GWO", Algorithm::Gwo), ("IGWO", PLAIN_IGWO)];
        let lines = planners
            .into_iter()
            .map(|(label, algorithm)| Ok(best_line(label, &Trials::run(&place, algorithm)?)));
        let lines: Result<Vec<_>, Failed> = lines.collect();
        figures.push(map(&place, format!("igwo-fig-11-{}", slug(&place)), "IGWO Fig. 11", lines?));
    }
    for place in places::parking_lots() {
        figures.extend(planners(&place)?);
    }
    figures.push(factors()?);
    for (number, fitness) in [(15, FITNESS_1), (16, FITNESS_2)] {
        let mut lines = Vec::new();
        for place in places::parking_lots() {
            let lengths = ac2_steps().zip(by_ac2(&place, fitness)?);
            let points = lengths.map(|(weights, [mean, _])| (weights.ac2(), mean)).collect();
            lines.push(Line { label: place.name, points });
        }
        figures.push(Figure {
            name: format!("igwo-fig-{number}"),
            title: format!("IGWO Fig. {number}: A*-IGWO with fitness {}", number - 14),
            content: Content::Curves { x: "AC2".into(), y: "mean length, m".into(), lines },
        });
    }
    Ok(figures)
}

/// Fig. 4: the best path of GWO on one lot in one cell size.
fn size_figure(place: &Place) -> Result<Figure, Failed> {
    let line = best_line("GWO", &Trials::run(place, Algorithm::Gwo)?);
    let centimetres = (100.0 * place.metres_per_cell).round();
    let name = format!("igwo-fig-4-{}-{centimetres}-cm", slug(place));
    Ok(map(place, name, &format!("IGWO Fig. 4, cells of {:.2} m", place.metres_per_cell), vec![line]))
}

/// All planners on one lot (Fig. 12 and Tables VIII and IX): their best paths, and how they converge.
fn planners(place: &Place) -> Result<[Figure; 2], Failed> {
    let planners = [
        ("GWO", Algorithm::Gwo),
        ("PSO", Algorithm::Pso),
        ("IGWO", Algorithm::IGWO),
        ("A*-IGWO", Algorithm::ASTAR_IGWO),
    ];
    let (mut paths, mut curves) = (vec![line("A*", &astar(place)?.0)], Vec::new());
    for (label, algorithm) in planners {
        let trials = Trials::run(place, algorithm)?;
        paths.push(best_line(label, &trials));
        let points = (1u32..).map(f64::from).zip(trials.curve).collect();
        curves.push(Line { label: label.into(), points });
    }
    let convergence = Figure {
        name: format!("igwo-convergence-{}", slug(place)),
        title: format!("IGWO Tables VIII and IX: convergence on {}, mean of 20 runs", place.name),
        content: Content::Curves {
            x: "iteration".into(),
            y: "best fitness so far / its last value".into(),
            lines: curves,
        },
    };
    let name = format!("igwo-fig-12-{}", slug(place));
    Ok([map(place, name, "IGWO Fig. 12 and Table IX", paths), convergence])
}

/// Fig. 13: the iterations with each convergence factor.
fn factors() -> Result<Figure, Failed> {
    let (mut groups, mut series) =
        (Vec::new(), FACTORS.map(|factor| Series { label: factor.into(), values: Vec::new() }));
    for place in places::parking_lots() {
        for (bars, trials) in series.iter_mut().zip(by_factor(&place)?) {
            bars.values.push(trials.mean_iterations());
        }
        groups.push(place.name);
    }
    Ok(Figure {
        name: "igwo-fig-13".into(),
        title: "IGWO Fig. 13: IGWO with four convergence factors".into(),
        content: Content::Bars { groups, y: "mean iterations".into(), series: series.into() },
    })
}

fn map(place: &Place, name: String, figure: &str, lines: Vec<Line>) -> Figure {
    let marks = vec![Mark::on("S", place.from), Mark::on("T", place.to)];
    let title = format!("{figure}: {}", place.name);
    Figure {
        name,
        title,
        content: Content::Map { grid: place.grid.clone(), frame: SiteFrame::default(), lines, marks },
    }
}

fn best_line(label: &str, trials: &Trials) -> Line {
    line(&format!("{label}, {:.1} m", trials.best_length_m()), &trials.best)
}

fn line(label: &str, turns: &[Cell]) -> Line {
    Line { label: label.into(), points: turns.iter().copied().map(point).collect() }
}

fn point(cell: Cell) -> (f64, f64) {
    (cell.x.into(), cell.y.into())
}

fn slug(place: &Place) -> String {
    place.name.replace(' ', "-")
}
