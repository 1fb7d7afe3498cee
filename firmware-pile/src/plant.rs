//! A model of what a pile's board is connected to: power stage, contactor, contacts, a robot's
//! battery, sensors. For tests, the simulated site and emulation. It knows nothing of the control:
//! what it gets is what the power stage gets, what it gives is what the sensors give.
//!
//! - The power stage follows its limit with a delay, holds its voltage when the battery is full, and
//!   gives nothing without mains.
//! - A contactor takes [`CONTACTOR_DELAY`] to move. It can be welded, or jammed open.
//! - A battery is a voltage that rises with what it holds, behind a resistance. A full one takes
//!   nothing.
//! - The contacts heat up with the square of the current, and cool down.
//! - Sensors have noise, from a generator of their own: every run is the same. Each can be made to
//!   say something else, or to repeat itself.

use protocol::{DurationMs, Millis};

use crate::safety::{Power, Sensors};

/// How long a contactor moves.
pub const CONTACTOR_DELAY: DurationMs = DurationMs(20);
/// How quickly the power stage follows its limit, in seconds.
const STAGE_S: f32 = 0.02;
/// How quickly the contacts warm up, in seconds.
const WARMING_S: f32 = 60.0;
/// How warm they become, in kelvin for each square ampere.
const HEATING_K_PER_A2: f32 = 0.02;
/// The largest noise of a sensor: volts, amperes, kelvin.
const NOISE: f32 = 0.02;

/// A robot's battery, of 24 V.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Battery {
    /// What it holds when it is full, in joules.
    pub full_j: f32,
    /// What it holds, in joules.
    pub energy_j: f32,
    /// Whether its poles are the wrong way round.
    pub reversed: bool,
}

impl Battery {
    const EMPTY_V: f32 = 22.0;
    const FULL_V: f32 = 28.0;
    const RESISTANCE_OHM: f32 = 0.02;

    /// One with the right poles.
    #[must_use]
    pub const fn new(full_j: f32, energy_j: f32) -> Self {
        Self { full_j, energy_j, reversed: false }
    }

    fn open_circuit_v(&self) -> f32 {
        if self.energy_j >= self.full_j {
            return Plant::STAGE_V;
        }
        Self::EMPTY_V + (Self::FULL_V - Self::EMPTY_V) * self.energy_j / self.full_j
    }
}

/// What a sensor says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Says {
    /// What it measures.
    #[default]
    Truth,
    /// This, with noise.
    About(f32),
    /// Exactly this, again and again.
    Exactly(f32),
}

/// What a pile's board is connected to. Its public fields may be changed at any time, to break
/// something.
#[derive(Clone, Debug)]
pub struct Plant {
    /// The battery of the robot on the contacts.
    pub battery: Option<Battery>,
    /// Whether there is mains.
    pub mains: bool,
    /// Whether the emergency stop is pressed.
    pub emergency_stop: bool,
    /// Whether the contactor cannot open.
    pub welded: bool,
    /// Whether the contactor cannot close.
    pub jammed: bool,
    /// The power stage gives this, in amperes, whatever its limit.
    pub runaway_a: Option<f32>,
    /// What flows past the open contactor into a robot, in amperes.
    pub leak_a: f32,
    /// The temperature around the contacts, in degrees Celsius.
    pub ambient_c: f32,
    /// What the voltage sensor says.
    pub voltage: Says,
    /// What the current sensor says.
    pub current: Says,
    /// What the temperature sensor says.
    pub temperature: Says,
    power: Power,
    sensed_at: Option<Millis>,
    closed: bool,
    moving: DurationMs,
    current_a: f32,
    heating_k: f32,
    noise: u32,
}

impl Plant {
    /// The voltage the power stage holds at the end of a charge.
    pub const STAGE_V: f32 = 29.2;

