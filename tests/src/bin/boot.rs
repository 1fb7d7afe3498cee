//! `boot pile|chassis`: how long a board takes from its reset to its Hello, in LabWired.

use std::env;
use std::process::ExitCode;
use std::time::Duration;

use tests::labwired::{CHASSIS, PILE, boot};

/// A board that has said nothing by then never will.
const PATIENCE: Duration = Duration::from_millis(200);

fn main() -> ExitCode {
    let board = match env::args().nth(1).as_deref() {
        Some("pile") => PILE,
        Some("chassis") => CHASSIS,
        _ => {
            eprintln!("error: say which: boot pile|chassis");
            return ExitCode::FAILURE;
        }
    };
    let package = board.package;
    match boot(board, PATIENCE) {
        Ok(boot) => match boot.hello_at() {
            Some(at) => {
                println!("{package}: Hello {} ms after the reset (LabWired, without FPU)", at.as_millis());
                ExitCode::SUCCESS
            }
            None => {
                eprintln!("error: {package} said no Hello within {PATIENCE:?}, only {boot:#?}");
                ExitCode::FAILURE
            }
        },
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
