//! How often robots pass the pile, by robot and period of the day (LMPP eqs. 4, 5 and 8).
//!
//! The paper counts a sample every tau, so that a robot parked in the field counts as thousands of
//! passes ([`PassRule::PerSample`]). By default an approach counts once, however long it lasts
//! ([`PassRule::PerApproach`]).
//!
//! Memory is bounded. When [`MAX_COUNTS`] pairs of robot and period wait for their report, a pass
//! of a robot that has a count is added to that count though the period is another, and a pass of
//! any other robot goes to [`PassCounter::unattributed`]: nothing is overwritten, nothing vanishes
//! silently. More than [`MAX_NEAR`] robots at a time may be counted more than once an approach.

use heapless::Vec;
use protocol::{DurationMs, Millis, PassCount, SiteMillis, TagId, limits};

use crate::presence::{Presence, RssiBand};

/// Robots whose approaches are told apart at a time.
pub const MAX_NEAR: usize = 16;
/// Pairs of robot and period that can wait for their report.
pub const MAX_COUNTS: usize = 64;

/// What a pass is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PassRule {
    /// Every read, as the paper has it (eq. 4).
    PerSample,
    /// An approach: a tag enters `band` and has left it when it was not read there for `gap`.
    PerApproach {
        /// The signal strengths at which a tag has come near and gone.
        band: RssiBand,
        /// How long a tag must be away before it can approach again.
        gap: DurationMs,
    },
}

/// The period T_j of the day that contains `at` (LMPP eq. 8): whole periods since the site's
/// midnight, wrapped after `periods` of them. 0 if `period` or `periods` is 0.
#[must_use]
pub fn period_of(at: SiteMillis, period: DurationMs, periods: u16) -> u16 {
    let index = at.0.checked_div(u64::from(period.0)).and_then(|whole| whole.checked_rem(u64::from(periods)));
    // It fits: the remainder is below `periods`.
    index.and_then(|index| u16::try_from(index).ok()).unwrap_or(0)
}

#[derive(Clone, Copy, Debug)]
struct Count {
    tag: TagId,
    /// `None` until the site's time is known.
    period: Option<u16>,
    passes: u32,
}

/// The passes since the last report (the additions to K).
#[derive(Clone, Debug)]
pub struct PassCounter {
    /// `None` counts every sample.
    near: Option<Presence<MAX_NEAR>>,
    counts: Vec<Count, MAX_COUNTS>,
    unattributed: u32,
}

impl PassCounter {
    /// Nobody has passed.
    #[must_use]
    pub const fn new(rule: PassRule) -> Self {
        let near = match rule {
            PassRule::PerSample => None,
            PassRule::PerApproach { band, gap } => Some(Presence::new(band, gap)),
        };
        Self { near, counts: Vec::new(), unattributed: 0 }
    }

    /// A tag was read in `period` of the day. Passes before the period is known count for the
    /// first that is.
    pub fn read(&mut self, now: Millis, period: Option<u16>, tag: TagId, rssi_dbm: i8) {
        if self.near.as_mut().is_none_or(|near| near.read(now, tag, rssi_dbm)) {
            self.count(tag, period);
        }
    }

    /// Takes as many counts as fit a report, the oldest first, once the period is known.
    pub fn take(&mut self, period: Option<u16>) -> Vec<PassCount, { limits::PASSES_PER_REPORT }> {
        let mut report = Vec::new();
        self.counts.retain(|count| {
            let Some(period) = count.period.or(period) else { return true };
            report.push(PassCount { tag: count.tag, period, passes: count.passes }).is_err()
        });
        report
    }

    /// Passes that were counted for no robot because the table was full.
    #[must_use]
    pub const fn unattributed(&self) -> u32 {
        self.unattributed
    }

    fn count(&mut self, tag: TagId, period: Option<u16>) {
        let same = |count: &Count| count.tag == tag && count.period == period;
        let index = self.counts.iter().position(same).or_else(|| {
            self.counts.is_full().then(|| self.counts.iter().rposition(|count| count.tag == tag)).flatten()
        });
        if let Some(count) = index.and_then(|index| self.counts.get_mut(index)) {
            count.passes = count.passes.saturating_add(1);
        } else if self.counts.push(Count { tag, period, passes: 1 }).is_err() {
            self.unattributed = self.unattributed.saturating_add(1);
        }
    }
}
