//! Of `cargo xtask bench pile`: what frames cost the pile's image in QEMU, in instructions, as JSON.

use std::process::ExitCode;
use std::time::Duration;

use serde_json::{Value, json};
use tests::emulator::{Emulator, EmulatorError};

/// A board that has said nothing for this long will not.
const SOON: Duration = Duration::from_secs(30);
/// How many kinds of frames are measured.
const FRAMES: usize = 2;

fn main() -> ExitCode {
    match measure() {
        Ok(frames) if frames.len() == FRAMES => {
            println!("{}", json!({ "frames": frames }));
            ExitCode::SUCCESS
        }
        Ok(_) => {
            eprintln!(
                "error: the pile's log does not say what its frames cost; was it built with DEFMT_LOG=info?"
            );
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn measure() -> Result<Vec<Value>, EmulatorError> {
    let mut board = Emulator::boot_counting()?;
    let mut costs = Vec::new();
    while costs.len() < FRAMES
        && let Some(line) = board.next_line(SOON)
    {
        costs.extend(line.split_once("cost of a frame: ").map(|(_, text)| cost(text)));
    }
    Ok(costs)
}

/// `grant seal 1 open 2 without a seal 3 4`
fn cost(text: &str) -> Value {
    let words: Vec<_> = text.split_whitespace().collect();
    let number = |at: usize| words.get(at).and_then(|word| word.parse::<u32>().ok());
    json!({
        "frame": words.first(),
        "seal": number(2),
        "open": number(4),
        "seal_insecure": number(8),
        "open_insecure": number(9),
    })
}
