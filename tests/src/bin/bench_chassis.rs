//! `cargo xtask bench chassis`: what control ticks of the chassis' image cost in QEMU while it drives.

use std::io;
use std::process::ExitCode;

use protocol::DurationMs;
use tests::chassis_bench::{ChassisBench, Costs, twist};

/// Instructions that the worst tick may take.
const BUDGET: u32 = 8_000;
/// Of each motion, by the chassis' clock; four of them make 10,000 ticks.
const MOTION: DurationMs = DurationMs(25_000);

fn main() -> ExitCode {
    let costs = match measure() {
        Ok(costs) => costs,
        Err(error) => {
            eprintln!("error: {error}");
            return ExitCode::FAILURE;
        }
    };
    let Costs { ticks, median, worst, stack } = costs;
    println!("control tick: p50 {median}, worst {worst} instructions of {ticks} ticks (budget {BUDGET})");
    println!("stack: {stack} bytes at the deepest, the model's share included");
    if worst > BUDGET { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

fn measure() -> io::Result<Costs> {
    let mut bench = ChassisBench::boot()?;
    bench.costs()?;
    for (vx, vy, wz) in [(0.5, 0.0, 0.0), (-0.3, 0.3, 0.0), (0.2, -0.1, 1.0), (0.0, 0.0, -2.0)] {
        bench.drive_for(twist(vx, vy, wz)?, MOTION)?;
    }
    bench.costs()
}
