//! Physical quantities and times.
//!
//! A quantity outside its range cannot be built, and so cannot be decoded: NaN, infinities and
//! nonsense from a wire are errors, never states. Times are plain numbers to calculate with; one
//! beyond its range, such as a "never", is sent as the largest, so that what is sent can be read.

use core::fmt;

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use crate::max_size::{MaxSize, varint};

/// A number that is no value of its quantity.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{quantity} must be a number from {min} to {max}, not {value}")]
pub struct OutOfRange {
    /// The quantity with its unit.
    pub quantity: &'static str,
    /// The number that was given.
    pub value: f64,
    /// The smallest value allowed.
    pub min: f64,
    /// The largest value allowed.
    pub max: f64,
}

macro_rules! quantities {
    ($($(#[$doc:meta])* $name:ident, $min:literal..=$max:literal, $label:literal;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd, Serialize)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        #[serde(transparent)]
        pub struct $name(f32);

        impl $name {
            /// The smallest value.
            pub const MIN: Self = Self($min);
            /// The largest value.
            pub const MAX: Self = Self($max);

            /// Takes `value` if it is finite and in range.
            ///
            /// # Errors
            /// [`OutOfRange`] otherwise.
            pub fn new(value: f32) -> Result<Self, OutOfRange> {
                if ($min..=$max).contains(&value) {
                    Ok(Self(value))
                } else {
                    Err(OutOfRange { quantity: $label, value: value.into(), min: $min, max: $max })
                }
            }

            /// The nearest value in range; NaN becomes the smallest.
            #[must_use]
            pub fn clamped(value: f32) -> Self {
                // Comparisons: `max` and `min` are calls on a core without them.
                Self(if value > $min { if value < $max { value } else { $max } } else { $min })
            }

            /// The bare number.
            #[must_use]
            pub const fn get(self) -> f32 {
                self.0
            }
        }

        impl MaxSize for $name {
            const MAX_SIZE: usize = f32::MAX_SIZE;
        }

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                Self::new(f32::deserialize(deserializer)?).map_err(de::Error::custom)
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.0.fmt(f)
            }
        }
    )*};
}

quantities! {
    /// Energy in joules.
    EnergyJ, 0.0..=1.0e9, "an energy in joules";
    /// A share of a whole, 0 to 1; LMPP's q (eq. 1) and every probability.
    Fraction, 0.0..=1.0, "a fraction";
    /// A coordinate in metres, of the site's map or from where a chassis started.
    CoordinateM, -1.0e5..=1.0e5, "a coordinate in metres";
    /// A speed in metres per second; the sign is the direction.
    SpeedMps, -10.0..=10.0, "a speed in metres per second";
    /// A turn rate in radians per second, counter-clockwise.
    TurnRateRadps, -100.0..=100.0, "a turn rate in radians per second";
    /// An angle in radians, counter-clockwise, from -pi to pi; the range is rounded outwards.
    AngleRad, -3.2..=3.2, "an angle in radians";
    /// A variance or covariance, in the product of its two quantities' units.
    Covariance, -1.0e8..=1.0e8, "a covariance";
    /// A voltage in volts.
    VoltageV, 0.0..=100.0, "a voltage in volts";
    /// A power in watts.
    PowerW, 0.0..=1.0e5, "a power in watts";
    /// A temperature in degrees Celsius.
    TemperatureC, -60.0..=200.0, "a temperature in degrees Celsius";
    /// A current in amperes; negative flows into the battery.
    CurrentA, -100.0..=100.0, "a current in amperes";
}

/// How important a robot's task is (Access Table 1's T_p), 0 to 10; the more the sooner it gets a pile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(transparent)]
pub struct TaskPriority(u8);

impl TaskPriority {
    /// The least important.
    pub const MIN: Self = Self(0);
    /// Of a task of which nothing is known: Access Table 1's "others".
    pub const USUAL: Self = Self(5);
    /// The most important.
    pub const MAX: Self = Self(10);

