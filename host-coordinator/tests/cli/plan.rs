//! `chargehand map info` and `chargehand plan`.

use std::fs;

use super::{Ran, chargehand, fig7, json, text};

#[test]
fn map_info_counts_cells_and_regions() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("two.map");
    // The diagonal does not join the two parts: no corner is cut.
    fs::write(&file, "type octile\nheight 3\nwidth 3\nmap\n..@\n@@.\n...\n").unwrap();
    let info = json(&["map", "info", text(&file)]);
    let expected = serde_json::json!({
        "kind": "MovingAI map", "width": 3, "height": 3, "resolution_m": 1.0, "origin": [0.0, 0.0, 0.0],
        "free": 6, "blocked": 3, "unknown": 0, "regions": 2, "largest_region": 4,
        "piles": 0, "doors": 0, "lanes": 0, "lanes_m": 0.0, "lifts": [],
    });
    assert_eq!(info, expected);
    fs::write(&file, "type octile\nheight 2\nwidth 3\nmap\n...\n..\n").unwrap();
    let error = chargehand(&["map", "info", text(&file)]).fails();
    assert!(error.contains("two.map:6: a row of 2 cells, expected 3, as the width says"), "{error}");
}

/// A plan on the paper's site.
fn plan(arguments: &str) -> Ran {
    let site = fig7();
    let mut all = vec!["plan", "--site", text(&site)];
    all.extend(arguments.split(' '));
    chargehand(&all)
}

#[test]
fn plan_gives_the_printed_lengths_in_the_sites_own_frame() {
    for (planner, length, doors) in [("astar", 45.0, None), ("lmpp", 46.236_067_977_499_8, Some(vec![1]))] {
        let output = plan(&format!("--from 4,66 --to 0,70 --planner {planner} --json")).succeeds();
        let planned: serde_json::Value = serde_json::from_str(&output).unwrap();
        assert!((planned["length"].as_f64().unwrap() - length).abs() < 1e-12, "{planner}: {planned}");
        assert_eq!(planned["expanded"].as_u64().unwrap() > 0, planner == "astar", "lmpp recalls");
        assert!(planned["micros"].as_f64().unwrap() > 0.0);
        let path = planned["path"].as_array().unwrap();
        assert_eq!(path.first(), Some(&serde_json::json!([4, 66])));
        assert_eq!(path.last(), Some(&serde_json::json!([1, 70])), "0 acts as 1");
        assert_eq!(planned.get("doors"), doors.map(|doors| serde_json::json!(doors)).as_ref());
    }
}

#[test]
fn plan_on_a_bare_map_counts_from_the_upper_left_with_8_neighbours() {
    let map = fig7().join("fig7.map");
    let planned = json(&["plan", "--map", text(&map), "--from", "0,0", "--to", "2,1"]);
    assert!((planned["length"].as_f64().unwrap() - (1.0 + 2f64.sqrt())).abs() < 1e-12, "{planned}");
    let arguments = ["plan", "--map", text(&map), "--from", "0,0", "--to", "2,1", "--neighbours", "16"];
    assert_eq!(json(&arguments)["path"], serde_json::json!([[0, 0], [2, 1]]));
}

#[test]
fn plan_avoids_congested_doors() {
    let output = plan("--from 40,64 --to 0,70 --planner lmpp").succeeds();
    assert!(output.contains("doors     1\n"), "{output}");
    let error = plan("--from 40,64 --to 0,70 --planner lmpp --theta 0.3").fails();
    assert!(error.contains("no chain of open doors leads from (40, 64) to (0, 70)"), "{error}");
}

#[test]
fn plan_says_what_is_wrong() {
    for (arguments, mistake) in [
        ("--from 70,100 --to 1,1", "(70, 100) is a wall: give a free cell"),
        ("--from 1,1 --to 500,1", "(500, 1) is outside the map, where x goes from 1 to 100"),
        ("--from 1,1 --to 2,2 --planner lmpp", "no pile stands at (2, 2): lmpp recalls paths to piles"),
        ("--from 1,1 --to 2,2 --theta 0.3", "--theta closes doors, which astar does not know"),
        ("--from 1,1 --to 2", "expected two whole numbers as X,Y"),
        ("--from 1,1 --to 2,2 --neighbours 9", "expected 8 or 16"),
        ("--from 1,1 --to 2,2 --planner lmpp --theta nan", "expected a finite number of 0 or more"),
    ] {
        let error = plan(arguments).fails();
        assert!(error.contains(mistake), "{arguments}: {error}");
    }
    let map = fig7().join("fig7.map");
    let arguments = ["plan", "--map", text(&map), "--from", "0,0", "--to", "2,1", "--planner", "lmpp"];
    assert!(chargehand(&arguments).fails().contains("lmpp needs the rooms, doors and piles of a site"));
}
