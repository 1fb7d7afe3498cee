//! What all piles said of themselves: the table Q (LMPP Figs. 1 to 3).
//!
//! The paper stamps the whole table and so loses one of two changes that cross. Here every row has
//! its own age, `(boot, version)`, and merging keeps the newer of two rows of a pile. Merging is
//! therefore commutative, associative and idempotent: rows may arrive in any order, any number of
//! times, by any way, and all piles end up with the same table. How old a row may be before its
//! pile counts as unknown is for the reader of the table to say.

use core::cmp::Ordering;

use heapless::Vec;
use protocol::{PileId, PileRow};

/// The largest number of rows. Of more piles the ones with the lowest numbers are kept, which
/// keeps merging independent of order.
pub const MAX_PILES: usize = 64;

/// The newest row of each pile, ordered by pile.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PileTable {
    rows: Vec<PileRow, MAX_PILES>,
}

impl PileTable {
    /// An empty table.
    #[must_use]
    pub const fn new() -> Self {
        Self { rows: Vec::new() }
    }

    /// The rows, ordered by pile.
    #[must_use]
    pub fn rows(&self) -> &[PileRow] {
        &self.rows
    }

    /// The row of `pile`.
    #[must_use]
    pub fn get(&self, pile: PileId) -> Option<&PileRow> {
        let index = self.rows.binary_search_by_key(&pile, |row| row.pile).ok()?;
        self.rows.get(index)
    }

    /// Takes `row` if it is newer than the one of its pile. Answers whether it was.
    pub fn merge_row(&mut self, row: PileRow) -> bool {
        match self.rows.binary_search_by_key(&row.pile, |known| known.pile) {
            Ok(index) => match self.rows.get_mut(index) {
                Some(known) if age(&row, known).is_gt() => {
                    *known = row;
                    true
                }
                _ => false,
            },
            Err(index) => {
                if self.rows.is_full() && index < self.rows.len() {
                    self.rows.pop();
                }
                self.rows.insert(index, row).is_ok()
            }
        }
    }

    /// Takes every newer row of `other`.
    pub fn merge(&mut self, other: &Self) {
        for &row in other.rows() {
            self.merge_row(row);
        }
    }
}

/// Which of two rows of a pile is newer. A pile never says two things with one `(boot, version)`;
/// should someone else do so in its name, the contents decide, so that everybody decides alike.
fn age(a: &PileRow, b: &PileRow) -> Ordering {
    let key = |row: &PileRow| {
        (row.boot, row.version, row.stamp, row.availability, row.remaining.get().to_bits(), row.planned)
    };
    key(a).cmp(&key(b))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use protocol::{Availability, BootEpoch, DurationMs, Fraction, SiteMillis};

    use super::*;

    fn row(pile: u16, boot: u32, version: u32) -> PileRow {
        PileRow {
            pile: PileId(pile),
            boot: BootEpoch(boot),
            version,
            stamp: None,
            availability: Availability::Free,
            remaining: Fraction::MIN,
            planned: DurationMs(0),
        }
    }

    #[test]
    fn a_restarted_pile_is_newer_whatever_its_versions_were() {
        let mut table = PileTable::new();
        assert!(table.merge_row(row(1, 1, 900)));
        assert!(table.merge_row(row(1, 2, 1)));
        assert!(!table.merge_row(row(1, 1, 901)));
        assert_eq!(table.get(PileId(1)), Some(&row(1, 2, 1)));
    }

    /// Rows that collide: few piles, few ages, and contents that contradict each other.
    fn any_row() -> impl Strategy<Value = PileRow> {
        let content = (prop::option::of(0u64..3), 0u8..=2, prop::bool::ANY);
        (0u16..100, 0u32..2, 0u32..3, content).prop_map(|(pile, boot, version, (stamp, share, free))| {
            PileRow {
                stamp: stamp.map(SiteMillis),
                remaining: Fraction::clamped(f32::from(share) / 2.0),
                availability: if free { Availability::Free } else { Availability::Charging },
                ..row(pile, boot, version)
            }
        })
    }

    /// Tables with more rows than fit, too.
    fn any_table() -> impl Strategy<Value = PileTable> {
        prop::collection::vec(any_row(), 0..150).prop_map(|rows| table(&rows))
    }

    fn table(rows: &[PileRow]) -> PileTable {
        let mut table = PileTable::new();
        for row in rows {
            table.merge_row(*row);
        }
        table
    }

    fn merged(mut a: PileTable, b: &PileTable) -> PileTable {
        a.merge(b);
        a
    }

    proptest! {
        #[test]
        fn merging_is_commutative(a in any_table(), b in any_table()) {
            prop_assert_eq!(merged(a.clone(), &b), merged(b, &a));
        }

        #[test]
        fn merging_is_associative(a in any_table(), b in any_table(), c in any_table()) {
            prop_assert_eq!(merged(merged(a.clone(), &b), &c), merged(a, &merged(b, &c)));
        }

        #[test]
        fn merging_is_idempotent(a in any_table(), b in any_table()) {
            let once = merged(a, &b);
            prop_assert_eq!(merged(once.clone(), &b), once);
        }

        #[test]
        fn the_order_of_rows_does_not_matter(
            (rows, shuffled) in prop::collection::vec(any_row(), 0..150)
                .prop_flat_map(|rows| (Just(rows.clone()), Just(rows).prop_shuffle()))
        ) {
            prop_assert_eq!(table(&rows), table(&shuffled));
        }

        #[test]
        fn the_newest_row_of_a_pile_is_kept(rows in prop::collection::vec(any_row(), 1..100)) {
            let table = table(&rows);
            for row in table.rows() {
                let newest = rows.iter().filter(|other| other.pile == row.pile).map(|row| (row.boot, row.version)).max();
                prop_assert_eq!(Some((row.boot, row.version)), newest);
            }
            prop_assert!(table.rows().is_sorted_by_key(|row| row.pile));
        }
    }
}
