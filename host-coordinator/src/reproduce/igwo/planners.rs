//! Tables I to V and VIII to X: one planner against another.

use planning::swarm::{Algorithm, Convergence, Fitness, Settings};

use super::{
    Failed, LOST, LOST_WITHOUT_RATIO, PAPER, less, number, percent,
    places::{self, Place},
    published::{Changes, PARAMETERS, TABLE_VIII},
    trials::{self, PARTICLES, RUNS, Trials, mean},
};
use crate::reproduce::{Row, Value};

/// IGWO before it has its own convergence factor (4.1.1).
pub const PLAIN_IGWO: Algorithm =
    Algorithm::Igwo { convergence: Convergence::Linear, fitness: Fitness::Length };

/// Table I, as far as the text says it again: what went in.
pub fn table_1() -> Vec<Row> {
    let Settings { population, iterations, .. } = Settings::default();
    let ours = [RUNS as f64, population.get().into(), iterations.get().into(), PARTICLES.into()];
    let row = |((name, published), ours)| number("I", name, "value", published, ours).uncompared("an input");
    PARAMETERS.into_iter().zip(ours).map(row).collect()
}

type Measure = fn(&Trials) -> f64;
/// What is printed of a column: in per cent, and in its unit.
type Printed = [Option<&'static str>; 2];

/// Tables II and IV: iterations of GWO and IGWO. Which of two tables has which, the text does not say.
pub fn iterations(
    table: &'static str,
    places: impl Iterator<Item = Place>,
    printed: &[Changes],
) -> Result<Vec<Row>, Failed> {
    gwo_and_igwo(table, "iterations", "iterations", places.zip(printed), |changes| {
        [
            (changes.mean_iterations, Trials::mean_iterations),
            (changes.best_iterations, Trials::best_iterations),
        ]
    })
}

/// Tables III and V: lengths of GWO and IGWO.
pub fn lengths(
    table: &'static str,
    places: impl Iterator<Item = Place>,
    printed: &[Changes],
) -> Result<Vec<Row>, Failed> {
    gwo_and_igwo(table, "length", "m", places.zip(printed), |changes| {
        [(changes.mean_length, Trials::mean_length_m), (changes.best_length, Trials::best_length_m)]
    })
}

fn gwo_and_igwo<'a>(
    table: &'static str,
    what: &str,
    unit: &str,
    places: impl Iterator<Item = (Place, &'a Changes)>,
    columns: fn(&Changes) -> [(Printed, Measure); 2],
) -> Result<Vec<Row>, Failed> {
    let mut rows = Vec::new();
    for (place, changes) in places {
        let (before, after) = (Trials::run(&place, Algorithm::Gwo)?, Trials::run(&place, PLAIN_IGWO)?);
        for (kind, ([ratio, amount], measure)) in ["mean", "best"].into_iter().zip(columns(changes)) {
            let (before, after) = (measure(&before), measure(&after));
            let values = format!("GWO {before:.2}, IGWO {after:.2}");
            let row = |unit: &str, printed: &str, ours: f64| {
                number(table, &place.name, &format!("{kind} {what}, {unit}"), printed, ours)
            };
            rows.extend(ratio.map(|printed| row("%", printed, percent(before, after)).noted(&values)));
            let note = if ratio.is_some() { LOST } else { LOST_WITHOUT_RATIO };
            rows.extend(
                amount.map(|printed| row(unit, printed, after - before).uncompared(note).noted(&values)),
            );
        }
    }
    Ok(rows)
}

/// Table VIII: A\*-IGWO against GWO over all lots.
pub fn table_8() -> Result<Vec<Row>, Failed> {
    let (mut gwo, mut ours) = (Vec::new(), Vec::new());
    for place in places::parking_lots() {
        gwo.push(Trials::run(&place, Algorithm::Gwo)?);
        ours.push(Trials::run(&place, Algorithm::ASTAR_IGWO)?);
    }
    let columns: [(_, Measure); 2] =
        [("mean iterations, %", Trials::mean_iterations), ("mean length, %", Trials::mean_length_m)];
    let row = |((column, measure), published): ((&str, Measure), &str)| {
        let over_lots = |runs: &[Trials]| mean(&runs.iter().map(measure).collect::<Vec<_>>());
        let (gwo, ours) = (over_lots(&gwo), over_lots(&ours));
        let row = number("VIII", "all lots", column, published, percent(gwo, ours));
        row.noted(&format!("GWO {gwo:.2}, A*-IGWO {ours:.2}"))
    };
    Ok(columns.into_iter().zip(TABLE_VIII).map(row).collect())
}

/// Table IX: A\*-IGWO against PSO and A\* on each lot.
pub fn table_9() -> Result<Vec<Row>, Failed> {
    let mut rows = Vec::new();
    for place in places::parking_lots() {
        let name = &place.name;
        let (ours, pso) = (Trials::run(&place, Algorithm::ASTAR_IGWO)?, Trials::run(&place, Algorithm::Pso)?);
        let (_, astar_m) = trials::astar(&place)?;
        rows.push(less("IX", name, "mean iterations, PSO", ours.mean_iterations(), pso.mean_iterations()));
        rows.push(less("IX", name, "mean length, PSO, m", ours.mean_length_m(), pso.mean_length_m()));
        rows.push(less("IX", name, "mean length, A*, m", ours.mean_length_m(), astar_m));
    }
    Ok(rows)
}

/// Table X: A\*-IGWO against two planners of other papers.
pub fn table_10() -> Vec<Row> {
    let row = |column| {
        let row = PAPER.compared("X", "all lots", column, Value::Text("less".into()), Value::Missing);
        row.uncompared("another paper's planner, which is not built here")
    };
    ["HSGWO", "IGWO of Su and Yourui"].map(row).into()
}
