//! Which faults a sample of the sensors shows, given what was commanded.
//!
//! Besides values that cannot be believed ([`sensors`](super::sensors)) and limits that are exceeded,
//! these are contradictions: a contactor or a power stage that does otherwise than it was told, or a
//! sensor that says so. Which of the two it is cannot always be known; the fault is named after the
//! likelier, and the pile stops either way.

use protocol::{DurationMs, FaultCode, Millis};

use super::{Limits, Power, Readings, Sensors};
use crate::faults::FaultSet;

/// A contactor has this long to do as it is told.
pub const CONTACTOR_TIME: DurationMs = DurationMs(250);
/// The power stage has this long to follow its limit down.
pub const FOLLOW_TIME: DurationMs = DurationMs(150);
/// A current through an open contactor is a fault after this time.
pub const STRAY_TIME: DurationMs = DurationMs(150);
/// A voltage where there can be none is a fault after this time.
pub const VOLTAGE_TIME: DurationMs = DurationMs(1_000);
/// A battery whose voltage is gone while it is being charged is a fault after this time: less than a
/// stop takes, so that contacts that break down under load are not tried again and again.
pub const COLLAPSE_TIME: DurationMs = DurationMs(50);
/// Current that should flow and does not is a fault after this time.
pub const NO_CURRENT_TIME: DurationMs = DurationMs(3_000);

/// Below this the battery's poles are the wrong way round, in volts.
pub const REVERSED_V: f32 = -2.0;
/// Contacts that nothing touches show no more than this, in volts.
pub const UNTOUCHED_V: f32 = 5.0;
/// Contacts that were too hot have to be this much cooler, in kelvin.
pub const HYSTERESIS_K: f32 = 5.0;

/// What a look at the sensors can see.
pub const SEEN: FaultSet = FaultSet::of(&[
    FaultCode::ContactorWelded,
    FaultCode::ContactorStuckOpen,
    FaultCode::OverCurrent,
    FaultCode::OverVoltage,
    FaultCode::OverTemperature,
    FaultCode::ReversedPolarity,
    FaultCode::StrayCurrent,
    FaultCode::VoltageSensor,
    FaultCode::CurrentSensor,
    FaultCode::TemperatureSensor,
    FaultCode::EmergencyStop,
    FaultCode::MainsLost,
]);

/// What has to last before it is a fault, and since when it does.
#[derive(Clone, Debug, Default)]
pub(super) struct Watch {
    told_closed: bool,
    disagrees: Since,
    exceeds: Since,
    strays: Since,
    misplaced: Since,
    collapsed: Since,
    idles: Since,
    too_hot: bool,
}

impl Watch {
    /// The causes of faults that a sample shows, taken under the command `power`.
    pub fn look(
        &mut self,
        now: Millis,
        limits: &Limits,
        sensors: &Sensors,
        readings: &Readings,
        power: Power,
    ) -> FaultSet {
        let mut found = FaultSet::EMPTY;
        let mut add = |code, is_there| {
            if is_there {
                found.insert(code);
            }
        };
        add(FaultCode::EmergencyStop, sensors.emergency_stop);
        add(FaultCode::MainsLost, !sensors.mains);

        let disagrees = self.disagrees(now, sensors.contactor_closed, power.is_closed());
        add(FaultCode::ContactorWelded, disagrees && sensors.contactor_closed);
        add(FaultCode::ContactorStuckOpen, disagrees && !sensors.contactor_closed);

        // By what it says, even where that cannot be believed: a short circuit is beyond every rail.
        let is_over = sensors.output_a.abs() > limits.over_current_a();
        let exceeds = self.exceeds(now, limits, readings, power);
        add(FaultCode::OverCurrent, is_over || exceeds);
        add(FaultCode::StrayCurrent, self.strays(now, limits, sensors, readings, power));

        add(
            FaultCode::OverVoltage,
            readings.voltage_v.is_some_and(|voltage_v| voltage_v > limits.voltage_max_v),
        );
        add(FaultCode::ReversedPolarity, readings.voltage_v.is_some_and(|voltage_v| voltage_v < REVERSED_V));
        add(FaultCode::OverTemperature, self.is_too_hot(limits, readings));

        let impossible = self.is_impossible(now, limits, sensors, readings, power);
        add(FaultCode::VoltageSensor, readings.voltage_v.is_none() || impossible);
        let idles = self.idles(now, limits, sensors, readings, power);
        add(FaultCode::CurrentSensor, readings.current_a.is_none() || idles);
        add(FaultCode::TemperatureSensor, readings.contact_c.is_none());
        found
    }

