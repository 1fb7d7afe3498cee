//! Fig. 3: GWO on the lot in three cell sizes, with three sets of cars.

use planning::{parking::CellSize, swarm::Algorithm};

use super::{
    Failed, LOST, LOST_WITHOUT_RATIO, PAPER, less, number, percent, places,
    published::{FINER, FINEST, FINEST_LENGTH_PERCENT},
    trials::{Trials, mean},
};
use crate::reproduce::{Row, Value};

/// Fig. 3 takes three sets of cars.
pub const LOTS: usize = 3;

/// Mean iterations and metres of GWO over three lots.
fn measure(size: CellSize) -> Result<[f64; 2], Failed> {
    let trials: Result<Vec<_>, _> =
        places::lots(size).take(LOTS).map(|lot| Trials::run(&lot, Algorithm::Gwo)).collect();
    let trials = trials?;
    let mean_of = |value: fn(&Trials) -> f64| mean(&trials.iter().map(value).collect::<Vec<_>>());
    Ok([mean_of(Trials::mean_iterations), mean_of(Trials::mean_length_m)])
}

/// What the text says of Fig. 3.
pub fn figure_3() -> Result<Vec<Row>, Failed> {
    let [coarse, middle, fine] = CellSize::ALL;
    let [coarse, middle, fine] = [measure(coarse)?, measure(middle)?, measure(fine)?];
    let (finer, finest) = ("2.60 m to 1.30 m", "1.30 m to 0.65 m");
    let row = |row, column, published, ours: f64, note| {
        number("Fig. 3", row, column, published, ours).uncompared(note)
    };
    let [more, shorter_percent, shorter_m] = FINER;
    let [most, most_percent] = FINEST;
    let last_percent = percent(middle[1], fine[1]);
    // Both "shorter by less than" and "not shorter at all" are no gain.
    let under = format!("under {FINEST_LENGTH_PERCENT} %");
    let ours =
        if -last_percent < FINEST_LENGTH_PERCENT { under.clone() } else { format!("{:.1} %", -last_percent) };
    Ok(vec![
        row(finer, "iterations", more, middle[0] - coarse[0], LOST_WITHOUT_RATIO),
        number("Fig. 3", finer, "length, %", shorter_percent, percent(coarse[1], middle[1]))
            .noted(&format!("{:.2} m against {:.2} m", middle[1], coarse[1])),
        row(finer, "length, m", shorter_m, middle[1] - coarse[1], LOST),
        less("Fig. 3", finer, "length", middle[1], coarse[1]),
        row(finest, "iterations", most, fine[0] - middle[0], LOST),
        number("Fig. 3", finest, "iterations, %", most_percent, percent(middle[0], fine[0]))
            .noted(&format!("{:.2} against {:.2}", fine[0], middle[0])),
        PAPER
            .compared("Fig. 3", finest, "length", Value::Text(under), Value::Text(ours))
            .noted(&format!("{:.2} m against {:.2} m", middle[1], fine[1])),
    ])
}
