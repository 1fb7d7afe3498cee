//! What must hold of every row and figure.

use std::collections::BTreeSet;

use super::*;
use crate::reproduce::{Verdict, figure::Content};

#[test]
fn every_table_has_rows_and_every_verdict_is_computed() {
    for table in PAPER.tables {
        let rows = rows(table).unwrap();
        assert!(!rows.is_empty(), "{table}");
        for row in rows {
            assert_eq!((row.paper, row.table), ("IGWO", *table));
            let computed = Verdict::of(&row.published, &row.ours);
            let excused = row.verdict == Verdict::NotComparable && !row.note.is_empty();
            assert!(row.verdict == computed || excused, "{row:?}");
        }
    }
    assert!(rows("XI").unwrap().is_empty());
}

#[test]
fn on_the_lots_astar_igwo_is_sooner_and_shorter_than_gwo() {
    let rows = rows("VIII").unwrap();
    assert_eq!(rows.len(), 2);
    for row in rows {
        assert!(matches!(row.ours, Value::Number(percent) if percent < 0.0), "{row:?}");
    }
}

#[test]
fn paths_are_drawn_on_the_lots_in_every_size_and_lead_from_s_to_t() {
    let figures = figures().unwrap();
    let names: BTreeSet<_> = figures.iter().map(|figure| &figure.name).collect();
    assert_eq!(names.len(), figures.len(), "two figures have one name");
    let mut widths = BTreeSet::new();
    for figure in &figures {
        let Content::Map { grid, lines, marks, .. } = &figure.content else { continue };
        widths.insert(grid.width());
        for line in lines {
            let ends = [line.points.first(), line.points.last()];
            assert_eq!(ends, [Some(&marks[0].at), Some(&marks[1].at)], "{}: {}", figure.name, line.label);
        }
    }
    assert_eq!(widths, BTreeSet::from([12, 15, 30, 60]));
}
