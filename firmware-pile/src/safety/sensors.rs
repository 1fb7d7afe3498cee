//! What the sensors say, and whether it can be believed.
//!
//! A value is believed if it is a number, lies between the sensor's rails, and changes. That a value
//! changes is a demand a real converter meets: each is the mean of at least 16 conversions, not
//! rounded, whose last bits are never still, whatever is measured. One that repeats to the last bit
//! for [`STUCK_AFTER`] comes from a converter or a transfer that has stopped. A sensor whose wire
//! is off but whose converter runs is found by its rail, or because it contradicts the power stage:
//! [`watch`](super::watch).

use protocol::{DurationMs, Millis};

use super::Limits;

/// A value that is the same to the last bit for this long is not measured any more.
pub const STUCK_AFTER: DurationMs = DurationMs(2_000);

/// The contacts' temperature sensor measures from this to [`HOTTEST_C`], in degrees Celsius; at
/// either end its wire is off or short.
pub const COLDEST_C: f32 = -30.0;
/// See [`COLDEST_C`].
pub const HOTTEST_C: f32 = 125.0;

/// A sample of all sensors of a pile, as they give it: whether it makes sense is the core's to find
/// out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensors {
    /// Voltage at the contacts, in volts, also while the contactor is open: it is the battery's.
    /// Negative if the battery's poles are the wrong way round.
    pub output_v: f32,
    /// Current into the robot, in amperes.
    pub output_a: f32,
    /// Temperature of the contacts, in degrees Celsius.
    pub contact_c: f32,
    /// Whether the contactor is found closed by its auxiliary contact, whatever it was told.
    pub contactor_closed: bool,
    /// Whether a robot's contacts touch the pile's.
    pub mated: bool,
    /// Whether the emergency stop is pressed, or its wire is off.
    pub emergency_stop: bool,
    /// Whether there is mains.
    pub mains: bool,
}

/// What can be believed of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Readings {
    /// Voltage at the contacts, in volts.
    pub voltage_v: Option<f32>,
    /// Current into the robot, in amperes.
    pub current_a: Option<f32>,
    /// Temperature of the contacts, in degrees Celsius.
    pub contact_c: Option<f32>,
}

/// The analog sensors, and what each said last.
#[derive(Clone, Debug)]
pub(super) struct Believing {
    voltage: Sensor,
    current: Sensor,
    temperature: Sensor,
}

impl Believing {
    pub const fn new(limits: &Limits) -> Self {
        Self {
            voltage: Sensor::new(-limits.voltage_range_v, limits.voltage_range_v),
            current: Sensor::new(-limits.current_range_a, limits.current_range_a),
            temperature: Sensor::new(COLDEST_C, HOTTEST_C),
        }
    }

    pub fn read(&mut self, now: Millis, sensors: &Sensors) -> Readings {
        Readings {
            voltage_v: self.voltage.read(now, sensors.output_v),
            current_a: self.current.read(now, sensors.output_a),
            contact_c: self.temperature.read(now, sensors.contact_c),
        }
    }
}

#[derive(Clone, Debug)]
struct Sensor {
    low: f32,
    high: f32,
    last: Option<f32>,
    changed_at: Millis,
}

impl Sensor {
    const fn new(low: f32, high: f32) -> Self {
        Self { low, high, last: None, changed_at: Millis(0) }
    }

    fn read(&mut self, now: Millis, value: f32) -> Option<f32> {
        if self.last.map(f32::to_bits) != Some(value.to_bits()) {
            self.last = Some(value);
            self.changed_at = now;
        }
        // False for NaN and the infinities too.
        let in_range = value > self.low && value < self.high;
        (in_range && now.since(self.changed_at) < STUCK_AFTER).then_some(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nonsense_and_rails_are_no_values() {
        let mut sensor = Sensor::new(-60.0, 60.0);
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 60.0, -60.0, 1.0e9] {
            assert_eq!(sensor.read(Millis(0), value), None, "{value}");
        }
        assert_eq!(sensor.read(Millis(0), 59.9), Some(59.9));
    }

    #[test]
    fn a_value_that_never_changes_is_none_after_two_seconds() {
        let mut sensor = Sensor::new(-60.0, 60.0);
        assert_eq!(sensor.read(Millis(0), 25.0), Some(25.0));
        assert_eq!(sensor.read(Millis(1_999), 25.0), Some(25.0));
        assert_eq!(sensor.read(Millis(2_000), 25.0), None);
        assert_eq!(sensor.read(Millis(2_010), 25.01), Some(25.01));
    }
}
