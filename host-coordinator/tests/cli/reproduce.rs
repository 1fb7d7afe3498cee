//! `chargehand reproduce`: the papers' tables.

use super::{chargehand, json};

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
        let note = row["note"].as_str().unwrap();
        assert!(note.contains("is occupied") || note.contains("beyond the reach"), "{row}");
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
