//! Tables I to IV, and what can be held against the paper's own numbers.

use planning::grid::Cell;

use super::{
    PAPER, drive,
    measure::{Medians, measure, medians},
    published::{
        Comparison, DELAY_S, INCREMENT_MPS, TABLE_I, TABLE_II, TABLE_III, TABLE_IV, TIME_SAVED_PERCENT,
    },
    uncompared,
};
use crate::{
    reproduce::{Failed, Row, Value},
    site::Site,
};

const UNKNOWN_MAP: &str = "the paper's map is lost; ours: median of 51 maps drawn to the text";
const ANOTHER_COMPUTER: &str = "printed in s with a delay for each node, on another computer; ours in us";
const FROM_PRINTED: &str = "ours: from the numbers that the same row prints";

/// The densities for the words of Table I, and the size, which it does not print.
const LEVELS: [(u32, u32); 4] = [(0, 1), (1, 10), (1, 5), (1, 3)];
const LEVELS_SIZE: (u32, u32) = (20, 20);

/// Table I: A* where more and more is in its way.
pub fn table_i() -> Result<Vec<Row>, Failed> {
    let mut rows = Vec::new();
    let mut ours = Vec::new();
    for ((name, nodes, seconds), density) in TABLE_I.into_iter().zip(LEVELS) {
        let [_, astar] = medians(LEVELS_SIZE, density)?.costs;
        ours.push(astar.nodes);
        let note = format!("{UNKNOWN_MAP}, 20 x 20 with {}/{} blocked", density.0, density.1);
        let number = Value::Number;
        rows.push(uncompared("I", name, "A*, nodes", number(nodes), number(astar.nodes), &note));
        rows.push(uncompared("I", name, "A*, time", number(seconds), number(astar.micros), ANOTHER_COMPUTER));
        rows.push(delay("I", name, "s a node", nodes, seconds));
    }
    let grow = |nodes: &[f64]| {
        let grow = nodes.windows(2).all(|pair| pair.first() < pair.last());
        Value::Text(if grow { "grow" } else { "do not always grow" }.into())
    };
    let printed = TABLE_I.map(|(_, nodes, _)| nodes);
    let said = Value::Text("grow".into());
    let row =
        PAPER.compared("I", "(a) to (d)", "nodes as obstacles grow, printed", said.clone(), grow(&printed));
    rows.push(row.noted("ours: what the printed nodes do; the text says that they grow"));
    rows.push(PAPER.compared("I", "(a) to (d)", "nodes as obstacles grow, ours", said, grow(&ours)));
    Ok(rows)
}

/// The delay for a node that the printed nodes and seconds give.
fn delay(table: &'static str, row: &str, column: &str, nodes: f64, seconds: f64) -> Row {
    let ours = Value::Number(seconds / nodes);
    let row = PAPER.compared(table, row, column, Value::printed(DELAY_S), ours);
    row.noted("the delay as the text says it; ours: printed seconds by printed nodes, which do not fit it")
}

/// Table II: maps of several sizes.
pub fn table_ii() -> Result<Vec<Row>, Failed> {
    let (mut rows, ours) = comparisons("II", &TABLE_II)?;
    let column = "node ratio from the first map to the last";
    let change =
        |first: f64, last: f64| Value::Text(if last < first { "falls" } else { "does not fall" }.into());
    rows.extend(claims("II", &ours));
    if let [first, .., last] = ours.as_slice() {
        let ours = change(first.node_ratio, last.node_ratio);
        rows.push(PAPER.compared("II", "10 x 10 to 40 x 30", column, Value::Text("falls".into()), ours));
    }
    Ok(rows)
}

/// What the text says of the improved A* against A*, and on how many of our maps it holds.
fn claims(table: &'static str, ours: &[Medians]) -> [Row; 3] {
    let claim = |column: &str, said: &str, holds: fn(&Medians) -> bool| {
        let (held, all) = (ours.iter().filter(|&ours| holds(ours)).count(), ours.len());
        let found = if held == all { said.into() } else { format!("{said} on {held} of {all}") };
        PAPER.compared(table, "all maps", column, Value::Text(said.into()), Value::Text(found))
    };
    [
        claim("I against II, nodes", "fewer", |ours| ours.node_ratio < 1.0)
            .noted("the tree not counted, as in the paper"),
        claim("I against II, nodes with the tree's", "fewer", |ours| {
            ours.costs[0].nodes + ours.tree < ours.costs[1].nodes
        })
        .noted("growing a node of the tree is work too"),
        claim("I against II, time", "faster", |ours| ours.time_ratio < 1.0)
            .noted("the tree's time counted; A* without the paper's delay for each node"),
    ]
}

/// Table III: densities of obstacles.
pub fn table_iii() -> Result<Vec<Row>, Failed> {
    let (mut rows, ours) = comparisons("III", &TABLE_III)?;
    rows.extend(claims("III", &ours));
    Ok(rows)
}

fn comparisons(table: &'static str, printed: &[Comparison]) -> Result<(Vec<Row>, Vec<Medians>), Failed> {
    let (mut rows, mut all) = (Vec::new(), Vec::new());
    for printed in printed {
        let ours = medians(printed.size, printed.density)?;
        rows.extend(comparison(table, printed, &ours));
        all.push(ours);
    }
    Ok((rows, all))
}

