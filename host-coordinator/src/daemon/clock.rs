//! The site's one clock.

use std::{
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
    time::{Duration, Instant, SystemTime, UNIX_EPOCH},
};

use protocol::{DurationMs, SiteMillis};

/// Tells the site's time, which in a simulated site may pass faster than time does.
#[derive(Clone, Debug)]
pub struct SiteClock {
    source: Source,
    speed: f64,
}

#[derive(Clone, Debug)]
enum Source {
    /// Runs by itself.
    Steady { origin: Instant, site_origin: SiteMillis },
    /// Is moved by a [`ClockHand`].
    Moved(Arc<AtomicU64>),
}

/// Moves a clock that does not run by itself.
#[derive(Debug)]
pub struct ClockHand(Arc<AtomicU64>);

impl ClockHand {
    /// Moves the clock forward to `now`; it never goes back.
    pub fn set(&self, now: SiteMillis) {
        self.0.fetch_max(now.0, Ordering::Relaxed);
    }
}

impl SiteClock {
    /// The real time, in milliseconds since 1970 UTC. It runs on a steady clock from now on, so
    /// that a correction of the computer's clock moves no expiry.
    #[must_use]
    pub fn real() -> Self {
        let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let millis = u64::try_from(since_1970.as_millis()).unwrap_or(u64::MAX);
        Self::simulated(SiteMillis(millis), 1.0)
    }

    /// A time that begins at `start` now and passes `speed` times as fast as time does; `speed` is
    /// more than 0.
    #[must_use]
    pub fn simulated(start: SiteMillis, speed: f64) -> Self {
        Self { source: Source::Steady { origin: Instant::now(), site_origin: start }, speed }
    }

    /// A time that stands at `start` until the hand moves it, which should be about `speed` times
    /// as fast as time passes; `speed` is more than 0. A simulation that cannot keep up lets its
    /// time stand still, where a clock that runs by itself would make everyone late.
    #[must_use]
    pub fn moved_by_hand(start: SiteMillis, speed: f64) -> (Self, ClockHand) {
        let now = Arc::new(AtomicU64::new(start.0));
        (Self { source: Source::Moved(Arc::clone(&now)), speed }, ClockHand(now))
    }

    /// The site's time.
    #[must_use]
    pub fn now(&self) -> SiteMillis {
        match &self.source {
            Source::Steady { origin, site_origin } => {
                let passed = origin.elapsed().as_secs_f64() * 1000.0 * self.speed;
                // `as` saturates.
                SiteMillis(site_origin.0.saturating_add(passed as u64))
            }
            Source::Moved(now) => SiteMillis(now.load(Ordering::Relaxed)),
        }
    }

    /// How long a time of the site really takes.
    #[must_use]
    pub fn really(&self, duration: DurationMs) -> Duration {
        let seconds = f64::from(duration.0) / 1000.0 / self.speed;
        Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fast_clock_makes_waiting_short() {
        let clock = SiteClock::simulated(SiteMillis(5_000), 20.0);
        assert!(clock.now() >= SiteMillis(5_000));
        assert_eq!(clock.really(DurationMs(1_000)), Duration::from_millis(50));
    }

    #[test]
    fn a_moved_clock_stands_still_between_moves_and_never_goes_back() {
        let (clock, hand) = SiteClock::moved_by_hand(SiteMillis(5_000), 200.0);
        assert_eq!(clock.now(), SiteMillis(5_000));
        hand.set(SiteMillis(6_000));
        hand.set(SiteMillis(5_500));
        assert_eq!(clock.clone().now(), SiteMillis(6_000));
        assert_eq!(clock.really(DurationMs(1_000)), Duration::from_millis(5));
    }

    #[test]
    fn the_real_clock_tells_this_century() {
        assert!(SiteClock::real().now() > SiteMillis(1_700_000_000_000));
    }
}
