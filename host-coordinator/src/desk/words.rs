//! What a pile says, in words for a person.

use protocol::{Availability, EndReason, FaultCode, FaultState, LeaseRef, NackReason, PileState};

use super::answers::Answers;

/// What a fault means, and what to do about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fault {
    /// What the pile has found.
    pub meaning: &'static str,
    /// Where its cause is likely to be.
    pub look_at: &'static str,
}

/// What a fault means, and what to do about it.
#[must_use]
pub const fn fault(code: FaultCode) -> Fault {
    let (meaning, look_at) = match code {
        FaultCode::ReaderSilent => ("the RFID reader does not answer", "the reader's cable and its supply"),
        FaultCode::ContactorWelded => (
            "the contactor stays closed though it was told to open",
            "cut the mains first: the contacts may be live; then replace the contactor",
        ),
        FaultCode::ContactorStuckOpen => (
            "the contactor stays open though it was told to close",
            "the wires of the contactor's coil and of its auxiliary contact",
        ),
        FaultCode::OverCurrent => (
            "more current has flowed than the pile bears",
            "a short at the contacts or in the robot that stood there; then the power stage",
        ),
        FaultCode::OverVoltage => (
            "the voltage at the contacts is beyond what the pile bears",
            "whether the robot's battery belongs to this pile; then the power stage's end voltage",
        ),
        FaultCode::OverTemperature => {
            ("the contacts were too hot", "dirt and wear on the contacts, and whether they mate in full")
        }
        FaultCode::ReversedPolarity => (
            "the battery at the contacts is the wrong way round",
            "the wiring of the robot that stands there: lead it away",
        ),
        FaultCode::StrayCurrent => (
            "current flows though the contactor is open",
            "cut the mains first; then the contactor, and the zero of the current sensor",
        ),
        FaultCode::VoltageSensor => {
            ("the voltage sensor says what cannot be", "the voltage sensor's wires: off, short, or stuck")
        }
        FaultCode::CurrentSensor => {
            ("the current sensor says what cannot be", "the current sensor's wires: off, short, or stuck")
        }
        FaultCode::TemperatureSensor => (
            "the temperature sensor says what cannot be",
            "the temperature sensor's wires at the contacts: off, short, or stuck",
        ),
        FaultCode::EmergencyStop => {
            ("the emergency stop is pressed", "why it was pressed; then release it, or mend its wire")
        }
        FaultCode::MainsLost => ("there is no mains", "the supply and its fuse"),
        FaultCode::StoreFailed => {
            ("the board's memory does not keep what it is given", "nothing on the outside: replace the board")
        }
    };
    Fault { meaning, look_at }
}

/// What becomes of it.
#[must_use]
pub const fn course(fault: &FaultState) -> &'static str {
    match (fault.active, fault.latched) {
        (true, true) => "there now, and stays until it is cleared",
        (true, false) => "there now, and goes with its cause",
        (false, true) => "its cause is gone; it stays until it is cleared",
        (false, false) => "gone",
    }
}

/// Why a fault was not cleared, and what to do.
#[must_use]
pub fn refusal(code: FaultCode, reason: NackReason) -> String {
    match reason {
        NackReason::NotCleared => {
            format!("its cause is still there or was a moment ago; look at: {}", fault(code).look_at)
        }
        other => format!("{other:?}, which no pile should say; is its software the right one?"),
    }
}

/// What a pile does with its place.
#[must_use]
pub const fn availability(availability: Availability) -> &'static str {
    match availability {
        Availability::Free => "free",
        Availability::Reserved => "reserved",
        Availability::Charging => "charging",
        Availability::Done => "done",
        Availability::Fault => "fault",
    }
}

/// Why a lease is over, for programs.
#[must_use]
pub const fn end_name(reason: EndReason) -> &'static str {
    match reason {
        EndReason::Completed => "completed",
        EndReason::Expired => "expired",
        EndReason::Revoked => "revoked",
        EndReason::RobotLeft => "robot_left",
        EndReason::Fault => "fault",
    }
}

/// Why a lease is over.
#[must_use]
pub const fn end(reason: EndReason) -> &'static str {
    match reason {
        EndReason::Completed => "the charge was given in full",
        EndReason::Expired => "it ran out",
        EndReason::Revoked => "the coordinator took it back",
        EndReason::RobotLeft => "the robot left",
        EndReason::Fault => "the pile found a fault",
    }
}

/// A lease by its names.
#[must_use]
pub fn lease(lease: LeaseRef) -> String {
    format!("lease {} of robot {} (epoch {})", lease.lease, lease.robot, lease.epoch)
}

/// How far a charge is; empty if there is none.
#[must_use]
pub fn progress(state: &PileState) -> String {
    if state.row.planned.0 == 0 {
        return String::new();
    }
    format!(
        "{:.0} s of {:.0} s, {:.0} % to go",
        state.elapsed.as_seconds(),
        state.row.planned.as_seconds(),
        state.row.remaining.get() * 100.0
    )
}

/// A measured value with its unit; one that no healthy sensor gives is named so.
#[must_use]
pub fn measured(value: Option<f32>, decimals: usize, unit: &str) -> String {
    value.map_or_else(|| "not measured".into(), |value| format!("{value:.decimals$} {unit}"))
}

/// A line of what a pile does and measures now.
#[must_use]
pub fn status_line(answers: &Answers) -> String {
    let mut parts = Vec::new();
    if let Some(state) = &answers.state {
        parts.push(format!("{:<8}", availability(state.row.availability)));
    }
    if let Some(readings) = &answers.readings {
        parts.push(measured(readings.voltage.map(|value| value.get()), 1, "V"));
        parts.push(format!(
            "{} of {:.1} A",
            measured(readings.current.map(|value| value.get()), 1, "A"),
            readings.current_limit.get()
        ));
        parts.push(measured(readings.temperature.map(|value| value.get()), 1, "°C"));
        parts.push(format!("contactor {}", if readings.contactor_closed { "closed" } else { "open" }));
        parts.push(if readings.mated { "robot mated".into() } else { "no robot mated".into() });
        parts.extend((!readings.mains).then(|| "no mains".into()));
    }
    if let Some(state) = &answers.state {
        parts.push(state.holder.map_or_else(|| "no lease".into(), lease));
        parts.extend(Some(progress(state)).filter(|progress| !progress.is_empty()));
    }
    let faults = answers.faults.iter().flatten();
    parts.extend(faults.map(|state| format!("! {}", crate::core::view::fault_name(state.code))));
    parts.join("  ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_fault_has_its_own_meaning_and_something_to_look_at() {
        let meanings: std::collections::HashSet<_> =
            FaultCode::ALL.iter().map(|code| fault(*code).meaning).collect();
        assert_eq!(meanings.len(), FaultCode::ALL.len());
        assert!(FaultCode::ALL.iter().all(|code| !fault(*code).look_at.is_empty()));
    }
}
