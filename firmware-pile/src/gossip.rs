//! Tells the other piles what this one knows of all, a part at a time.

use heapless::Vec;
use protocol::{DurationMs, Millis, PileId, PileRow, limits};

use crate::table::PileTable;

/// How often a part of the table is sent even if nothing has changed.
pub const INTERVAL: DurationMs = DurationMs(5_000);

/// Chooses which part of the table is sent when: the pile's own row with every part, at once when
/// it has changed; the others in turn.
#[derive(Clone, Debug, Default)]
pub struct Gossip {
    told_at: Option<Millis>,
    last_pile: Option<PileId>,
}

impl Gossip {
    /// Nothing was sent yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { told_at: None, last_pile: None }
    }

    /// The part to send now, if the own row has `changed` or [`INTERVAL`] is over.
    pub fn part(
        &mut self,
        now: Millis,
        changed: bool,
        own: PileRow,
        table: &PileTable,
    ) -> Option<protocol::PileTable> {
        let is_due = self.told_at.is_none_or(|told_at| now.since(told_at) >= INTERVAL);
        if !changed && !is_due {
            return None;
        }
        self.told_at = Some(now);

        let others = || table.rows().iter().filter(|row| row.pile != own.pile);
        let after = others().filter(|row| Some(row.pile) > self.last_pile);
        let before = others().filter(|row| Some(row.pile) <= self.last_pile);
        let turn = after.chain(before).take(limits::ROWS_PER_TABLE - 1);
        let rows: Vec<PileRow, { limits::ROWS_PER_TABLE }> = turn.copied().chain([own]).collect();
        if let [.., last, _own] = rows.as_slice() {
            self.last_pile = Some(last.pile);
        }
        Some(protocol::PileTable { rows })
    }
}

#[cfg(test)]
mod tests {
    use protocol::{Availability, BootEpoch, Fraction};

    use super::*;

    fn row(pile: u16) -> PileRow {
        PileRow {
            pile: PileId(pile),
            boot: BootEpoch(1),
            version: 1,
            stamp: None,
            availability: Availability::Free,
            remaining: Fraction::MIN,
            planned: DurationMs(0),
        }
    }

    #[test]
    fn every_row_has_its_turn_and_the_own_row_is_always_there() {
        let mut table = PileTable::new();
        (0..20).for_each(|pile| assert!(table.merge_row(row(pile))));
        let mut gossip = Gossip::new();
        let mut told = std::collections::BTreeSet::new();
        // Nineteen others, seven with each part.
        for turn in 0..3 {
            let now = Millis(turn * u64::from(INTERVAL.0));
            let part = gossip.part(now, false, row(4), &table).expect("a part is due");
            assert!(part.rows.contains(&row(4)));
            told.extend(part.rows.iter().map(|row| row.pile));
        }
        assert_eq!(told.len(), 20);
    }

    #[test]
    fn a_change_is_told_at_once() {
        let mut gossip = Gossip::new();
        let table = PileTable::new();
        assert!(gossip.part(Millis(0), false, row(4), &table).is_some());
        assert!(gossip.part(Millis(100), false, row(4), &table).is_none());
        assert!(gossip.part(Millis(200), true, row(4), &table).is_some());
    }
}
