//! The site's one clock.

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use protocol::{DurationMs, SiteMillis};

/// Tells the site's time, which in a simulated site may pass faster than time does.
#[derive(Clone, Copy, Debug)]
pub struct SiteClock {
    origin: Instant,
    site_origin: SiteMillis,
    speed: f64,
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
        Self { origin: Instant::now(), site_origin: start, speed }
    }

    /// The site's time.
    #[must_use]
    pub fn now(&self) -> SiteMillis {
        let passed = self.origin.elapsed().as_secs_f64() * 1000.0 * self.speed;
        // `as` saturates.
        SiteMillis(self.site_origin.0.saturating_add(passed as u64))
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
    fn the_real_clock_tells_this_century() {
        assert!(SiteClock::real().now() > SiteMillis(1_700_000_000_000));
    }
}
