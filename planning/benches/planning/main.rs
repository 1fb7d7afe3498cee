//! `cargo xtask bench planning`: how long planning takes, beside other crates in the same run, and
//! whether every length is the optimal one.
//!
//! [`maps`] reads what is planned on, [`contestants`] are the planners, ours and others, [`queries`] runs
//! and times them, [`check`] runs all queries for their lengths only. [`known`] measures fields, [`doors`]
//! repairs them, [`mod@assignment`]
//! what its name says, [`tick`] both together. [`clock`] tells what things take.
//! [`figures`] are the numbers to reach, [`report`] prints.
//!
//! Nothing fails because it is slow: machines differ. A length that is not the optimal one fails.

mod assignment;
mod check;
mod clock;
mod contestants;
mod doors;
mod figures;
mod known;
mod maps;
mod progress;
mod queries;
mod report;
mod statistics;
mod tick;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;

use report::Report;

/// Measures planning.
#[derive(Parser)]
struct Arguments {
    /// A folder of maps (`.map`), each with its queries (`.map.scen` or `.scen`).
    #[arg(long, value_name = "DIR", default_value_os_t = maps::default_folder())]
    maps: PathBuf,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Only check every length of every planner; measure nothing.
    #[arg(long)]
    check: bool,
    /// What cargo adds for every benchmark.
    #[arg(long, hide = true)]
    bench: bool,
}

/// What went wrong, why, and what to do next.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct Failure(String);

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), Failure> {
    let maps = maps::read(&arguments.maps)?;
    if arguments.check {
        return check::all(&maps);
    }
    let mut report = Report::default();
    for map in &maps {
        report.maps.push(queries::measure(map));
    }
    report.tick = maps.iter().find(|map| map.name == "office500").map(tick::measure);
    report.assignment = Some(assignment::measure());
    report.figures = figures::compare(&report);
    report.print(arguments.json)?;
    let off: usize =
        report.maps.iter().flat_map(|map| &map.planners).filter_map(|planner| planner.off).sum::<usize>()
            + report.maps.iter().map(|map| map.known.off).sum::<usize>();
    if off > 0 {
        return Err(Failure(format!(
            "{off} lengths are not optimal: `--check` in place of `--json` names them"
        )));
    }
    Ok(())
}