    /// The contactor does not do as it is told. It gets its time anew with every command.
    fn disagrees(&mut self, now: Millis, closed: bool, told_closed: bool) -> bool {
        let is_new = told_closed != self.told_closed;
        self.told_closed = told_closed;
        if is_new {
            self.disagrees = Since::default();
        }
        self.disagrees.lasts(now, closed != told_closed, CONTACTOR_TIME)
    }

    /// More flows than the power stage is told to give.
    fn exceeds(&mut self, now: Millis, limits: &Limits, readings: &Readings, power: Power) -> bool {
        let most_a = power.current_limit_a + limits.tolerance_a();
        let is_more =
            power.is_closed() && readings.current_a.is_some_and(|current_a| current_a.abs() > most_a);
        self.exceeds.lasts(now, is_more, FOLLOW_TIME)
    }

    /// Current flows though the contactor is open.
    fn strays(
        &mut self,
        now: Millis,
        limits: &Limits,
        sensors: &Sensors,
        readings: &Readings,
        power: Power,
    ) -> bool {
        let is_open = !power.is_closed() && !sensors.contactor_closed;
        let flows = readings.current_a.is_some_and(|current_a| current_a.abs() > limits.zero_a());
        self.strays.lasts(now, is_open && flows, STRAY_TIME)
    }

    fn is_too_hot(&mut self, limits: &Limits, readings: &Readings) -> bool {
        let limit_c = limits.stop_at_c - if self.too_hot { HYSTERESIS_K } else { 0.0 };
        self.too_hot = readings.contact_c.is_some_and(|contact_c| contact_c >= limit_c);
        self.too_hot
    }

    /// Voltage where nothing touches the contacts and nothing is connected to them, or none where a
    /// battery is being charged.
    fn is_impossible(
        &mut self,
        now: Millis,
        limits: &Limits,
        sensors: &Sensors,
        readings: &Readings,
        power: Power,
    ) -> bool {
        let is_apart = !power.is_closed() && !sensors.contactor_closed && !sensors.mated;
        let is_joined = power.is_closed() && sensors.contactor_closed && sensors.mated;
        let is_some = readings.voltage_v.is_some_and(|voltage_v| voltage_v.abs() > UNTOUCHED_V);
        let is_gone = readings.voltage_v.is_some_and(|voltage_v| voltage_v < limits.voltage_min_v());
        let misplaced = self.misplaced.lasts(now, is_apart && is_some, VOLTAGE_TIME);
        let collapsed = self.collapsed.lasts(now, is_joined && is_gone, COLLAPSE_TIME);
        misplaced || collapsed
    }

    /// No current though it is told to flow and the battery is not full.
    fn idles(
        &mut self,
        now: Millis,
        limits: &Limits,
        sensors: &Sensors,
        readings: &Readings,
        power: Power,
    ) -> bool {
        let (Some(voltage_v), Some(current_a)) = (readings.voltage_v, readings.current_a) else {
            return false;
        };
        let should_flow = sensors.contactor_closed
            && sensors.mated
            && power.current_limit_a > limits.tolerance_a()
            && voltage_v < limits.full_from_v();
        self.idles.lasts(now, should_flow && current_a < limits.zero_a(), NO_CURRENT_TIME)
    }
}

/// Since when something is so.
#[derive(Clone, Copy, Debug, Default)]
struct Since(Option<Millis>);

impl Since {
    /// Whether it `is_so` and was for `time`.
    fn lasts(&mut self, now: Millis, is_so: bool, time: DurationMs) -> bool {
        if !is_so {
            self.0 = None;
            return false;
        }
        now.since(*self.0.get_or_insert(now)) >= time
    }
}
