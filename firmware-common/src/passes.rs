//! How often robots pass piles, by tag and period of the day (LMPP eqs. 4, 5 and 8).
//!
//! The paper puts the reader on the robot and the tag on the pile. A pile needs a reader anyway, to
//! know whom it charges, and so counts the robots that pass it; a robot with a reader counts the
//! piles it passes. The counts are the same.
//!
//! The paper counts a sample every tau, so that a robot parked in the field counts as thousands of
//! passes ([`PassRule::PerSample`]). By default an approach counts once, however long it lasts
//! ([`PassRule::PerApproach`]).
//!
//! Memory is bounded. When [`MAX_COUNTS`] pairs of tag and period wait for their report, a pass
//! of a tag that has a count is added to that count though the period is another, and a pass of
//! any other tag goes to [`PassCounter::unattributed`]: nothing is overwritten, nothing vanishes
//! silently. More than [`MAX_NEAR`] tags at a time may be counted more than once an approach.

use heapless::Vec;
use protocol::{DurationMs, Millis, PassCount, PendingPass, SiteMillis, TagId, limits};

use crate::presence::{Presence, RssiBand};

/// Tags whose approaches are told apart at a time.
pub const MAX_NEAR: usize = 16;
/// Pairs of tag and period that can wait for their report.
pub const MAX_COUNTS: usize = 64;

/// The usual dwell of an approach: read at two polls of the reader in a row.
pub const DWELL: DurationMs = DurationMs(150);

