//! Whether the contacts may be live, and how they become so and stop being so.
//!
//! ```text
//!  sensors ──▶ believed or not ──▶ watched for faults ──┐
//!  lease, tag, clock ───────────────────────────────────┴▶ conditions ──▶ power, in sequence
//! ```
//! Nothing here or anywhere else of this software is certified for anything.

use protocol::{DurationMs, FaultCode, Millis};

use crate::faults::{FaultSet, Faults};

pub mod conditions;
pub mod limits;
pub mod power;
pub mod sensors;
pub mod watch;

pub use limits::Limits;
pub use power::{Contactor, Permit, Power};
pub use sensors::{Readings, Sensors};

use power::{Found, Sequence};
use sensors::Believing;
use watch::Watch;

/// What was sampled longer ago says nothing about now.
pub const SAMPLE_TIMEOUT: DurationMs = DurationMs(250);

/// Faults for which the contactor does not wait until the current is gone.
pub const OPENING_AT_ONCE: FaultSet = FaultSet::of(&[FaultCode::EmergencyStop, FaultCode::OverCurrent]);

/// What the sensors said last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// When.
    pub at: Millis,
    /// As they said it.
    pub sensors: Sensors,
    /// As far as it can be believed.
    pub readings: Readings,
}

/// The sensors, the power, and what is known of both.
#[derive(Clone, Debug)]
pub struct Safety {
    limits: Limits,
    power_w: f32,
    believing: Believing,
    watch: Watch,
    sample: Option<Sample>,
    sequence: Sequence,
}

impl Safety {
    /// Contacts dead, nothing known; the power stage gives at most `power_w`.
    #[must_use]
    pub fn new(limits: Limits, power_w: f32) -> Self {
        Self {
            limits,
            power_w,
            believing: Believing::new(&limits),
            watch: Watch::default(),
            sample: None,
            sequence: Sequence::new(),
        }
    }

    /// Takes a sample. Answers the energy given since the last, in joules.
    pub fn sense(&mut self, now: Millis, sensors: Sensors, faults: &mut Faults) -> f32 {
        let readings = self.believing.read(now, &sensors);
        let found = self.watch.look(now, &self.limits, &sensors, &readings, self.sequence.power());
        faults.look(now, watch::SEEN, found);
        let before = self.sample.replace(Sample { at: now, sensors, readings });
        let passed = before.map_or(DurationMs(0), |before| now.since(before.at)).min(SAMPLE_TIMEOUT);
        match (readings.voltage_v, readings.current_a) {
            (Some(voltage_v), Some(current_a)) => (voltage_v * current_a * passed.as_seconds()).max(0.0),
            _ => 0.0,
        }
    }

    /// The last sample, if it is fresh.
    #[must_use]
    pub fn sample(&self, now: Millis) -> Option<&Sample> {
        self.sample.as_ref().filter(|sample| now.since(sample.at) < SAMPLE_TIMEOUT)
    }

    /// The command in force.
    #[must_use]
    pub const fn power(&self) -> Power {
        self.sequence.power()
    }

    /// Commands what `permit` allows.
    pub fn command(&mut self, now: Millis, permit: Permit) {
        let found = match self.sample {
            Some(Sample { at, sensors, readings }) => {
                let current_a = if now.since(at) < SAMPLE_TIMEOUT { readings.current_a } else { None };
                Found { at, closed: sensors.contactor_closed, current_a }
            }
            None => Found { at: Millis(0), closed: false, current_a: None },
        };
        self.sequence.command(now, &self.limits, permit, found);
    }
}
