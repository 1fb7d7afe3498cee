//! What the coordinator does in a second, and how long a robot waits for its pile.
//!
//! A floor of LMPP's Fig. 7 with 200 piles and 500 robots. [`throughput`] drives the core alone, on one core of
//! the machine; [`latency`] the whole daemon over UDP, authenticated, its log on disk and synced.
//!
//! `cargo xtask bench coordinator [--json]`.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[path = "../../../planning/benches/planning/clock.rs"]
#[allow(dead_code, reason = "the core's time is the thread's")]
mod clock;
mod latency;
mod site;
mod throughput;

use serde_json::json;

fn main() {
    let as_json = std::env::args().any(|argument| argument == "--json");
    let core = throughput::measure();
    let waits = latency::measure();
    if as_json {
        let latency = json!({
            "requests": waits.len(), "p50_ms": waits.quantile(0.5), "p99_ms": waits.quantile(0.99),
            "worst_ms": waits.quantile(1.0), "unanswered": waits.unanswered,
        });
        let inputs =
            json!({ "inputs": core.inputs, "events": core.events, "inputs_per_s": core.per_second() });
        println!("{}", json!({ "core": inputs, "grant_latency": latency }));
        return;
    }
    println!(
        "core: {:.0} inputs a second on one core ({} in {:.2} s; {} requests, {} grants, {} events for the log)",
        core.per_second(),
        core.inputs,
        core.seconds,
        core.requests,
        core.grants,
        core.events
    );
    println!(
        "from request to assignment: p50 {:.1} ms, p99 {:.1} ms, worst {:.1} ms of {} requests; {} unanswered",
        waits.quantile(0.5),
        waits.quantile(0.99),
        waits.quantile(1.0),
        waits.len(),
        waits.unanswered
    );
}
