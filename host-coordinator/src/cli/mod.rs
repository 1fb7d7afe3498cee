//! The command line: one file a command.
//!
//! A command is a `clap::Args` struct with `run(self) -> Outcome`. To add one, write its file,
//! name its module here and give it a line in [`Command`] and in [`Command::run`]. A command
//! prints its result on standard output with [`out`] or [`out_json`] and returns any error;
//! [`main`] prints it on standard error and turns it into the exit code.

mod chassis;
mod check;
mod demo;
mod explain;
mod keys;
mod live;
mod map;
mod pile;
mod plan;
mod point;
mod provision;
mod replay;
mod reproduce;
mod run;
mod select;
mod simulate;
mod span;
mod stop;
mod table;

use std::{
    error::Error,
    io::{self, Write as _},
    process::ExitCode,
};

use clap::{Parser, Subcommand};
use serde::Serialize;

/// How a command ends. The error's text is one sentence with the cause and the next step.
type Outcome = Result<(), Box<dyn Error>>;

/// The exit code when a board has answered, and refused. Any other failure is 1, and what is wrong
/// on the command line is 2.
const REFUSED: u8 = 3;

/// Keeps a fleet of indoor robots charged.
#[derive(Parser)]
#[command(name = "chargehand", version, about, propagate_version = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Demo(demo::Demo),
    Simulate(simulate::Simulate),
    Run(run::Run),
    Check(check::Check),
    Map(map::Map),
    Plan(plan::Plan),
    Select(select::Select),
    Explain(explain::Explain),
    Replay(replay::Replay),
    Reproduce(reproduce::Reproduce),
    Chassis(chassis::Chassis),
    Keys(keys::MakeKeys),
    Provision(provision::MakePile),
    Pile(pile::Pile),
}

impl Command {
    fn run(self) -> Outcome {
        match self {
            Self::Demo(command) => command.run(),
            Self::Simulate(command) => command.run(),
            Self::Run(command) => command.run(),
            Self::Check(command) => command.run(),
            Self::Map(command) => command.run(),
            Self::Plan(command) => command.run(),
            Self::Select(command) => command.run(),
            Self::Explain(command) => command.run(),
            Self::Replay(command) => command.run(),
            Self::Reproduce(command) => command.run(),
            Self::Chassis(command) => command.run(),
            Self::Keys(command) => command.run(),
            Self::Provision(command) => command.run(),
            Self::Pile(command) => command.run(),
        }
    }
}

/// Runs the command that was asked for.
pub fn main() -> ExitCode {
    match Cli::parse().command.run() {
        Ok(()) => ExitCode::SUCCESS,
        // Whoever read our output has had enough of it (`chargehand ... | head`).
        Err(error) if is_broken_pipe(error.as_ref()) => ExitCode::SUCCESS,
        Err(error) => {
            let (bold_red, reset) = ("\x1b[1;31m", "\x1b[0m");
            // Nothing is left to do where even standard error is closed.
            let _ = writeln!(anstream::stderr(), "{bold_red}error:{reset} {error}");
            if is_refusal(error.as_ref()) { ExitCode::from(REFUSED) } else { ExitCode::FAILURE }
        }
    }
}

fn is_refusal(error: &(dyn Error + 'static)) -> bool {
    let chassis = error.downcast_ref().is_some_and(chassis::is_refusal);
    chassis || error.downcast_ref().is_some_and(pile::is_refusal)
}

fn is_broken_pipe(error: &(dyn Error + 'static)) -> bool {
    error.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
}

/// Prints text for a person; colours are dropped where standard output is no terminal.
fn out(text: &str) -> Outcome {
    Ok(writeln!(anstream::stdout(), "{text}")?)
}

/// Prints data for a program.
fn out_json(data: &impl Serialize) -> Outcome {
    let mut stdout = io::stdout().lock();
    // Not `to_writer`: it would hide a closed pipe inside its own error type.
    Ok(writeln!(stdout, "{}", serde_json::to_string_pretty(data)?)?)
}

/// Prints data of many for a program: a line each.
fn out_json_line(data: &impl Serialize) -> io::Result<()> {
    writeln!(io::stdout().lock(), "{}", serde_json::to_string(data)?)
}

/// Reads a number of 0 or more.
fn non_negative(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number >= 0.0);
    number.ok_or_else(|| "expected a finite number of 0 or more".into())
}
