//! `chargehand simulate`: figures for programs, the same for a seed.

use super::{chargehand, json};

const QUICK: [&str; 9] =
    ["simulate", "--robots", "20", "--piles", "4", "--hours", "0.1", "--first-seed", "5"];

#[test]
fn every_run_and_the_sum_have_the_same_figures() {
    let arguments: Vec<_> = QUICK.into_iter().chain(["--seeds", "2"]).collect();
    let report = json(&arguments);
    let keys = [
        "charge_distance_m",
        "completed",
        "coordinator_steps",
        "double_grants",
        "granted",
        "local_charges",
        "lost_requests",
        "preempted",
        "requests",
        "rescued",
        "seed",
        "stranded_reachable",
        "stranded_unreachable",
        "towed",
        "wait_s",
        "working_share",
    ];
    let runs = report["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 2);
    for figures in runs.iter().chain([&report["sum"]]) {
        let mut found: Vec<_> = figures.as_object().unwrap().keys().map(String::as_str).collect();
        found.sort_unstable();
        assert_eq!(found, keys);
        let waits = figures["wait_s"].as_object().unwrap();
        assert!(waits.contains_key("p50") && waits.contains_key("p99") && waits.len() == 2);
    }
    assert_eq!((&runs[0]["seed"], &runs[1]["seed"]), (&5.into(), &6.into()));
    assert_eq!(report, json(&arguments), "a seed gives the same run every time");
}

#[test]
fn two_policies_are_compared_figure_by_figure() {
    let arguments: Vec<_> = QUICK.into_iter().chain(["--seeds", "3", "--compare", "nearest,joint"]).collect();
    let rows = json(&arguments);
    let working = &rows.as_array().unwrap()[0];
    assert_eq!(working["figure"], "working_share");
    let [low, high] = ["low", "high"].map(|end| working[end].as_f64().unwrap());
    assert!(
        low <= working["difference"].as_f64().unwrap() && working["difference"].as_f64().unwrap() <= high
    );
}

#[test]
fn an_unknown_fault_is_named_with_those_there_are() {
    let ran = chargehand(&["simulate", "--faults", "loss,fire"]);
    assert!(!ran.success);
    assert!(ran.stderr.contains("\"fire\"") && ran.stderr.contains("pile-crash"), "{}", ran.stderr);
}
