//! Lengths of time as people write them on the command line.

use std::str::FromStr;

use protocol::DurationMs;

/// A length of time such as `90s`, `30m` or `2h`; more than 0, up to 30 days.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimeSpan(pub DurationMs);

/// The text is no length of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("write a number and a unit such as 90s, 30m or 2h, more than 0 and up to 720h")]
pub struct NotATime;

impl FromStr for TimeSpan {
    type Err = NotATime;

    fn from_str(text: &str) -> Result<Self, NotATime> {
        let unit = text.chars().next_back().ok_or(NotATime)?;
        let seconds = match unit {
            's' => 1.0,
            'm' => 60.0,
            'h' => 3_600.0,
            _ => return Err(NotATime),
        };
        let number: f64 = text.strip_suffix(unit).and_then(|number| number.parse().ok()).ok_or(NotATime)?;
        let millis = (number * seconds * 1_000.0).round();
        if (1.0..=f64::from(DurationMs::MAX.0)).contains(&millis) {
            Ok(Self(DurationMs(millis as u32)))
        } else {
            Err(NotATime)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_minutes_and_hours_are_read() {
        for (text, millis) in [("90s", 90_000), ("30m", 1_800_000), ("2h", 7_200_000), ("1.5m", 90_000)] {
            assert_eq!(text.parse(), Ok(TimeSpan(DurationMs(millis))), "{text}");
        }
    }

    #[test]
    fn anything_else_is_refused() {
        for text in ["", "s", "30", "30 minutes", "-1s", "0h", "nans", "infh", "721h", "1d", "1é"] {
            assert_eq!(text.parse::<TimeSpan>(), Err(NotATime), "{text}");
        }
    }
}
