//! What the voltages at a board's pins mean: the circuits in front of the converter, and behind it.
//!
//! | quantity | circuit | what it covers |
//! |---|---|---|
//! | output voltage | 390 kilo-ohm from the output, 10 kilo-ohm to half the supply | -64.3 to 67.6 V |
//! | output current | shunt of 1 milliohm, amplifier of 20 about half the supply | -82.5 to 82.5 A |
//! | contact temperature | NTC of 10 kilo-ohm (B 3435 K) to ground, 10 kilo-ohm to the supply | -30 to 125 C |
//! | current limit | 20 A for each volt from the board, 0 V is none | 0 to 66 A |
//!
//! A wire that is off, and one that is short, give values that the safety core knows for impossible:
//! the converter's ends lie beyond what the core takes for a value.

/// The supply, which is the converters' reference, in volts.
pub const SUPPLY_V: f32 = 3.3;
/// What a converter of 12 bits says of the supply.
pub const FULL: f32 = 4095.0;

/// From the output to the converter, and from there to half the supply, in ohms.
const DIVIDER_OHM: (f32, f32) = (390.0e3, 10.0e3);
/// The current amplifier's, about half the supply: 1 milliohm times 20.
const VOLTS_PER_AMPERE: f32 = 0.020;
/// The thermistor at [`NTC_K`], and the resistor to the supply, in ohms.
const NTC_OHM: f32 = 10.0e3;
const PULL_UP_OHM: f32 = 10.0e3;
/// 25 degrees Celsius, in kelvins.
const NTC_K: f32 = 298.15;
/// How steep the thermistor is between 25 and 85 degrees Celsius, in kelvins.
const NTC_B_K: f32 = 3435.0;
const ZERO_C_K: f32 = 273.15;
/// What the power stage takes for each volt at its set-point.
const AMPERES_PER_VOLT: f32 = 20.0;

/// The voltage at the contacts, in volts, of a mean of conversions from 0 to [`FULL`].
#[must_use]
pub fn output_v(counts: f32) -> f32 {
    let (above, below) = DIVIDER_OHM;
    let half_v = SUPPLY_V / 2.0;
    half_v + (pin_v(counts) - half_v) * (above + below) / below
}

/// The current into the robot, in amperes, of a mean of conversions from 0 to [`FULL`].
#[must_use]
pub fn output_a(counts: f32) -> f32 {
    (pin_v(counts) - SUPPLY_V / 2.0) / VOLTS_PER_AMPERE
}

/// The temperature of the contacts, in degrees Celsius, of a mean of conversions from 0 to [`FULL`];
/// about absolute zero if the thermistor's wire is off, and no number or one as cold if it is short.
#[must_use]
pub fn contact_c(counts: f32) -> f32 {
    let ratio = counts / FULL;
    let ohm = PULL_UP_OHM * ratio / (1.0 - ratio);
    1.0 / (1.0 / NTC_K + libm::logf(ohm / NTC_OHM) / NTC_B_K) - ZERO_C_K
}

/// The set-point of a current limit in amperes, from 0 to [`FULL`]: never more than the limit, and
/// nothing for nonsense.
#[must_use]
pub fn set_point(current_limit_a: f32) -> u16 {
    let counts = current_limit_a / AMPERES_PER_VOLT * FULL / SUPPLY_V;
    // Rounds down; NaN is 0.
    counts.clamp(0.0, FULL) as u16
}

fn pin_v(counts: f32) -> f32 {
    counts * SUPPLY_V / FULL
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::safety::{Limits, sensors};

    /// What the converter says of a voltage at its pin.
    fn counts(pin_v: f32) -> f32 {
        pin_v / SUPPLY_V * FULL
    }

    fn assert_near(measured: f32, expected: f32, tolerance: f32) {
        assert!((measured - expected).abs() <= tolerance, "{measured} is not {expected}");
    }

    #[test]
    fn the_divider_gives_the_voltage_also_of_a_reversed_battery() {
        for volts in [-60.0, -25.2, 0.0, 25.2, 60.0] {
            // Kirchhoff: the currents into the pin's node add up to nothing.
            let pin_v = (volts / 390.0e3 + 1.65 / 10.0e3) / (1.0 / 390.0e3 + 1.0 / 10.0e3);
            assert_near(output_v(counts(pin_v)), volts, 0.01);
        }
    }

    #[test]
    fn the_shunt_gives_the_current_in_both_directions() {
        for amperes in [-50.0, 0.0, 0.5, 25.0, 50.0] {
            assert_near(output_a(counts(1.65 + amperes * 0.001 * 20.0)), amperes, 0.01);
        }
    }

    #[test]
    fn the_thermistor_gives_the_temperature() {
        // Resistances of Murata's NCP15XH103, whose B between 25 and 85 C is 3434 K.
        for (celsius, ohm, tolerance) in
            [(0.0, 27_219.0, 1.5), (25.0, 10_000.0, 0.1), (50.0, 4_161.0, 0.6), (85.0, 1_451.0, 0.5)]
        {
            let measured = contact_c(FULL * ohm / (ohm + 10.0e3));
            assert_near(measured, celsius, tolerance);
        }
    }

    #[test]
    fn a_wire_that_is_off_or_short_gives_no_value() {
        let limits = Limits::new(500.0);
        for end in [0.0, FULL] {
            assert!(output_v(end).abs() >= limits.voltage_range_v, "{} V", output_v(end));
            assert!(output_a(end).abs() >= limits.current_range_a, "{} A", output_a(end));
            let celsius = contact_c(end);
            // As the core asks: false for what is no number.
            let is_value = celsius > sensors::COLDEST_C && celsius < sensors::HOTTEST_C;
            assert!(!is_value, "{celsius} C");
        }
        // A wire is never off or short to the last bit.
        for near in [3.0, FULL - 3.0] {
            let celsius = contact_c(near);
            assert!(!(celsius > sensors::COLDEST_C && celsius < sensors::HOTTEST_C), "{celsius} C");
        }
    }

    #[test]
    fn the_set_point_is_what_the_power_stage_expects() {
        assert_eq!([0.0, 20.0, 66.0].map(set_point), [0, 1240, 4095]);
        assert_eq!([f32::NAN, f32::NEG_INFINITY, -1.0, 1.0e9].map(set_point), [0, 0, 0, 4095]);
    }

    proptest! {
        #[test]
        fn the_power_stage_is_never_told_more_than_the_limit(limit_a in 0.0f32..100.0) {
            let told_a = f32::from(set_point(limit_a)) / FULL * SUPPLY_V * AMPERES_PER_VOLT;
            prop_assert!(told_a <= limit_a * 1.000_001);
            prop_assert!(told_a >= limit_a.min(66.0) - 0.02);
        }

        #[test]
        fn more_counts_are_more_volts_more_amperes_and_colder(counts in 3.0f32..4090.0) {
            let next = counts + 1.0;
            prop_assert!(output_v(next) > output_v(counts));
            prop_assert!(output_a(next) > output_a(counts));
            prop_assert!(contact_c(next) < contact_c(counts));
        }
    }
}
