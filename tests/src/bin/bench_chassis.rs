//! Of `cargo xtask bench chassis`: what control ticks of the chassis' image cost in QEMU while it
//! drives, as JSON.

use std::io;
use std::process::ExitCode;

use protocol::DurationMs;
use serde_json::json;
use tests::chassis_bench::{ChassisBench, Costs, twist};
use tests::emulator::Pace;

/// Of each motion, by the chassis' clock; four of them make 10,000 ticks.
const MOTION: DurationMs = DurationMs(25_000);

fn main() -> ExitCode {
    match measure() {
        Ok(Costs { ticks, median, worst, stack }) => {
            println!("{}", json!({ "ticks": ticks, "p50": median, "worst": worst, "stack_bytes": stack }));
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Where the computer is too slow for the hurried chassis, that stops and starts anew, which costs as
/// much as any tick.
fn measure() -> io::Result<Costs> {
    let mut bench = ChassisBench::boot_at(Pace::Hurried)?;
    bench.costs()?;
    for (vx, vy, wz) in [(0.5, 0.0, 0.0), (-0.3, 0.3, 0.0), (0.2, -0.1, 1.0), (0.0, 0.0, -2.0)] {
        bench.drive_for(twist(vx, vy, wz)?, MOTION)?;
    }
    bench.costs()
}
