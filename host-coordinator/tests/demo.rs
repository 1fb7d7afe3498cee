//! The demo as a person starts it: one command, a whole site, real sockets.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::{
    io::{BufRead, BufReader, Read},
    process::{Command, Stdio},
};

use serde_json::Value;

fn demo(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_chargehand"));
    command.arg("demo").args(arguments).stdin(Stdio::null());
    command
}

#[test]
fn robots_are_charged_and_no_pile_is_ever_given_twice() {
    let output = demo(&["--duration", "20m", "--speed", "200", "--seed", "1", "--headless", "--json"])
        .output()
        .expect("the demo starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let report: Value = serde_json::from_slice(&output.stdout).expect("one JSON document on standard output");
    assert_eq!(report["double_grants"], 0, "{report}\n{errors}");
    assert_eq!(report["stranded"], 0, "{report}\n{errors}");
    assert!(report["charges_completed"].as_u64().unwrap() > 0, "{report}\n{errors}");
    assert!(report["mean_wait_s"].as_f64().unwrap() <= report["worst_wait_s"].as_f64().unwrap(), "{report}");
    let planning = &report["planning_us"];
    assert!(planning["p50"].as_u64().unwrap() > 0, "{report}");
    assert!(planning["p50"].as_u64().unwrap() <= planning["p99"].as_u64().unwrap(), "{report}");
}

#[test]
#[cfg(unix)]
fn ctrl_c_ends_the_demo_with_its_report() {
    let mut child = demo(&["--speed", "200", "--headless", "--json"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the demo starts");
    // It says when it runs; only then is Ctrl-C its to handle.
    let mut errors = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    while !line.contains("Ctrl-C") {
        line.clear();
        assert!(errors.read_line(&mut line).unwrap() > 0, "the demo ended without a word");
    }
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill is there");
    assert!(sent.success());

    let mut report = String::new();
    child.stdout.take().unwrap().read_to_string(&mut report).unwrap();
    let mut rest = String::new();
    errors.read_to_string(&mut rest).unwrap();
    assert!(child.wait().unwrap().success(), "{rest}");
    let report: Value = serde_json::from_str(&report).expect("one JSON document on standard output");
    assert_eq!(report["double_grants"], 0, "{report}");
}

#[test]
fn a_speed_or_duration_that_makes_no_sense_is_refused() {
    for arguments in [["--speed", "0"], ["--speed", "nan"], ["--duration", "soon"]] {
        let output = demo(&arguments).output().expect("the demo starts");
        assert!(!output.status.success(), "{arguments:?}");
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(errors.contains(arguments[1]), "{errors}");
    }
}
