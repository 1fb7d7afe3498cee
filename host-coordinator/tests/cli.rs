//! The `chargehand` command as a person or a script meets it: the real binary, its output and
//! its exit code.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use tempfile::TempDir;

/// What a command left behind.
struct Ran {
    success: bool,
    stdout: String,
    stderr: String,
}

impl Ran {
    #[track_caller]
    fn succeeds(self) -> String {
        assert!(self.success, "failed: {}", self.stderr);
        assert_eq!(self.stderr, "");
        self.stdout
    }

    /// The error; a person must be told in words, not by a panic.
    #[track_caller]
    fn fails(self) -> String {
        assert!(!self.success, "succeeded: {}", self.stdout);
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
        assert!(!self.stderr.contains('\x1b'), "colours without a terminal: {:?}", self.stderr);
        self.stderr
    }
}

fn chargehand(arguments: &[&str]) -> Ran {
    let output = Command::new(env!("CARGO_BIN_EXE_chargehand")).args(arguments).output().unwrap();
    Ran {
        success: output.status.success(),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}

/// The paper's site, as it is in the repository.
fn fig7() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../sites/lmpp-fig7")
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// A copy of the paper's site in which `from` in `file` is replaced by `to`.
fn fig7_with(file: &str, from: &str, to: &str) -> TempDir {
    let copy = tempfile::tempdir().unwrap();
    for entry in fs::read_dir(fig7()).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), copy.path().join(entry.file_name())).unwrap();
    }
    let path = copy.path().join(file);
    let before = fs::read_to_string(&path).unwrap();
    assert!(before.contains(from), "{file} has no {from:?}");
    fs::write(&path, before.replacen(from, to, 1)).unwrap();
    copy
}

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
    let output = chargehand(&["check", "--config", text(&fig7().join("chargehand.toml"))]).succeeds();
    assert!(output.contains("is ready to run"), "{output}");
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
        "door 1 is not near subarea \"A\", which it joins",
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
    fs::write(&file, "colour = 1\n[policy]\nrule = \"best\"\nlease_s = \n[[robot]]\nid = -1\n").unwrap();
    let ran = chargehand(&["check", "--config", text(&file), "--json"]);
    let report: serde_json::Value = serde_json::from_str(&ran.stdout).unwrap();
    assert_eq!(report["ready"], false);
    let mistakes = report["mistakes"].as_array().unwrap();
    let error = ran.fails();
    for (line, mistake) in [
        (1, "the file has no `site`"),
        (1, "the file has no `event_log`"),
        (1, "the file has an unknown key `colour`"),
        (3, "`rule` is \"best\", expected \"corrected\" or \"paper-literal\""),
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
    assert_eq!(mistakes.len(), 9);
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let error = chargehand(&["check", "--config", "no-such.toml"]).fails();
    assert!(error.contains("no-such.toml: cannot be read (No such file"), "{error}");
}

/// Runs a command that prints JSON.
#[track_caller]
fn json(arguments: &[&str]) -> serde_json::Value {
    serde_json::from_str(&chargehand(&[arguments, &["--json"]].concat()).succeeds()).unwrap()
}

#[test]
fn map_info_counts_cells_and_regions() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("two.map");
    // The diagonal does not join the two parts: no corner is cut.
    fs::write(&file, "type octile\nheight 3\nwidth 3\nmap\n..@\n@@.\n...\n").unwrap();
    let info = json(&["map", "info", text(&file)]);
    let expected = serde_json::json!({
        "width": 3, "height": 3, "free": 6, "blocked": 3, "regions": 2, "largest_region": 4,
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
        assert!(planned["expanded"].as_u64().unwrap() > 0 && planned["micros"].as_f64().unwrap() > 0.0);
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

#[test]
fn reproduce_finds_every_printed_length_and_explains_every_difference() {
    let rows = json(&["reproduce"]);
    let rows = rows.as_array().unwrap();
    let of = |table: u64| rows.iter().filter(move |row| row["table"] == table);
    let is_distance = |row: &&serde_json::Value| row["column"].as_str().unwrap().contains("D(Q");
    let lengths = of(6).chain(of(10)).chain(of(14)).chain(of(8).filter(is_distance));
    assert_eq!(lengths.clone().count(), 68);
    for row in lengths.chain(of(7)).chain(of(13)) {
        assert_eq!(row["verdict"], "exact", "{row}");
    }
    // Two choices of Test 3 are occupied piles; eq. 9 as printed needs no reach, Test 4 does.
    let differing = |table, column| {
        let differs = of(table).filter(|row| row["verdict"] == "differs" && row["column"] == column);
        differs.map(|row| row["row"].as_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    let occupied = ["Test 3, condition (3), reach 120", "Test 3, condition (6), reach 120"];
    assert_eq!(differing(8, "eq. 9 as printed"), occupied);
    assert_eq!(differing(8, "corrected"), [&["Test 3, condition (2), reach 80"], &occupied[..]].concat());
    assert_eq!(differing(9, "eq. 9 as printed").len(), 9);
    assert!(differing(9, "corrected").is_empty());
    for row in rows.iter().filter(|row| row["verdict"] == "differs") {
        assert_ne!(row["note"], "", "{row}");
    }
}

#[test]
fn reproduce_can_be_asked_for_one_table() {
    let rows = json(&["reproduce", "--table", "7"]);
    assert!(rows.as_array().unwrap().iter().all(|row| row["table"] == 7));
    let output = chargehand(&["reproduce", "--table", "14"]).succeeds();
    assert!(output.ends_with("LMPP: 20 rows, 20 exact, 0 close, 0 differ, 0 not comparable\n"), "{output}");
    assert!(chargehand(&["reproduce", "--table", "4"]).fails().contains("table 4 is not reproduced"));
}
