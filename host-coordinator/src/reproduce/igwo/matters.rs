//! Tables VI and VII and Figs. 13 to 17: what convergence factor, fitness and weights matter.

use planning::swarm::{Algorithm, Convergence, Fitness, Weights};

use super::{
    Failed, PAPER, less, places,
    places::Place,
    published::BEST_FACTOR,
    trials::{Trials, mean},
};
use crate::reproduce::{Row, Value};

/// A\*-IGWO with a fitness and the factor that the paper finds best.
const fn with(fitness: Fitness) -> Algorithm {
    Algorithm::Igwo { convergence: Convergence::Earliest, fitness }
}

/// A fitness by its weights.
pub type ByWeights = fn(Weights) -> Fitness;
/// Fitness 1, eq. 15.
pub const FITNESS_1: ByWeights = Fitness::Goal;
/// Fitness 2, eq. 16.
pub const FITNESS_2: ByWeights = Fitness::StartAndGoal;

/// The values that Figs. 15 and 16 try for AC2: 0.1 to 0.9.
pub fn ac2_steps() -> impl Iterator<Item = Weights> {
    (1..=9).filter_map(|tenths| Weights::with_ac2(f64::from(tenths) / 10.0))
}

/// The runs in one lot for each convergence factor (Tables VI and VII, Fig. 13).
pub fn by_factor(place: &Place) -> Result<[Trials; 4], Failed> {
    let mut trials = <[Trials; 4]>::default();
    for (trials, convergence) in trials.iter_mut().zip(Convergence::ALL) {
        *trials = Trials::run(place, Algorithm::Igwo { convergence, fitness: Fitness::Length })?;
    }
    Ok(trials)
}

/// The mean and best metres over AC2 in one lot (Figs. 15 and 16).
pub fn by_ac2(place: &Place, fitness: ByWeights) -> Result<Vec<[f64; 2]>, Failed> {
    let lengths = ac2_steps().map(|weights| {
        let trials = Trials::run(place, with(fitness(weights)))?;
        Ok([trials.mean_length_m(), trials.best_length_m()])
    });
    lengths.collect()
}

/// Table VI: the factor with the fewest iterations on each lot.
pub fn table_6() -> Result<Vec<Row>, Failed> {
    let row = |lot: Place| {
        let iterations = by_factor(&lot)?.map(|trials| trials.mean_iterations());
        let best = FACTORS.into_iter().zip(iterations).min_by(|one, other| one.1.total_cmp(&other.1));
        let ours = best.map_or(Value::Missing, |(name, _)| Value::Text(name.into()));
        let row =
            PAPER.compared("VI", &lot.name, "fewest mean iterations", Value::Text(BEST_FACTOR.into()), ours);
        Ok(row.noted(&format!(
            "{}; rebuilt, a4 as the soonest because the paper finds it best",
            each(&iterations, "")
        )))
    };
    places::parking_lots().map(row).collect()
}

/// Table VII: the lengths with each factor.
pub fn table_7() -> Result<Vec<Row>, Failed> {
    let row = |lot: Place| {
        let lengths = by_factor(&lot)?.map(|trials| trials.mean_length_m());
        let [.., ours] = lengths;
        let row = PAPER.compared("VII", &lot.name, "mean length, a4, m", Value::Missing, Value::Number(ours));
        Ok(row.uncompared(format!("the text prints none; {}", each(&lengths, " m"))))
    };
    places::parking_lots().map(row).collect()
}

/// The names of the factors in the paper.
pub const FACTORS: [&str; 4] = ["a1", "a2", "a3", "a4"];

fn each(values: &[f64; 4], unit: &str) -> String {
    FACTORS
        .iter()
        .zip(values)
        .map(|(name, value)| format!("{name} {value:.2}{unit}"))
        .collect::<Vec<_>>()
        .join(", ")
}

/// Fig. 14: A\*-IGWO with fitness 1 against IGWO.
pub fn figure_14() -> Result<Vec<Row>, Failed> {
    against("Fig. 14", "IGWO", with(FITNESS_1(Weights::HALF)), Algorithm::IGWO)
}

/// Fig. 17: A\*-IGWO with fitness 2 against fitness 1.
pub fn figure_17() -> Result<Vec<Row>, Failed> {
    against("Fig. 17", "fitness 1", Algorithm::ASTAR_IGWO, with(FITNESS_1(Weights::HALF)))
}

/// Whether one planner is better than another in three ways on each lot.
fn against(figure: &'static str, other: &str, one: Algorithm, than: Algorithm) -> Result<Vec<Row>, Failed> {
    let mut rows = Vec::new();
    for lot in places::parking_lots() {
        let (ours, theirs) = (Trials::run(&lot, one)?, Trials::run(&lot, than)?);
        let mut row = |what: &str, measure: fn(&Trials) -> f64| {
            let column = format!("{what} than {other}");
            rows.push(less(figure, &lot.name, &column, measure(&ours), measure(&theirs)));
        };
        row("mean iterations", Trials::mean_iterations);
        row("mean length, m,", Trials::mean_length_m);
        row("best length, m,", Trials::best_length_m);
    }
    Ok(rows)
}

/// Figs. 15 and 16: the AC2 with the shortest paths over all lots.
pub fn weights(figure: &'static str, fitness: ByWeights, published: &str) -> Result<Vec<Row>, Failed> {
    let lengths: Result<Vec<_>, _> = places::parking_lots().map(|lot| by_ac2(&lot, fitness)).collect();
    let lengths = lengths?;
    let row = |(which, column)| {
        let over_lots = |step: usize| {
            let of_step = lengths.iter().filter_map(|lot| lot.get(step)?.get(which).copied());
            mean(&of_step.collect::<Vec<_>>())
        };
        let means = ac2_steps().enumerate().map(|(step, weights)| (weights.ac2(), over_lots(step)));
        let means: Vec<_> = means.collect();
        let best = means.iter().min_by(|one, other| one.1.total_cmp(&other.1));
        let ours = Value::number(best.map(|&(ac2, _)| ac2));
        let row = PAPER.compared(figure, "all lots", column, Value::printed(published), ours);
        let list: Vec<_> = means.iter().map(|(ac2, length)| format!("{ac2} {length:.2} m")).collect();
        row.noted(&list.join(", "))
    };
    Ok([(0, "AC2 of the shortest mean"), (1, "AC2 of the shortest best")].into_iter().map(row).collect())
}