/// What a pass is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PassRule {
    /// Every read, as the paper has it (eq. 4).
    PerSample,
    /// An approach: a tag enters `band`, dwells there for `dwell`, and has left it when it was not
    /// read there for `gap`.
    PerApproach {
        /// The signal strengths at which a tag has come near and gone.
        band: RssiBand,
        /// How long after its first read a tag must be read again. One read alone is no approach: it
        /// may have come by a reflection from afar.
        dwell: DurationMs,
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
            PassRule::PerApproach { band, dwell, gap } => Some(Presence::new(band, gap).dwelling(dwell)),
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

    /// What [`Self::take`] would take once the period is known, the oldest first.
    pub fn pending(&self) -> impl Iterator<Item = PendingPass> {
        self.counts.iter().map(|&Count { tag, period, passes }| PendingPass { tag, period, passes })
    }

    /// Passes that were counted for no tag because the table was full.
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const BAND: RssiBand = RssiBand { enter_dbm: -70, leave_dbm: -76 };
    const PER_APPROACH: PassRule =
        PassRule::PerApproach { band: BAND, dwell: DurationMs(300), gap: DurationMs(3_000) };
    const HOUR: u64 = 3_600_000;

    fn tag(number: u16) -> TagId {
        let [high, low] = number.to_be_bytes();
        TagId([0, 0, 0, 0, 0, 0, 0, 0, 0, 0, high, low])
    }

    /// All that was counted, report by report.
    fn taken(counter: &mut PassCounter) -> std::vec::Vec<PassCount> {
        let reports = core::iter::from_fn(|| Some(counter.take(Some(0))).filter(|report| !report.is_empty()));
        reports.flatten().collect()
    }

    fn total(counter: &mut PassCounter) -> u32 {
        taken(counter).iter().map(|count| count.passes).sum()
    }

    #[test]
    fn a_parked_robot_passes_once_but_gives_a_sample_a_read() {
        for (rule, passes) in [(PER_APPROACH, 1), (PassRule::PerSample, 1_000)] {
            let mut counter = PassCounter::new(rule);
            (0..1_000).for_each(|read| counter.read(Millis(read * 100), Some(0), tag(1), -60));
            assert_eq!(total(&mut counter), passes, "{rule:?}");
        }
    }

    #[test]
    fn flutter_at_the_fields_edge_is_one_approach() {
        let mut counter = PassCounter::new(PER_APPROACH);
        for read in 0..200 {
            let rssi_dbm = if read % 2 == 0 { -70 } else { -78 };
            counter.read(Millis(read * 500), Some(0), tag(1), rssi_dbm);
        }
        assert_eq!(total(&mut counter), 1);
    }

    #[test]
    fn a_robot_that_was_away_for_the_gap_passes_again() {
        let mut counter = PassCounter::new(PER_APPROACH);
        for now in [0, 2_999, 5_999, 8_998] {
            counter.read(Millis(now), Some(0), tag(1), -60);
        }
        // 5999 is exactly the gap after 2999.
        assert_eq!(total(&mut counter), 2);
    }

    #[test]
    fn a_tag_that_was_read_but_once_has_not_passed() {
        let mut counter = PassCounter::new(PER_APPROACH);
        (0..10).for_each(|read| counter.read(Millis(read * 10_000), Some(0), tag(1), -60));
        assert_eq!(total(&mut counter), 0);
    }

    #[test]
    fn robots_and_periods_are_counted_apart() {
        let mut counter = PassCounter::new(PassRule::PerSample);
        for (robot, period) in [(1, 0), (2, 0), (1, 1), (1, 1)] {
            counter.read(Millis(0), Some(period), tag(robot), -60);
        }
        let count = |robot, period, passes| PassCount { tag: tag(robot), period, passes };
        assert_eq!(taken(&mut counter), [count(1, 0, 1), count(2, 0, 1), count(1, 1, 2)]);
    }

    #[test]
    fn passes_before_the_time_is_known_wait_for_it() {
        let mut counter = PassCounter::new(PassRule::PerSample);
        counter.read(Millis(0), None, tag(1), -60);
        assert!(counter.take(None).is_empty());
        assert_eq!(counter.take(Some(5)).as_slice(), [PassCount { tag: tag(1), period: 5, passes: 1 }]);
    }

    #[test]
    fn a_full_table_still_counts_every_pass() {
        let mut counter = PassCounter::new(PassRule::PerSample);
        (0..100).for_each(|robot| counter.read(Millis(0), Some(0), tag(robot), -60));
        (0..100).for_each(|robot| counter.read(Millis(0), Some(1), tag(robot), -60));
        assert_eq!(counter.unattributed(), 72);
        assert_eq!(total(&mut counter), 128);
    }

    #[test]
    fn periods_are_floored_and_wrap_at_midnight() {
        let two_hours = DurationMs(7_200_000);
        let hours = [0, 1, 2, 3, 23, 24, 26].map(|hour| period_of(SiteMillis(hour * HOUR), two_hours, 12));
        assert_eq!(hours, [0, 0, 1, 1, 11, 0, 1]);
        assert_eq!(period_of(SiteMillis(2 * HOUR - 1), two_hours, 12), 0);
        assert_eq!(period_of(SiteMillis(HOUR), DurationMs(0), 12), 0);
        assert_eq!(period_of(SiteMillis(HOUR), two_hours, 0), 0);
    }

    proptest! {
        #[test]
        fn however_a_robot_jitters_an_approach_counts_once(
            stay in prop::collection::vec((1u64..3_000, -90i8..-40), 1..300),
        ) {
            let mut counter = PassCounter::new(PER_APPROACH);
            let mut now = 0;
            for (approach, pause) in [(1, 0), (2, 3_000)] {
                now += pause;
                // It comes, stays, as strong or weak as it likes, and is heard well at the latest just
                // before the gap is over.
                (0..3).for_each(|read| counter.read(Millis(now + read * 200), Some(0), tag(1), -70));
                for &(after, rssi_dbm) in &stay {
                    counter.read(Millis(now + 400 + after / 2), Some(0), tag(1), rssi_dbm);
                    now += after;
                    counter.read(Millis(now + 400), Some(0), tag(1), -76);
                }
                now += 400;
                let mut so_far = counter.clone();
                prop_assert_eq!(total(&mut so_far), approach);
            }
        }

        #[test]
        fn no_pass_is_lost_by_reporting(reads in prop::collection::vec((0u16..80, 0u16..3, prop::bool::ANY), 0..400)) {
            let mut counter = PassCounter::new(PassRule::PerSample);
            let mut reported = 0;
            for &(robot, period, report) in &reads {
                counter.read(Millis(0), Some(period), tag(robot), -60);
                if report {
                    reported += counter.take(Some(0)).iter().map(|count| count.passes).sum::<u32>();
                }
            }
            let unattributed = counter.unattributed();
            prop_assert_eq!(reported + total(&mut counter) + unattributed, u32::try_from(reads.len()).unwrap());
        }
    }
}
