//! What voltage, current and temperature allow.

/// What a pile may give, and what its sensors can measure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// The highest voltage at the contacts, in volts. The power stage's own end-of-charge voltage
    /// lies below it.
    pub voltage_max_v: f32,
    /// The highest current, in amperes.
    pub current_max_a: f32,
    /// From this contact temperature on less current is given, in degrees Celsius.
    pub derate_from_c: f32,
    /// At this contact temperature none is given, in degrees Celsius.
    pub stop_at_c: f32,
    /// The voltage sensor measures from minus this to this, in volts; at either end it is railed.
    pub voltage_range_v: f32,
    /// The current sensor measures from minus this to this, in amperes; at either end it is railed.
    pub current_range_a: f32,
}

impl Limits {
    /// Of a pile for 24 V batteries that gives `power_w` also to an empty one.
    #[must_use]
    pub const fn new(power_w: f32) -> Self {
        let current_max_a = power_w / 20.0;
        Self {
            voltage_max_v: 30.0,
            current_max_a,
            derate_from_c: 60.0,
            stop_at_c: 80.0,
            voltage_range_v: 60.0,
            current_range_a: 2.0 * current_max_a,
        }
    }

    /// A robot whose battery shows less than this, in volts, is not charged: it is of another kind,
    /// deeply discharged or not there.
    #[must_use]
    pub const fn voltage_min_v(&self) -> f32 {
        0.5 * self.voltage_max_v
    }

    /// From this voltage on, in volts, the power stage may be holding the voltage and give as little
    /// current as the battery takes.
    #[must_use]
    pub const fn full_from_v(&self) -> f32 {
        0.9 * self.voltage_max_v
    }

    /// A current beyond this, in amperes, is an over-current.
    #[must_use]
    pub const fn over_current_a(&self) -> f32 {
        1.1 * self.current_max_a
    }

    /// How far the current may be above what the power stage was told, in amperes.
    #[must_use]
    pub const fn tolerance_a(&self) -> f32 {
        0.1 * self.current_max_a
    }

    /// A current below this, in amperes, is none: the sensor's offset.
    #[must_use]
    pub const fn zero_a(&self) -> f32 {
        0.02 * self.current_max_a
    }

    /// The highest current, in amperes, for a pile of `power_w` at this voltage and contact
    /// temperature. Temperature takes all of it away between `derate_from_c` and `stop_at_c`, in
    /// proportion. Nonsense gives nothing.
    #[must_use]
    pub fn current_a(&self, power_w: f32, voltage_v: f32, contact_c: f32) -> f32 {
        let by_power_a = power_w / voltage_v;
        let share = (self.stop_at_c - contact_c) / (self.stop_at_c - self.derate_from_c);
        // No comparison holds for NaN.
        let is_cool = contact_c < self.stop_at_c && share > 0.0;
        let is_sound = by_power_a.is_finite() && self.current_max_a.is_finite();
        if is_cool && is_sound { (self.current_max_a.min(by_power_a) * share.min(1.0)).max(0.0) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn temperature_takes_the_current_away_in_proportion() {
        let limits = Limits::new(500.0);
        let currents =
            [20.0, 60.0, 70.0, 79.0, 80.0, 90.0].map(|contact_c| limits.current_a(500.0, 25.0, contact_c));
        assert_eq!(currents, [20.0, 20.0, 10.0, 1.0, 0.0, 0.0]);
    }

    #[test]
    fn an_empty_battery_gets_the_highest_current_and_a_fuller_one_the_power() {
        let limits = Limits::new(500.0);
        assert_eq!(
            [15.0, 20.0, 25.0].map(|voltage_v| limits.current_a(500.0, voltage_v, 20.0)),
            [25.0, 25.0, 20.0]
        );
    }

    proptest! {
        #[test]
        fn the_current_is_never_beyond_the_limit_and_never_nonsense(
            power_w: f32, voltage_v: f32, contact_c: f32, derate_from_c: f32, stop_at_c: f32, current_max_a: f32,
        ) {
            let limits = Limits { derate_from_c, stop_at_c, current_max_a, ..Limits::new(500.0) };
            let current_a = limits.current_a(power_w, voltage_v, contact_c);
            prop_assert!(current_a >= 0.0 && current_a.is_finite());
            prop_assert!(current_a == 0.0 || current_a <= current_max_a);
        }

        #[test]
        fn a_hotter_contact_never_gets_more(cooler_c in -40.0f32..120.0, hotter_c in -40.0f32..120.0) {
            let limits = Limits::new(500.0);
            let current_a = |contact_c| limits.current_a(500.0, 25.0, contact_c);
            prop_assert!(current_a(cooler_c.max(hotter_c)) <= current_a(cooler_c.min(hotter_c)));
        }
    }
}
