//! What a pile has answered, for a person.

use host_coordinator::{
    core::view::fault_name,
    desk::{
        answers::Answers,
        words::{self, measured},
    },
};
use protocol::{FaultState, PendingPass, PileId, PileParameters, PileReadings, PileRow, PileState, limits};

use crate::cli::table::table;

const RED: &str = "\x1b[1;31m";
const YELLOW: &str = "\x1b[33m";
const GREEN: &str = "\x1b[32m";
const BOLD: &str = "\x1b[1m";
const RESET: &str = "\x1b[0m";

/// All answers. `command` is how the pile was asked, up to what was asked.
pub fn answers(answers: &Answers, command: &str) -> String {
    let pile = answers.pile.unwrap_or_default();
    let mut blocks = Vec::new();
    if let Some(code) = answers.cleared {
        blocks.push(format!("{GREEN}pile {pile} has cleared {}{RESET}", fault_name(code)));
    }
    let mut rows = Vec::new();
    rows.extend(answers.state.iter().flat_map(|state| state_rows(pile, state)));
    rows.extend(answers.readings.iter().flat_map(reading_rows));
    rows.extend(answers.parameters.iter().flat_map(parameter_rows));
    blocks.extend((!rows.is_empty()).then(|| lines(&rows)));
    blocks.extend(answers.faults.as_deref().map(|found| faults(pile, found, command)));
    blocks.extend(answers.passes.as_deref().map(|found| passes(pile, found)));
    blocks.extend(answers.table.as_deref().map(rows_of_all));
    blocks.join("\n\n")
}

/// One line for what it does and measures now.
pub fn watch(answers: &Answers) -> String {
    let line = words::status_line(answers);
    if answers.faults.as_ref().is_some_and(|faults| !faults.is_empty()) {
        format!("{RED}{line}{RESET}")
    } else {
        line
    }
}

type Row = (&'static str, String);

fn lines(rows: &[Row]) -> String {
    let line = |(name, value): &Row| format!("{name:<16}{value}");
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}

fn state_rows(pile: PileId, state: &PileState) -> Vec<Row> {
    let colour = match state.row.availability {
        protocol::Availability::Fault => RED,
        _ => BOLD,
    };
    let mut rows = vec![
        ("pile", format!("{pile}, {colour}{}{RESET}", words::availability(state.row.availability))),
        ("contacts", if state.energised { format!("{YELLOW}live{RESET}") } else { "dead".into() }),
        ("lease", state.holder.map_or_else(|| "none".into(), words::lease)),
    ];
    let progress = words::progress(state);
    rows.extend((!progress.is_empty()).then_some(("charge", progress)));
    rows.extend(state.ended.map(|ended| {
        let charged = ended.charged.as_seconds();
        let why = words::end(ended.reason);
        ("last lease", format!("{} is over: {why}, after {charged:.0} s live", words::lease(ended.lease)))
    }));
    rows
}

fn reading_rows(readings: &PileReadings) -> Vec<Row> {
    let or = |is: bool, yes: &str, no: &str| if is { yes.to_owned() } else { no.to_owned() };
    vec![
        ("contactor", or(readings.contactor_closed, "found closed", "found open")),
        ("voltage", measured(readings.voltage.map(|value| value.get()), 2, "V")),
        (
            "current",
            format!(
                "{} of {:.2} A allowed now",
                measured(readings.current.map(|value| value.get()), 2, "A"),
                readings.current_limit.get()
            ),
        ),
        ("temperature", measured(readings.temperature.map(|value| value.get()), 1, "°C")),
        ("robot", or(readings.mated, "its contacts touch", "no contacts touch")),
        ("emergency stop", or(readings.emergency_stop, &format!("{RED}pressed{RESET}"), "not pressed")),
        ("mains", or(readings.mains, "there", &format!("{RED}lost{RESET}"))),
    ]
}

fn parameter_rows(parameters: &PileParameters) -> Vec<Row> {
    vec![
        (
            "charges with",
            format!(
                "{:.0} W, at most {:.1} V and {:.1} A; {:.0} s are added to every plan",
                parameters.power.get(),
                parameters.voltage_max.get(),
                parameters.current_max.get(),
                parameters.eta.as_seconds(),
            ),
        ),
        (
            "heat",
            format!(
                "less current from {:.0} °C on, none at {:.0} °C",
                parameters.derate_from.get(),
                parameters.stop_at.get()
            ),
        ),
        (
            "docked",
            format!(
                "from {} dBm on, until below {} dBm",
                parameters.dock_enter_dbm, parameters.dock_leave_dbm
            ),
        ),
    ]
}

fn faults(pile: PileId, faults: &[FaultState], command: &str) -> String {
    if faults.is_empty() {
        return format!("{GREEN}nothing is wrong with pile {pile}{RESET}");
    }
    let fault = |fault: &FaultState| {
        let name = fault_name(fault.code);
        let words::Fault { meaning, look_at } = words::fault(fault.code);
        let colour = if fault.active { RED } else { YELLOW };
        let mut lines = vec![
            format!("{colour}{name}{RESET}: {meaning} ({})", words::course(fault)),
            format!("  look at: {look_at}"),
        ];
        if fault.latched {
            lines.push(format!("  then:    {command} clear-fault {name}"));
        }
        lines.join("\n")
    };
    faults.iter().map(fault).collect::<Vec<_>>().join("\n")
}

fn period(period: Option<u16>) -> String {
    period.map_or_else(|| "unknown".into(), |period| period.to_string())
}

fn passes(pile: PileId, passes: &[PendingPass]) -> String {
    if passes.is_empty() {
        return format!("pile {pile} has no passes that wait to be handed on");
    }
    let rows: Vec<_> = passes
        .iter()
        .map(|count| [count.tag.to_string(), period(count.period), count.passes.to_string()])
        .collect();
    let all = table(["tag", "period of the day", "passes"], &[1, 2], &rows);
    if passes.len() < limits::PASSES_PER_REPORT {
        return all;
    }
    format!("{all}\nThese are the first {}; there may be more.", passes.len())
}

fn rows_of_all(rows: &[PileRow]) -> String {
    let rows: Vec<_> = rows
        .iter()
        .map(|row| {
            let share = |planned: bool| {
                if planned { format!("{:.0} %", row.remaining.get() * 100.0) } else { "-".into() }
            };
            [
                row.pile.to_string(),
                words::availability(row.availability).to_owned(),
                share(row.planned.0 > 0),
                format!("{:.0} s", row.planned.as_seconds()),
                row.stamp.map_or_else(|| "-".into(), |stamp| stamp.to_string()),
                format!("{}.{}", row.boot, row.version),
            ]
        })
        .collect();
    table(["pile", "place", "to go", "planned", "said at (ms)", "start.version"], &[0, 2, 3, 4, 5], &rows)
}
