//! Of `cargo xtask bench pile`: what frames, records and control ticks cost the image in QEMU, and how
//! quickly it opens on an over-current, in instructions, as JSON.

use std::process::ExitCode;
use std::time::Duration;

use serde_json::{Value, json};
use tests::emulator::{Emulator, EmulatorError};
use tests::pile_bench::PileBench;

/// A board that has said nothing for this long will not.
const SOON: Duration = Duration::from_secs(30);
/// How many kinds of frames are measured.
const FRAMES: usize = 2;
/// How many kinds of records, which the log tells of after the frames.
const RECORDS: usize = 4;

fn main() -> ExitCode {
    match measure() {
        Ok((frames, records)) if (frames.len(), records.len()) == (FRAMES, RECORDS) => {
            let mut measured = react();
            if let Some(fields) = measured.as_object_mut() {
                fields.insert("frames".into(), json!(frames));
                fields.insert("records".into(), json!(records));
            }
            println!("{measured}");
            ExitCode::SUCCESS
        }
        Ok(_) => {
            eprintln!(
                "error: the pile's log does not say what its frames and records cost; was it built with DEFMT_LOG=info?"
            );
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// A charge that ends in an over-current.
fn react() -> Value {
    let mut pile = PileBench::new();
    pile.charge();
    let order = pile.test.order("current about 30");
    pile.until("an open contactor", |power| !power.told_closed);
    let reaction = pile.reaction().map(|reaction| (reaction.ticks, reaction.instructions));
    let costs = pile.test.numbers::<u32, 4>("cost");
    let (Ok(()), Some((ticks, instructions)), Ok([counted, p50, worst, stack_bytes])) =
        (order, reaction, costs)
    else {
        return Value::Null;
    };
    json!({
        "over_current_to_open": { "ticks": ticks, "instructions": instructions },
        "tick": { "ticks": counted, "p50": p50, "worst": worst },
        "stack_bytes": stack_bytes,
    })
}

fn measure() -> Result<(Vec<Value>, Vec<Value>), EmulatorError> {
    let mut board = Emulator::boot_counting()?;
    let (mut frames, mut records) = (Vec::new(), Vec::new());
    while records.len() < RECORDS
        && let Some(line) = board.next_line(SOON)
    {
        frames.extend(line.split_once("cost of a frame: ").map(|(_, text)| cost(text)));
        records.extend(line.split_once("cost of a record: ").and_then(|(_, text)| record(text)));
    }
    Ok((frames, records))
}

/// `charge 1`
fn record(text: &str) -> Option<Value> {
    let (record, instructions) = text.split_once(' ')?;
    Some(json!({ "record": record, "instructions": instructions.trim().parse::<u32>().ok()? }))
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