    /// A sound pile that nobody stands on.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            battery: None,
            mains: true,
            emergency_stop: false,
            welded: false,
            jammed: false,
            runaway_a: None,
            leak_a: 0.0,
            ambient_c: 25.0,
            voltage: Says::Truth,
            current: Says::Truth,
            temperature: Says::Truth,
            power: Power::OFF,
            sensed_at: None,
            closed: false,
            moving: DurationMs(0),
            current_a: 0.0,
            heating_k: 0.0,
            noise: 0x9E37_79B9,
        }
    }

    /// The command from now on.
    pub const fn command(&mut self, power: Power) {
        self.power = power;
    }

    /// The command in force.
    #[must_use]
    pub const fn power(&self) -> Power {
        self.power
    }

    /// What goes over the contacts, in watts; `None` while the contactor is open.
    #[must_use]
    pub fn supply_w(&self) -> Option<f32> {
        self.closed.then_some(self.voltage_v() * self.current_a)
    }

    /// What flows into the robot, in amperes.
    #[must_use]
    pub const fn current_a(&self) -> f32 {
        self.current_a
    }

    /// The voltage at the contacts, in volts.
    #[must_use]
    pub fn voltage_v(&self) -> f32 {
        match &self.battery {
            Some(battery) => {
                let size_v = battery.open_circuit_v() + self.current_a * Battery::RESISTANCE_OHM;
                if battery.reversed { -size_v } else { size_v }
            }
            None if self.closed && self.mains => Self::STAGE_V,
            None => 0.0,
        }
    }

    /// The temperature of the contacts, in degrees Celsius.
    #[must_use]
    pub fn contact_c(&self) -> f32 {
        self.ambient_c + self.heating_k
    }

    /// What the sensors say `now`, after the command has been in force since this was asked last.
    pub fn sense(&mut self, now: Millis) -> Sensors {
        let time = self.sensed_at.replace(now).map_or(DurationMs(0), |before| now.since(before));
        self.advance(time);
        Sensors {
            output_v: self.say(self.voltage, self.voltage_v()),
            output_a: self.say(self.current, self.current_a),
            contact_c: self.say(self.temperature, self.contact_c()),
            contactor_closed: self.closed,
            mated: self.battery.is_some(),
            emergency_stop: self.emergency_stop,
            mains: self.mains,
        }
    }

    fn advance(&mut self, time: DurationMs) {
        let seconds = time.as_seconds();
        self.move_contactor(time);
        self.current_a += (self.target_a() - self.current_a) * (seconds / STAGE_S).min(1.0);
        if !self.closed {
            self.current_a = if self.battery.is_some() { self.leak_a } else { 0.0 };
        }
        let heat_k = HEATING_K_PER_A2 * self.current_a * self.current_a;
        self.heating_k += (heat_k - self.heating_k) * (seconds / WARMING_S).min(1.0);
        let energy_j = self.voltage_v() * self.current_a * seconds;
        if let Some(battery) = &mut self.battery {
            battery.energy_j = (battery.energy_j + energy_j).clamp(0.0, battery.full_j);
        }
    }

    fn move_contactor(&mut self, time: DurationMs) {
        let goal = self.welded || (self.power.is_closed() && !self.jammed);
        self.moving = if goal == self.closed {
            DurationMs(0)
        } else {
            DurationMs(self.moving.0.saturating_add(time.0))
        };
        if self.moving >= CONTACTOR_DELAY {
            self.closed = goal;
            self.moving = DurationMs(0);
        }
    }

    /// What the power stage drives at, in amperes.
    fn target_a(&self) -> f32 {
        let Some(battery) = self.battery.filter(|_| self.closed && self.mains) else { return 0.0 };
        if let Some(runaway_a) = self.runaway_a {
            return runaway_a;
        }
        let taken_a = (Self::STAGE_V - battery.open_circuit_v()) / Battery::RESISTANCE_OHM;
        self.power.current_limit_a.min(taken_a).max(0.0)
    }

    fn say(&mut self, says: Says, truth: f32) -> f32 {
        match says {
            Says::Truth => truth + self.noise(),
            Says::About(value) => value + self.noise(),
            Says::Exactly(value) => value,
        }
    }

    /// Uniform (xorshift).
    fn noise(&mut self) -> f32 {
        self.noise ^= self.noise << 13;
        self.noise ^= self.noise >> 17;
        self.noise ^= self.noise << 5;
        NOISE * (2.0 * (self.noise as f32 / u32::MAX as f32) - 1.0)
    }
}

impl Default for Plant {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::safety::Contactor;

    /// A half full battery on a charger that has given 10 A for so long, sampled every 10 ms.
    fn charging(battery: Battery, ms: u64) -> Plant {
        let mut plant = Plant { battery: Some(battery), ..Plant::new() };
        plant.command(Power { contactor: Contactor::Closed, current_limit_a: 10.0 });
        for now in (0..=ms).step_by(10) {
            plant.sense(Millis(now));
        }
        plant
    }

    const HALF: Battery = Battery::new(100_000.0, 50_000.0);

    #[test]
    fn what_flows_is_the_limit_and_what_it_brings_is_in_the_battery() {
        let plant = charging(HALF, 10_000);
        assert!((plant.current_a() - 10.0).abs() < 1e-3);
        let gained_j = plant.battery.unwrap().energy_j - 50_000.0;
        let expected_j = plant.voltage_v() * 10.0 * 10.0;
        assert!((gained_j / expected_j - 1.0).abs() < 0.01, "{gained_j} J instead of {expected_j} J");
        assert!(plant.contact_c() > 25.1);
    }

    #[test]
    fn a_full_battery_takes_nothing_at_the_voltage_of_the_power_stage() {
        let plant = charging(Battery::new(100.0, 99.0), 1_000);
        assert!(plant.current_a() < 1e-3 && (plant.voltage_v() - Plant::STAGE_V).abs() < 1e-3);
    }

    #[test]
    fn nothing_flows_through_an_open_contactor_and_the_battery_still_shows() {
        let mut plant = charging(HALF, 1_000);
        plant.command(Power::OFF);
        assert!(plant.sense(Millis(1_010)).contactor_closed, "it takes time to move");
        let sensors = plant.sense(Millis(1_020));
        assert!(!sensors.contactor_closed && sensors.output_a.abs() < 0.03 && sensors.output_v > 24.0);
        assert_eq!(plant.supply_w(), None);
    }

    #[test]
    fn a_sensor_says_what_it_is_told_to() {
        let mut plant = charging(HALF, 1_000);
        plant.voltage = Says::About(12.0);
        plant.current = Says::Exactly(3.0);
        let (one, other) = (plant.sense(Millis(1_010)), plant.sense(Millis(1_020)));
        assert!((one.output_v - 12.0).abs() < 0.03 && one.output_v != other.output_v);
        assert_eq!((one.output_a, other.output_a), (3.0, 3.0));
    }
}
