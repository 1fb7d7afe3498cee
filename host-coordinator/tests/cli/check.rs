//! `chargehand check`: every mistake is named with its file and line.

use std::{fs, path::Path};

use super::{chargehand, copy_of, fig7, fig7_with, site, text};

/// The line of `needle` in `file` of `directory`.
fn line_of(directory: &Path, file: &str, needle: &str) -> usize {
    let text = fs::read_to_string(directory.join(file)).unwrap();
    1 + text.lines().position(|line| line.contains(needle)).unwrap()
}

/// Checks a configuration that is spoilt by replacing `from` by `to`, and wants to be told of
/// `mistake` in the line of `to`.
#[track_caller]
fn check_finds(file: &str, from: &str, to: &str, mistake: &str) {
    let copy = fig7_with(file, from, to);
    let error = chargehand(&["check", "--config", text(&copy.path().join("chargehand.toml"))]).fails();
    let line = line_of(copy.path(), file, to.lines().next().unwrap());
    let wanted = format!("{}:{line}: {mistake}", copy.path().join(file).display());
    assert!(error.contains(&wanted), "wanted {wanted}\ngot {error}");
    assert!(error.starts_with("error: found a mistake on reading"), "only this one: {error}");
}

#[test]
fn the_example_configuration_is_ready_to_run() {
    let copy = fig7_with("site.toml", "", "");
    let output = chargehand(&["check", "--config", text(&copy.path().join("chargehand.toml"))]).succeeds();
    let (warning, ready) = output.split_once('\n').unwrap();
    assert_eq!(warning, "pile 7 is in a subarea without a door: robots elsewhere will not use it");
    assert!(
        ready.contains("is ready to run: 3 robots on \"LMPP Fig. 7\", a site of 13 piles and 7 doors"),
        "{ready}"
    );
}

#[test]
fn a_site_of_one_subarea_needs_no_doors() {
    let copy = copy_of(&site("access-fig3"));
    let output = chargehand(&["check", "--config", text(&copy.path().join("chargehand.toml"))]).succeeds();
    let wanted = "is ready to run: 1 robots on \"Access Fig. 3\", a site of 12 piles and 0 doors\n";
    assert!(output.ends_with(wanted) && output.lines().count() == 1, "{output}");
}

#[test]
fn check_refuses_nan_in_a_configuration() {
    let file = "chargehand.toml";
    check_finds(
        file,
        "theta = 1.0 ",
        "theta = nan ",
        "`theta` is nan, expected a finite number of 0 or more",
    );
    check_finds(
        file,
        "energy_per_metre_j = 40",
        "energy_per_metre_j = +inf",
        "`energy_per_metre_j` is +inf, expected a number from 0.001 to 1000000",
    );
}

#[test]
fn check_refuses_an_unknown_key() {
    check_finds(
        "chargehand.toml",
        "event_log = ",
        "colour = 1\nevent_log = ",
        "the file has an unknown key `colour`, expected one of `site`, `event_log`",
    );
}

#[test]
fn check_refuses_two_robots_with_one_tag() {
    check_finds(
        "chargehand.toml",
        "tag = \"E28068940000500000000003\"",
        "tag = \"E28068940000500000000001\" # again",
        "tag E28068940000500000000001 is there twice, expected a tag of its own",
    );
}

#[test]
fn check_refuses_a_map_with_ragged_rows() {
    let row = ".......................@@@........................@@@...............@@@.............................\n";
    let short = format!("...{row}");
    check_finds("fig7.map", row, &short, "a row of 103 cells, expected 100, as the width says");
    let copy = fig7_with("fig7.map", "height 100", "height 99");
    let error = chargehand(&["check", "--config", text(&copy.path().join("chargehand.toml"))]).fails();
    assert!(error.contains("fig7.map:104: text after the last of 99 rows, expected the end"), "{error}");
}

#[test]
fn check_refuses_a_pile_in_a_wall() {
    check_finds("site.toml", "at = [68, 100]", "at = [70, 100]", "pile 3 is in a wall, expected a free cell");
}

#[test]
fn check_refuses_a_pile_outside_the_map() {
    check_finds(
        "site.toml",
        "at = [68, 100]",
        "at = [68, 101]",
        "pile 3 at (68, 101) is outside the map, where x goes from 1 to 100 and y from 1 to 100",
    );
}

