//! Where a robot is wanted after its charge: how often it passes each pile at that time of day.

use protocol::{DurationMs, SiteMillis};

/// The period of the day in which a charge ends that is asked for at `asked` and takes `planned`
/// (LMPP T_j, eq. 8).
///
/// The equation "rounds"; this is the period that contains the instant, wrapped at `periods` a
/// day. 0 if there are no periods or they last no time.
#[must_use]
pub fn period(asked: SiteMillis, planned: DurationMs, length: DurationMs, periods: u16) -> u16 {
    let passed = asked.after(planned).0.checked_div(length.0.into()).unwrap_or(0);
    let wrapped = passed.checked_rem(periods.into()).unwrap_or(0);
    // Below `periods`, which is a u16.
    u16::try_from(wrapped).unwrap_or(0)
}

/// The share of one pile's passes in those of all piles (LMPP p, eq. 5), 0 where nothing passed
/// anywhere.
#[must_use]
pub fn frequency(passes: u64, all_passes: u64) -> f64 {
    if all_passes == 0 { 0.0 } else { passes as f64 / all_passes as f64 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOUR: u64 = 3_600_000;

    #[test]
    fn the_period_is_the_one_in_which_the_charge_ends() {
        let two_hours = DurationMs(2 * 3_600_000);
        let at = |asked_h: u64, planned: u32| {
            period(SiteMillis(asked_h * HOUR), DurationMs(planned), two_hours, 12)
        };
        assert_eq!(at(1, 0), 0);
        assert_eq!(at(1, 3_599_999), 0);
        assert_eq!(at(1, 3_600_000), 1);
        assert_eq!(at(23, 0), 11);
        assert_eq!(at(23, 3_600_000), 0, "the day starts again");
    }

    #[test]
    fn no_periods_are_one_period() {
        assert_eq!(period(SiteMillis(5 * HOUR), DurationMs(0), DurationMs(0), 12), 0);
        assert_eq!(period(SiteMillis(5 * HOUR), DurationMs(0), DurationMs(1), 0), 0);
    }

    #[test]
    fn a_robot_that_never_passed_a_pile_prefers_none() {
        assert_eq!(frequency(0, 0), 0.0);
        assert_eq!(frequency(3, 12), 0.25);
    }
}
