//! The site's time, learned from the coordinator.
//!
//! A board has a monotonic clock of its own and asks the coordinator for the difference to the
//! site's. Once learned, the difference is kept until the next answer: a crystal drifts seconds in
//! a day, leases last minutes.

use protocol::{DurationMs, Millis, SiteMillis, TimeRequest, TimeSync};

/// How often the time is asked for once it is known.
pub const INTERVAL: DurationMs = DurationMs(60_000);
/// An answer that took longer says too little.
pub const LONGEST_ROUND_TRIP: DurationMs = DurationMs(2_000);

/// The site's time as a difference to the board's own clock.
#[derive(Clone, Debug, Default)]
pub struct SiteClock {
    /// Site time minus own time, in milliseconds.
    offset_ms: Option<i64>,
    asked_at: Option<Millis>,
    answered: bool,
}

impl SiteClock {
    /// A clock that knows nothing.
    #[must_use]
    pub const fn new() -> Self {
        Self { offset_ms: None, asked_at: None, answered: false }
    }

    /// The site's time, once it is known.
    #[must_use]
    pub fn site_now(&self, now: Millis) -> Option<SiteMillis> {
        self.offset_ms.map(|offset| SiteMillis(now.0.saturating_add_signed(offset)))
    }

    /// The question to send now, if one is due: every [`INTERVAL`], but as soon as the last is
    /// beyond an answer if it got none or the caller is `eager`.
    pub fn request(&mut self, now: Millis, eager: bool) -> Option<TimeRequest> {
        let interval = if self.answered && !eager { INTERVAL } else { LONGEST_ROUND_TRIP };
        if self.asked_at.is_some_and(|asked_at| now.since(asked_at) < interval) {
            return None;
        }
        self.asked_at = Some(now);
        self.answered = false;
        Some(TimeRequest { asked_at: now })
    }

    /// The other side has said Hello: a question that is still open was asked before it could believe
    /// it, and is to be asked again at once.
    pub const fn ask_again(&mut self) {
        if !self.answered {
            self.asked_at = None;
        }
    }

    /// Takes an answer, if it is one to the last question and quick enough. The coordinator is
    /// taken to have read its clock half way through the round trip.
    pub fn accept(&mut self, now: Millis, sync: &TimeSync) {
        let round_trip = now.since(sync.asked_at);
        if self.answered || self.asked_at != Some(sync.asked_at) || round_trip > LONGEST_ROUND_TRIP {
            return;
        }
        let site_now = sync.site_now.after(DurationMs(round_trip.0 / 2));
        let difference = i128::from(site_now.0) - i128::from(now.0);
        self.offset_ms = i64::try_from(difference).ok();
        self.answered = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sync(asked_at: u64, site_now: u64) -> TimeSync {
        TimeSync { asked_at: Millis(asked_at), site_now: SiteMillis(site_now) }
    }

    #[test]
    fn a_question_from_before_a_hello_is_asked_again_at_once_and_an_answered_one_is_not() {
        let mut clock = SiteClock::new();
        assert!(clock.request(Millis(0), false).is_some());
        assert_eq!(clock.request(Millis(10), false), None);
        clock.ask_again();
        assert!(clock.request(Millis(20), false).is_some());
        clock.accept(Millis(30), &sync(20, 1_000));
        clock.ask_again();
        assert_eq!(clock.request(Millis(40), false), None);
    }

    #[test]
    fn the_answer_counts_from_the_middle_of_the_round_trip() {
        let mut clock = SiteClock::new();
        assert_eq!(clock.site_now(Millis(1_000)), None);
        assert!(clock.request(Millis(1_000), false).is_some());
        clock.accept(Millis(1_400), &sync(1_000, 500_000));
        assert_eq!(clock.site_now(Millis(1_400)), Some(SiteMillis(500_200)));
        assert_eq!(clock.site_now(Millis(2_400)), Some(SiteMillis(501_200)));
    }

    #[test]
    fn a_site_younger_than_the_board_is_known_too() {
        let mut clock = SiteClock::new();
        assert!(clock.request(Millis(90_000), false).is_some());
        clock.accept(Millis(90_000), &sync(90_000, 10));
        assert_eq!(clock.site_now(Millis(90_005)), Some(SiteMillis(15)));
        assert_eq!(clock.site_now(Millis(0)), Some(SiteMillis(0)));
    }

    #[test]
    fn answers_that_are_slow_repeated_or_to_another_question_are_ignored() {
        let mut clock = SiteClock::new();
        assert!(clock.request(Millis(1_000), false).is_some());
        clock.accept(Millis(1_001), &sync(999, 500_000));
        clock.accept(Millis(3_001), &sync(1_000, 500_000));
        assert_eq!(clock.site_now(Millis(3_001)), None);
        assert!(clock.request(Millis(3_100), false).is_some());
        clock.accept(Millis(3_100), &sync(3_100, 700_000));
        clock.accept(Millis(3_200), &sync(3_100, 900_000));
        assert_eq!(clock.site_now(Millis(3_200)), Some(SiteMillis(700_100)));
    }

    #[test]
    fn the_time_is_asked_for_until_known_and_then_once_a_minute() {
        let mut clock = SiteClock::new();
        let asked = |clock: &mut SiteClock, from: u64, to: u64, eager| {
            (from..to).step_by(100).filter(|&now| clock.request(Millis(now), eager).is_some()).count()
        };
        assert_eq!(asked(&mut clock, 0, 10_000, false), 5);
        clock.accept(Millis(9_000), &sync(8_000, 1));
        assert_eq!(asked(&mut clock, 10_000, 68_000, false), 0);
        assert_eq!(asked(&mut clock, 68_000, 68_100, false), 1);
        clock.accept(Millis(68_100), &sync(68_000, 60_000));
        assert_eq!(asked(&mut clock, 70_000, 80_000, true), 5);
    }
}
