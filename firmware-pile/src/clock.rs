//! The site's time, learned from the coordinator.
//!
//! A pile has a monotonic clock of its own and asks the coordinator for the difference to the
//! site's. Once learned, the difference is kept until the next answer: a crystal drifts seconds in
//! a day, leases last minutes.

use protocol::{DurationMs, Millis, SiteMillis, TimeRequest, TimeSync, limits};

/// How often the time is asked for once it is known.
pub const INTERVAL: DurationMs = DurationMs(60_000);
/// An answer that took longer says too little.
pub const LONGEST_ROUND_TRIP: DurationMs = DurationMs(2_000);

/// The site's time as a difference to the pile's own clock.
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

    /// The question to send now, if one is due: every [`limits::REPEAT_INTERVAL`] until it is
    /// answered, then every [`INTERVAL`], or sooner if the caller is `eager`.
    pub fn request(&mut self, now: Millis, eager: bool) -> Option<TimeRequest> {
        let interval = if self.answered && !eager { INTERVAL } else { limits::REPEAT_INTERVAL };
        if self.asked_at.is_some_and(|asked_at| now.since(asked_at) < interval) {
            return None;
        }
        self.asked_at = Some(now);
        self.answered = false;
        Some(TimeRequest { asked_at: now })
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
