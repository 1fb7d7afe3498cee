//! `chargehand reproduce`: the papers' tables.

use std::{collections::BTreeSet, fs, io::Cursor};

use super::{chargehand, json, text};

#[test]
fn reproduce_finds_every_printed_length_and_explains_every_difference() {
    let report = json(&["reproduce", "--paper", "lmpp"]);
    let rows = report["rows"].as_array().unwrap();
    let of = |table: &'static str| rows.iter().filter(move |row| row["table"] == table);
    let is_distance = |row: &&serde_json::Value| row["column"].as_str().unwrap().contains("D(Q");
    let lengths = of("6").chain(of("10")).chain(of("14")).chain(of("8").filter(is_distance));
    assert_eq!(lengths.clone().count(), 68);
    for row in lengths.chain(of("7")).chain(of("13")) {
        assert_eq!(row["verdict"], "exact", "{row}");
    }
    // Two choices of Test 3 are occupied piles; eq. 9 as printed needs no reach, Test 4 does.
    let differing = |table, column| {
        let differs = of(table).filter(|row| row["verdict"] == "differs" && row["column"] == column);
        differs.map(|row| row["row"].as_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    let occupied = ["Test 3, condition (3), reach 120", "Test 3, condition (6), reach 120"];
    assert_eq!(differing("8", "eq. 9 as printed"), occupied);
    assert_eq!(differing("8", "corrected"), [&["Test 3, condition (2), reach 80"], &occupied[..]].concat());
    assert_eq!(differing("9", "eq. 9 as printed").len(), 9);
    assert!(differing("9", "corrected").is_empty());
    for row in rows.iter().filter(|row| row["verdict"] == "differs") {
        let note = row["note"].as_str().unwrap();
        assert!(note.contains("is occupied") || note.contains("beyond the reach"), "{row}");
    }
}

#[test]
fn reproduce_can_be_asked_for_one_table() {
    let report = json(&["reproduce", "--paper", "LMPP", "--table", "7"]);
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 18);
    assert!(rows.iter().all(|row| row["paper"] == "LMPP" && row["table"] == "7"));
    let output = chargehand(&["reproduce", "--paper", "lmpp", "--table", "14"]).succeeds();
    assert!(output.ends_with("LMPP: 20 rows, 20 exact, 0 close, 0 differ, 0 not comparable\n"), "{output}");
}

#[test]
fn reproduce_names_what_there_is_where_it_is_asked_for_something_else() {
    let error = chargehand(&["reproduce", "--paper", "lmpp", "--table", "4"]).fails();
    let wanted = "table 4 is not reproduced: there are LMPP 5, 6, 7, 8, 9, 10, 11, 12, 13, 14\n";
    assert!(error.ends_with(wanted), "{error}");
    let error = chargehand(&["reproduce", "--paper", "ravankar"]).fails();
    assert!(error.contains("paper `ravankar` is not reproduced: give one of lmpp, access"), "{error}");
}

#[test]
fn reproduce_finds_every_length_of_access_table_5_and_table_4_as_the_map_can() {
    let report = json(&["reproduce", "--paper", "access"]);
    let rows = report["rows"].as_array().unwrap();
    let verdicts = |table: &str| -> Vec<_> {
        let of_table = rows.iter().filter(|row| row["table"] == table);
        of_table.map(|row| (row["row"].as_str().unwrap(), row["verdict"].as_str().unwrap())).collect()
    };
    let table_5 = verdicts("5");
    assert_eq!(table_5.len(), 12);
    assert!(table_5.iter().all(|&(_, verdict)| verdict == "exact"), "{table_5:?}");
    assert_eq!(
        verdicts("4"),
        [
            ("Random-1", "close"),
            ("Random-2", "exact"),
            ("Random-3", "close"),
            ("Random-4", "close"),
            ("Random-5", "exact"),
            ("Sequential", "close"),
        ]
    );
    for row in rows.iter().filter(|row| row["table"] == "4") {
        let (published, ours) = (row["published"].as_f64().unwrap(), row["ours"].as_f64().unwrap());
        assert!((published - ours).abs() <= 0.0005 * published, "{row}");
    }
    let differing: Vec<_> = rows.iter().filter(|row| row["verdict"] == "differs").collect();
    assert!(differing.is_empty(), "{differing:?}");
    // What is only drawn to the text says so.
    for row in rows.iter().filter(|row| row["table"] == "Experiment 2" && row["row"] != "makes room") {
        assert!(row["note"].as_str().unwrap().contains("drawn to the text"), "{row}");
    }
}

#[test]
fn a_reproduced_row_has_the_keys_that_programs_read() {
    let report = json(&["reproduce", "--paper", "access", "--table", "experiment 1"]);
    assert_eq!(report["files"], serde_json::json!([]));
    let keys: BTreeSet<_> = report["rows"][0].as_object().unwrap().keys().map(String::as_str).collect();
    assert_eq!(
        keys,
        BTreeSet::from(["column", "note", "ours", "paper", "published", "row", "table", "verdict"])
    );
}

/// Draws all figures of a paper and checks them; of its tables one that takes no time is asked for.
fn plots_are_well_formed_and_of_one_size(paper: &str, table: &str, figures: usize) {
    let folder = tempfile::tempdir().unwrap();
    let plots = folder.path().join("new/plots");
    let report = json(&["reproduce", "--paper", paper, "--table", table, "--plots", text(&plots)]);
    let files: Vec<_> =
        report["files"].as_array().unwrap().iter().map(|file| file.as_str().unwrap()).collect();
    assert_eq!(files.len(), 2 * figures, "{files:?}");
    for pair in files.chunks(2) {
        let [svg, png] = pair else { panic!("a file alone: {pair:?}") };
        assert_eq!(svg.strip_suffix(".svg"), png.strip_suffix(".png"));
        let svg_text = fs::read_to_string(svg).unwrap();
        assert!(svg_text.len() < 300_000, "{svg}: {} bytes", svg_text.len());
        let svg = roxmltree::Document::parse(&svg_text).unwrap();
        let side = |name| svg.root_element().attribute(name).unwrap().parse::<u32>().unwrap();
        let mut png = png::Decoder::new(Cursor::new(fs::read(png).unwrap())).read_info().unwrap();
        assert_eq!((png.info().width, png.info().height), (side("width"), side("height")));
        let mut pixels = vec![0; png.output_buffer_size().unwrap()];
        png.next_frame(&mut pixels).unwrap();
        let dark = pixels.iter().filter(|&&value| value < 128).count();
        assert!(dark > 1_000, "{pair:?} is empty");
    }
}

#[test]
fn plots_of_lmpp_are_well_formed_svg_and_png_of_one_size() {
    plots_are_well_formed_and_of_one_size("lmpp", "12", 10);
}

#[test]
fn plots_of_access_are_well_formed_svg_and_png_of_one_size() {
    plots_are_well_formed_and_of_one_size("access", "1", 14);
}

#[test]
fn plots_of_mecanum_are_well_formed_svg_and_png_of_one_size() {
    plots_are_well_formed_and_of_one_size("mecanum", "III.C.2", 6);
}

#[test]
fn plots_of_igwo_are_well_formed_svg_and_png_of_one_size() {
    plots_are_well_formed_and_of_one_size("igwo", "I", 24);
}

#[test]
fn reproduce_says_where_plots_cannot_be_written() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    let error =
        chargehand(&["reproduce", "--paper", "access", "--table", "1", "--plots", text(&file)]).fails();
    assert!(error.contains("/file/access-experiment-1.svg cannot be written ("), "{error}");
    assert!(error.ends_with("): give --plots a folder that can be\n"), "{error}");
}

