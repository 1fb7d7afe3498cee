//! What takes too long for every day: simulated sites with all faults on many seeds, and a coordinator that is
//! killed many times.

use crate::command::{Command, cargo};

/// Every seed of the soak, an hour each, and a day of one of them: more than a million steps of one coordinator,
/// as often as it crashes in between.
pub fn all() -> [Command; 2] {
    [simulate("1", 10_000), simulate("24", 1)]
}

/// As many of them as take about a minute, and some at a facility that lacks power for all piles at once.
pub fn some() -> [Command; 2] {
    [simulate("1", 200), simulate("1", 40).args(["--power-cap=2500".to_owned()])]
}

fn simulate(hours: &str, seeds: u32) -> Command {
    cargo("run --release --quiet --package host-coordinator -- simulate").args([
        format!("--hours={hours}"),
        "--robots=50".to_owned(),
        "--piles=13".to_owned(),
        "--faults=all".to_owned(),
        format!("--seeds={seeds}"),
    ])
}

/// Kills the coordinator 200 times under load over real sockets: some minutes.
pub fn crash_loop() -> Command {
    cargo("bench --quiet --profile dev --package host-coordinator --bench crash_loop")
}
