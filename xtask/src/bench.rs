//! What an image needs: instructions of its control ticks or its frames in QEMU, and memory; and what the
//! coordinator needs.

use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::command::{Failure, cargo};
use crate::size::{self, Size};
use crate::{firmware, setup};

/// Instructions that the chassis' worst control tick may take.
const BUDGET: u32 = 8_000;
/// Boards of the chassis.
const BOARDS: [&str; 2] = ["emulated", "stm32"];

/// What the chassis' control ticks have cost.
#[derive(Deserialize)]
struct Costs {
    ticks: u32,
    p50: u32,
    worst: u32,
    stack_bytes: u32,
}

/// Measures the chassis. Fails if its worst tick is beyond the budget.
pub fn chassis(json: bool) -> Result<(), Failure> {
    let toolchain = setup::all()?;
    firmware::compile(&toolchain)?;
    let printed = cargo("run --quiet --package tests --bin bench_chassis").output()?;
    let costs: Costs = serde_json::from_str(&printed).map_err(|error| {
        Failure::new(format!("the bench printed {printed:?} ({error})"), "report this as a defect of xtask")
    })?;
    let mut images = Vec::new();
    for board in BOARDS {
        images.push((board, size::of_file(&firmware::path("firmware-chassis", board))?));
    }
    if json {
        print_json(&costs, &images)
    } else {
        print(&costs, &images)
    }
    if costs.worst <= BUDGET {
        return Ok(());
    }
    let problem = format!("the worst control tick took {} instructions, beyond {BUDGET}", costs.worst);
    Err(Failure::new(problem, "see what has made it slower"))
}

fn print(Costs { ticks, p50, worst, stack_bytes }: &Costs, images: &[(&str, Size)]) {
    println!("control tick: p50 {p50}, worst {worst} instructions of {ticks} ticks (budget {BUDGET})");
    println!("stack: {stack_bytes} bytes at the deepest, the model's share included");
    for (board, size) in images {
        println!("firmware-chassis ({board}): {}", size::describe(*size));
    }
}

fn print_json(Costs { ticks, p50, worst, stack_bytes }: &Costs, images: &[(&str, Size)]) {
    let images: Vec<_> = images
        .iter()
        .map(|(board, size)| json!({ "board": board, "flash_bytes": size.flash, "ram_bytes": size.ram }))
        .collect();
    let tick = json!({ "ticks": ticks, "p50": p50, "worst": worst, "budget": BUDGET });
    println!("{}", json!({ "tick_instructions": tick, "stack_bytes": stack_bytes, "images": images }));
}

/// What the pile's frames, records and ticks have cost.
#[derive(Deserialize)]
struct PileCosts {
    frames: Vec<FrameCost>,
    records: Vec<RecordCost>,
    over_current_to_open: Reaction,
    tick: Ticks,
    stack_bytes: u32,
}

/// From the sample that shows it to the command: samples after that one, and instructions.
#[derive(Deserialize, Serialize)]
struct Reaction {
    ticks: u32,
    instructions: u32,
}

/// What its control ticks have cost during a charge, in instructions.
#[derive(Deserialize, Serialize)]
struct Ticks {
    ticks: u32,
    p50: u32,
    worst: u32,
}

/// Instructions, with a seal and without.
#[derive(Deserialize, Serialize)]
struct FrameCost {
    frame: String,
    seal: u32,
    open: u32,
    seal_insecure: u32,
    open_insecure: u32,
}

/// Instructions to store the largest record of a kind, the flash's own time not counted.
#[derive(Deserialize, Serialize)]
struct RecordCost {
    record: String,
    instructions: u32,
}

/// Measures the pile.
pub fn pile(json: bool) -> Result<(), Failure> {
    let toolchain = setup::all()?;
    firmware::compile(&toolchain)?;
    let printed = cargo("run --quiet --package tests --bin bench_pile").output()?;
    let costs: PileCosts = serde_json::from_str(&printed).map_err(|error| {
        Failure::new(format!("the bench printed {printed:?} ({error})"), "report this as a defect of xtask")
    })?;
    let PileCosts { frames, records, over_current_to_open, tick, stack_bytes } = costs;
    if json {
        println!(
            "{}",
            json!({
                "frame_instructions": frames,
                "record_instructions": records,
                "over_current_to_open": over_current_to_open,
                "tick_instructions": tick,
                "stack_bytes": stack_bytes,
            })
        );
        return Ok(());
    }
    let Reaction { ticks, instructions } = over_current_to_open;
    println!("over-current to contactor open: {ticks} ticks after the sample, {instructions} instructions");
    let Ticks { ticks, p50, worst } = tick;
    println!("control tick: p50 {p50}, worst {worst} instructions of {ticks} ticks");
    println!("stack: {stack_bytes} bytes at the deepest, the model's share included");
    for FrameCost { frame, seal, open, seal_insecure, open_insecure } in &frames {
        println!(
            "{frame}: seal {seal}, open {open} instructions; without a seal {seal_insecure} and {open_insecure}"
        );
    }
    for RecordCost { record, instructions } in &records {
        println!("{record}: {instructions} instructions to store");
    }
    Ok(())
}

/// Measures the coordinator on this machine.
pub fn coordinator(json: bool) -> Result<(), Failure> {
    let bench = cargo("bench --quiet --package host-coordinator --bench coordinator --");
    if json { bench.args(["--json"]).run() } else { bench.run() }
}