#[test]
fn mecanums_tables_compare_what_can_be_and_say_why_the_rest_can_not() {
    let report = json(&["reproduce", "--paper", "mecanum", "--table", "III.C.2"]);
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows[0]["verdict"], "exact", "{}", rows[0]);
    let report = json(&["reproduce", "--paper", "mecanum", "--table", "III"]);
    let rows = report["rows"].as_array().unwrap();
    // The printed ratios of the first row are not those of its numbers.
    let differs: Vec<_> = rows.iter().filter(|row| row["verdict"] == "differs").collect();
    assert!(differs.iter().any(|row| row["row"] == "1/6" && row["column"] == "I / II, printed time"));
    // Beyond those only what the text says of the improved A* can differ, which times of this run decide.
    let explained = |row: &serde_json::Value| row["row"] == "all maps" && row["note"] != "";
    let printed = |row: &serde_json::Value| row["column"].as_str().unwrap().contains("printed");
    assert!(differs.iter().all(|row| printed(row) || explained(row)), "{differs:?}");
    for row in rows.iter().filter(|row| row["verdict"] == "not-comparable") {
        assert_ne!(row["note"], "", "{row}");
    }
    // On the same cells nothing is shorter than A*'s path.
    for row in rows.iter().filter(|row| row["column"] == "I / II, length") {
        assert!(row["ours"].as_f64().unwrap() >= 1.0, "{row}");
    }
}
