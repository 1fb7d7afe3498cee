//! The pin tables of the book are those of the boards, and no pin has two uses.
#![allow(clippy::unwrap_used)]

/// A board's table as code, and the page of the book that shows it.
const BOARDS: [(&str, &str); 2] = [
    (include_str!("../../firmware-pile/src/board/stm32/pins.rs"), include_str!("../../docs/pile-board.md")),
    (
        include_str!("../../firmware-chassis/src/board/stm32/pins.rs"),
        include_str!("../../docs/chassis-board.md"),
    ),
];

/// The lines of the book's table: `| name | pin | what for |`, where a name is in code style.
fn book(page: &str) -> Vec<&str> {
    let (_, table) = page.split_once("| name | pin or peripheral | what for |").unwrap();
    table
        .lines()
        .skip(1)
        .take_while(|line| line.starts_with('|'))
        .filter(|line| line.starts_with("| `"))
        .collect()
}

#[test]
fn the_books_pin_tables_are_the_boards() {
    for (code, page) in BOARDS {
        let table = code.split_once("pins! {").unwrap().1;
        let mut what_for = "";
        let mut rows = Vec::new();
        for line in table.lines().map(str::trim) {
            if let Some(text) = line.strip_prefix("/// ") {
                what_for = text;
            } else if let Some((name, pin)) = line.trim_end_matches(',').split_once(": ") {
                rows.push(format!("| `{name}` | {pin} | {what_for} |"));
            }
        }
        assert!(rows.len() > 20, "only {} rows", rows.len());
        assert_eq!(book(page), rows);
    }
}

#[test]
fn no_pin_is_used_twice() {
    for (_, page) in BOARDS {
        let mut pins: Vec<&str> = book(page).into_iter().filter_map(|row| row.split('|').nth(2)).collect();
        let all = pins.len();
        pins.sort_unstable();
        pins.dedup();
        assert_eq!(pins.len(), all);
    }
}