#[test]
fn check_refuses_a_door_in_no_wall() {
    let wanted = "door 1 is in no wall, expected a blocked cell within 5 cells of it";
    check_finds("site.toml", "at = [24, 70]", "at = [10, 85]", wanted);
    // In a wall, but in that of other rooms.
    check_finds(
        "site.toml",
        "at = [24, 70]",
        "at = [75, 70]",
        "door 1 does not lead to subarea \"A\", which it joins",
    );
    // Near both of its rooms, but beside an unbroken wall.
    check_finds(
        "site.toml",
        "at = [24, 70]",
        "at = [10, 70]",
        "door 1 does not lead to subarea \"K\", which it joins, expected an opening to it within 5 cells",
    );
}

#[test]
fn check_refuses_a_door_in_a_wall_and_one_to_nowhere() {
    check_finds(
        "site.toml",
        "at = [24, 70]",
        "at = [25, 80]",
        "door 1 is in a wall, expected a free cell of the",
    );
    check_finds(
        "site.toml",
        "joins = [\"A\", \"K\"]",
        "joins = [\"A\", \"Z\"]",
        "door 1 joins subarea \"Z\", which there is not, expected two of the letters ABCDKHWJL",
    );
}

#[test]
fn check_refuses_two_piles_with_one_number_and_says_where_the_first_is() {
    let first = line_of(&fig7(), "site.toml", "at = [50, 70]") - 1;
    check_finds(
        "site.toml",
        "id = 3\nat = [68, 100]",
        "id = 2 # again\nat = [68, 100]",
        &format!("pile 2 is there twice, first in line {first}, expected a number of its own"),
    );
}

#[test]
fn check_refuses_nan_and_unknown_keys_in_a_site() {
    check_finds(
        "site.toml",
        "resolution_m = 1.0",
        "resolution_m = nan",
        "`resolution_m` is nan, expected a number",
    );
    check_finds(
        "site.toml",
        "charged = 0.9",
        "charge = 0.9",
        "[[pile]] has an unknown key `charge`, expected one of `id`, `at`, `power_w`, `charged`",
    );
}

#[test]
fn check_refuses_a_pile_to_call_that_the_site_has_not() {
    let call = "# [[pile]]\n# id = 1\n# address";
    let copy = fig7_with("chargehand.toml", call, "[[pile]]\nid = 99\naddress");
    let config = copy.path().join("chargehand.toml");
    let line = line_of(copy.path(), "chargehand.toml", "id = 99");
    let error = chargehand(&["check", "--config", text(&config)]).fails();
    let wanted = format!("{}:{line}: pile 99 is not in the site, expected a pile of", config.display());
    assert!(error.contains(&wanted), "{error}");
}

#[test]
fn check_names_all_mistakes_at_once_in_text_and_json() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bad.toml");
    fs::write(&file, "colour = 1\n[policy]\nchoose = \"best\"\nlease_s = \n[[robot]]\nid = -1\n").unwrap();
    let ran = chargehand(&["check", "--config", text(&file), "--json"]);
    let report: serde_json::Value = serde_json::from_str(&ran.stdout).unwrap();
    assert_eq!(report["ready"], false);
    let mistakes = report["mistakes"].as_array().unwrap();
    let error = ran.fails();
    for (line, mistake) in [
        (1, "the file has no `site`"),
        (1, "the file has no `event_log`"),
        (1, "the file has no `keys`"),
        (1, "the file has an unknown key `colour`"),
        (3, "`choose` is \"best\", expected \"joint\", \"lmpp\""),
        (4, "is no valid TOML"),
        (5, "[[robot]] has no `tag`"),
        (5, "[[robot]] has no `full_j`"),
        (5, "[[robot]] has no `energy_per_metre_j`"),
        (6, "`id` is -1, expected a whole number from 0 to 65535"),
    ] {
        assert!(error.contains(&format!("bad.toml:{line}: {mistake}")), "{line}: {mistake} in\n{error}");
        let same = |found: &&serde_json::Value| {
            found["line"] == line
                && mistake.starts_with(found["problem"].as_str().unwrap().split(" (").next().unwrap())
        };
        assert!(mistakes.iter().any(|found| same(&found)), "{line}: {mistake} in {mistakes:?}");
    }
    assert_eq!(mistakes.len(), 10);
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let error = chargehand(&["check", "--config", "no-such.toml"]).fails();
    assert!(error.contains("no-such.toml: cannot be read (No such file"), "{error}");
}
