//! `chargehand select`: a choice with its explanation.

use std::fs;

use super::{chargehand, fig7, json, text};

/// Condition (2) of LMPP Table 8.
const CONDITION_2: &str = "0,0,0.11,0.08,0,0.001,0.075,0.06,0.004,0.34,0.27,0,0.06";

#[test]
fn select_explains_every_pile_by_both_readings() {
    let site = fig7();
    let arguments = [
        "select",
        "--site",
        text(&site),
        "--robot",
        "80,50",
        "--reach",
        "80",
        "--probabilities",
        CONDITION_2,
    ];
    let corrected = json(&arguments);
    assert_eq!((&corrected["chosen"], &corrected["stage"]), (&13.into(), &"reach_some".into()));
    let piles = corrected["explanations"].as_array().unwrap();
    assert_eq!(piles.len(), 13);
    assert_eq!(piles[9]["verdict"], "out_of_reach");
    assert_eq!(piles[9]["reason"], "beyond the robot's reach of 80.0 cells");
    assert_eq!(piles[6]["verdict"], "no_path");
    let literal = json(&[&arguments[..], &["--literal"]].concat());
    assert_eq!(literal["chosen"], 10);
}

#[test]
fn select_reads_probabilities_from_a_file_and_names_a_bad_one() {
    let (site, folder) = (fig7(), tempfile::tempdir().unwrap());
    let file = folder.path().join("p.txt");
    let select = |probabilities: &str| {
        let start = ["select", "--site", text(&site), "--robot", "80,50", "--reach", "120"];
        chargehand(&[&start[..], &["--json", "--probabilities", probabilities]].concat())
    };
    fs::write(&file, CONDITION_2.replace(',', "\n")).unwrap();
    assert_eq!(select(text(&file)).succeeds(), select(CONDITION_2).succeeds());
    assert!(select("0.5,0.5").fails().contains("2 probabilities for 13 piles: give one for each pile"));
    assert!(select("0.5,nan").fails().contains("probability 2 is \"nan\": give a number from 0 to 1"));
    assert!(select("no-such-file").fails().contains("neither a list such as 0.5,0.2,0.3 nor a file"));
}