    /// Takes `value` if it is in range.
    ///
    /// # Errors
    /// [`OutOfRange`] otherwise.
    pub fn new(value: u8) -> Result<Self, OutOfRange> {
        if value <= Self::MAX.0 {
            Ok(Self(value))
        } else {
            Err(OutOfRange { quantity: "a task's priority", value: value.into(), min: 0.0, max: 10.0 })
        }
    }

    /// The bare number.
    #[must_use]
    pub const fn get(self) -> u8 {
        self.0
    }
}

impl Default for TaskPriority {
    fn default() -> Self {
        Self::USUAL
    }
}

impl MaxSize for TaskPriority {
    const MAX_SIZE: usize = u8::MAX_SIZE;
}

impl<'de> Deserialize<'de> for TaskPriority {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::new(u8::deserialize(deserializer)?).map_err(de::Error::custom)
    }
}

macro_rules! times {
    ($($(#[$doc:meta])* $name:ident($inner:ty), 0..=$max:literal, $label:literal;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        pub struct $name(pub $inner);

        impl $name {
            /// The largest value that goes over a wire.
            pub const MAX: Self = Self($max);
        }

        impl MaxSize for $name {
            const MAX_SIZE: usize = varint($max);
        }

        impl Serialize for $name {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                (*self).min(Self::MAX).0.serialize(serializer)
            }
        }

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let value = <$inner>::deserialize(deserializer)?;
                if value <= $max {
                    Ok(Self(value))
                } else {
                    Err(de::Error::custom(OutOfRange { quantity: $label, value: value as f64, min: 0.0, max: Self::MAX.0 as f64 }))
                }
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.0.fmt(f)
            }
        }
    )*};
}

times! {
    /// Milliseconds since a device started, on its own monotonic clock (up to 100 years).
    Millis(u64), 0..=3_155_760_000_000, "a device time in milliseconds";
    /// Milliseconds of the site's one time, which the coordinator keeps and piles learn by
    /// [`TimeSync`](crate::TimeSync): since 1970 UTC in a real site, since the start in a
    /// simulated one (up to the year 2100).
    SiteMillis(u64), 0..=4_102_444_800_000, "a site time in milliseconds";
    /// A length of time in milliseconds (up to 30 days).
    DurationMs(u32), 0..=2_592_000_000, "a duration in milliseconds";
}

impl Millis {
    /// How long ago `earlier` was; zero if it lies ahead.
    #[must_use]
    pub const fn since(self, earlier: Self) -> DurationMs {
        DurationMs::saturating(self.0.saturating_sub(earlier.0))
    }

    /// The instant `duration` later.
    #[must_use]
    pub const fn after(self, duration: DurationMs) -> Self {
        Self(self.0.saturating_add(duration.0 as u64))
    }
}

impl SiteMillis {
    /// How long ago `earlier` was; zero if it lies ahead.
    #[must_use]
    pub const fn since(self, earlier: Self) -> DurationMs {
        DurationMs::saturating(self.0.saturating_sub(earlier.0))
    }

    /// The instant `duration` later.
    #[must_use]
    pub const fn after(self, duration: DurationMs) -> Self {
        Self(self.0.saturating_add(duration.0 as u64))
    }
}

impl DurationMs {
    /// `millis`, or [`Self::MAX`] if that is longer.
    #[must_use]
    pub const fn saturating(millis: u64) -> Self {
        if millis > Self::MAX.0 as u64 { Self::MAX } else { Self(millis as u32) }
    }

    /// `seconds` as a duration; negative and NaN become zero, too long becomes [`Self::MAX`].
    #[must_use]
    pub fn from_seconds(seconds: f32) -> Self {
        // `as` saturates and takes NaN to zero.
        Self::saturating((seconds * 1000.0) as u64)
    }

    /// The duration in seconds.
    #[must_use]
    pub fn as_seconds(self) -> f32 {
        self.0 as f32 / 1000.0
    }
}