fn comparison(table: &'static str, printed: &Comparison, ours: &Medians) -> Vec<Row> {
    let Comparison { map, seconds, nodes, lengths, ratios: [time_ratio, node_ratio], .. } = *printed;
    let [improved, astar] = ours.costs;
    let row = |column: &str, published: Value, ours: f64, note: &str| {
        uncompared(table, map, column, published, Value::Number(ours), note)
    };
    let number = Value::Number;
    let length_ratio = lengths[0] / lengths[1];
    let mut rows = vec![
        row("I, nodes", number(nodes[0]), improved.nodes, UNKNOWN_MAP),
        row("I, nodes of the tree", Value::Missing, ours.tree, "the paper does not count them"),
        row("II, nodes", number(nodes[1]), astar.nodes, UNKNOWN_MAP),
        row("I / II, nodes", Value::printed(node_ratio), ours.node_ratio, UNKNOWN_MAP),
        row("I, time", number(seconds[0]), improved.micros, ANOTHER_COMPUTER),
        row("II, time", number(seconds[1]), astar.micros, ANOTHER_COMPUTER),
        row("I / II, time", Value::printed(time_ratio), ours.time_ratio, UNKNOWN_MAP),
        row("I, length", number(lengths[0]), improved.length, "printed in an unknown unit; ours in cells"),
        row("II, length", number(lengths[1]), astar.length, "printed in an unknown unit; ours in cells"),
        row("I / II, length", number(length_ratio), ours.length_ratio, UNKNOWN_MAP),
    ];
    for (column, printed, [one, other]) in
        [("I / II, printed nodes", node_ratio, nodes), ("I / II, printed time", time_ratio, seconds)]
    {
        let ours = Value::Number(one / other);
        rows.push(PAPER.compared(table, map, column, Value::printed(printed), ours).noted(FROM_PRINTED));
    }
    rows
}

/// Ways on LMPP's map that stand in for Table IV's building, in that paper's coordinates: a short one and
/// one of about three and a half times its length.
const WAYS: [[[i32; 2]; 2]; 2] = [[[92, 13], [92, 43]], [[10, 64], [97, 96]]];

/// Table IV: a real robot's paths.
pub fn table_iv() -> Result<Vec<Row>, Failed> {
    let site = Site::fig7()?;
    let mut rows = Vec::new();
    let mut saved = Vec::new();
    for ((name, lengths, millis), [from, to]) in TABLE_IV.into_iter().zip(WAYS) {
        let cell = |[x, y]: [i32; 2]| -> Result<Cell, Failed> { Ok(site.cell_at(x, y)?) };
        let ([improved, astar], tree) = measure(&site.grid, cell(from)?, cell(to)?, 0)?;
        let note = "the building's map is lost; ours: a way on the map of LMPP's Fig. 7, in cells and us";
        for (column, published, ours) in [
            ("I, length", lengths[0], improved.length),
            ("II, length", lengths[1], astar.length),
            ("I, time", millis[0], improved.micros),
            ("II, time", millis[1], astar.micros),
            ("I / II, time", millis[0] / millis[1], improved.micros / astar.micros),
        ] {
            rows.push(uncompared("IV", name, column, Value::Number(published), Value::Number(ours), note));
        }
        let ours = Value::Number(improved.length / astar.length);
        let published = Value::Number(lengths[0] / lengths[1]);
        let note = "no path is shorter than the shortest: printed below 1, it was not A*'s on the same cells";
        rows.push(uncompared("IV", name, "I / II, length", published, ours, note));
        for (column, ours) in
            [("I, nodes", improved.nodes), ("I, nodes of the tree", tree as f64), ("II, nodes", astar.nodes)]
        {
            rows.push(uncompared("IV", name, column, Value::Missing, Value::Number(ours), "not printed"));
        }
        saved.push((1.0 - millis[0] / millis[1], 1.0 - improved.micros / astar.micros));
    }
    let percent = |sum: f64| Value::Number(100.0 * sum / saved.len() as f64);
    let published = Value::printed(TIME_SAVED_PERCENT);
    let printed = percent(saved.iter().map(|&(printed, _)| printed).sum());
    let row = PAPER.compared("IV", "mean of both", "time saved, printed, %", published.clone(), printed);
    rows.push(row.noted("the abstract's figure; ours: from the times that the table prints"));
    let ours = percent(saved.iter().map(|&(_, ours)| ours).sum());
    rows.push(uncompared(
        "IV",
        "mean of both",
        "time saved, ours, %",
        published,
        ours,
        "another map and computer",
    ));
    Ok(rows)
}

/// III.C.2: the increment of a wheel's speed, held against a drive.
pub fn smoothing() -> Result<Vec<Row>, Failed> {
    let drive = drive::drive()?;
    let row = PAPER.compared(
        "III.C.2",
        "a drive by the dynamic window approach",
        "largest change of a wheel's speed a tick, m/s",
        Value::printed(INCREMENT_MPS),
        Value::Number(drive.largest_change_mps()),
    );
    let number = |column, ours, note| {
        uncompared(
            "III.C.2",
            "a drive by the dynamic window approach",
            column,
            Value::Missing,
            Value::Number(ours),
            note,
        )
    };
    Ok(vec![
        row,
        number("least clearance, m", drive.least_clearance_m, "the robot's radius is 0.18 m"),
        number("seconds", drive.seconds(), "on the map of Fig. 12's kind, cells of 0.5 m"),
        number("length of the route, m", drive.route_m, "by the improved A*"),
    ])
}
