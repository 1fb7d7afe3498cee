//! What all piles said of themselves: the table Q (LMPP Figs. 1 to 3).
//!
//! The paper stamps the whole table and so loses one of two changes that cross. Here every row has
//! its own age, `(boot, version)`, and merging keeps the newer of two rows of a pile. Merging is
//! therefore commutative, associative and idempotent: rows may arrive in any order, any number of
//! times, by any way, and all piles end up with the same table. How old a row may be before its
//! pile counts as unknown is for the reader of the table to say.

use core::cmp::Ordering;

use heapless::Vec;
use protocol::{BootEpoch, DurationMs, Millis, PileId, PileRow, limits};

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

/// How often a part of the table is sent even if nothing has changed.
pub const GOSSIP_INTERVAL: DurationMs = DurationMs(5_000);

/// Chooses which part of the table is sent when: the pile's own row with every part, at once when
/// it has changed; the others in turn.
#[derive(Clone, Debug, Default)]
pub struct Gossip {
    told: Option<(Millis, BootEpoch, u32)>,
    last_pile: Option<PileId>,
}

impl Gossip {
    /// Nothing was sent yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { told: None, last_pile: None }
    }

    /// The part to send now, if one is due.
    pub fn part(&mut self, now: Millis, own: &PileRow, table: &PileTable) -> Option<protocol::PileTable> {
        if let Some((at, boot, version)) = self.told
            && (boot, version) == (own.boot, own.version)
            && now.since(at) < GOSSIP_INTERVAL
        {
            return None;
        }
        self.told = Some((now, own.boot, own.version));

        let mut rows = Vec::<PileRow, { limits::ROWS_PER_TABLE }>::new();
        // It fits: the part is empty.
        let _ = rows.push(*own);
        let others = || table.rows().iter().filter(|row| row.pile != own.pile);
        let after = others().filter(|row| Some(row.pile) > self.last_pile);
        let before = others().filter(|row| Some(row.pile) <= self.last_pile);
        let room = rows.capacity() - rows.len();
        let mut last_pile = self.last_pile;
        for row in after.chain(before).take(room) {
            last_pile = Some(row.pile);
            let _ = rows.push(*row);
        }
        self.last_pile = last_pile;
        Some(protocol::PileTable { rows })
    }
}
