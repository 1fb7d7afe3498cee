//! The book's pin table is the board's.
#![allow(clippy::unwrap_used)]

const PINS: &str = include_str!("../src/board/stm32/pins.rs");
const BOOK: &str = include_str!("../../docs/chassis-board.md");

#[test]
fn the_books_pin_table_is_the_boards() {
    let table = PINS.split_once("\npins! {").unwrap().1;
    let mut what_for = "";
    let mut rows = Vec::new();
    for line in table.lines().map(str::trim) {
        if let Some(text) = line.strip_prefix("/// ") {
            what_for = text;
        } else if let Some((name, pin)) = line.trim_end_matches(',').split_once(": ") {
            rows.push(format!("| `{name}` | {pin} | {what_for} |"));
        }
    }
    let book: Vec<&str> = BOOK.lines().filter(|line| line.starts_with("| `")).collect();
    assert_eq!(rows.len(), 41);
    assert_eq!(book, rows);
}

#[test]
fn no_pin_is_used_twice() {
    let mut pins: Vec<&str> = BOOK.lines().filter_map(|line| line.split('|').nth(2)).collect();
    let all = pins.len();
    pins.sort_unstable();
    pins.dedup();
    assert_eq!(pins.len(), all);
}
