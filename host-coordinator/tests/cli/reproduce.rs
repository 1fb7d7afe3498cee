//! `chargehand reproduce`: the papers' tables.

use super::{chargehand, json};

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
    assert!(error.contains("paper `ravankar` is not reproduced: give one of lmpp"), "{error}");
}
