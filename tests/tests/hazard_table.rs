//! The hazard table of the book against the tests and faults there are.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use protocol::FaultCode;

fn read(path: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    fs::read_to_string(root.join(path)).unwrap()
}

/// The cells of the table's rows.
fn rows() -> Vec<Vec<String>> {
    let page = read("docs/hazards.md");
    let table = page.lines().skip_while(|line| !line.starts_with("| cause |")).skip(2);
    let rows = table.take_while(|line| line.starts_with('|'));
    rows.map(|line| line.trim_matches('|').split('|').map(|cell| cell.trim().to_owned()).collect()).collect()
}

/// The names of the tests of the emulated pile in one file.
fn tests_in(file: &str) -> BTreeSet<String> {
    let text = read(&format!("tests/tests/emulated_pile/{file}.rs"));
    let after_attribute = text.split("#[test]\nfn ").skip(1);
    after_attribute.filter_map(|rest| rest.split('(').next()).map(str::to_owned).collect()
}

#[test]
fn every_row_names_a_test_that_exists_and_every_hazard_test_has_its_row() {
    let rows = rows();
    assert!(rows.len() > 20, "the table was not found");
    let named: BTreeSet<String> = rows.iter().map(|row| row[4].trim_matches('`').to_owned()).collect();
    assert!(rows.iter().all(|row| row.len() == 5 && row.iter().all(|cell| !cell.is_empty())), "{rows:#?}");
    let hazards = tests_in("hazards");
    let existing: BTreeSet<String> = hazards.union(&tests_in("frames")).cloned().collect();
    assert_eq!(named.difference(&existing).collect::<Vec<_>>(), Vec::<&String>::new(), "no such tests");
    assert_eq!(hazards.difference(&named).collect::<Vec<_>>(), Vec::<&String>::new(), "tests without a row");
}

#[test]
fn every_fault_has_a_row() {
    let rows = rows();
    // What the store cannot keep is no hazard of the contacts.
    for code in FaultCode::ALL.into_iter().filter(|&code| code != FaultCode::StoreFailed) {
        let name = format!("`{code:?}`");
        assert!(rows.iter().any(|row| row[2].contains(&name)), "{name} is in no row");
    }
}
