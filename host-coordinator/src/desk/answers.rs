//! What a pile has answered, as it came and as data for programs.

use protocol::{
    FaultCode, FaultState, LeaseRef, PendingPass, PileId, PileParameters, PileReadings, PileRow, PileState,
};
use serde::Serialize;

use super::words;
use crate::core::view::fault_name;

/// What was asked, as far as it was asked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answers {
    /// Who has answered.
    pub pile: Option<PileId>,
    /// What it does.
    pub state: Option<PileState>,
    /// What it measures.
    pub readings: Option<PileReadings>,
    /// What is wrong with it.
    pub faults: Option<Vec<FaultState>>,
    /// How it charges.
    pub parameters: Option<PileParameters>,
    /// What it has counted.
    pub passes: Option<Vec<PendingPass>>,
    /// What it knows of all piles.
    pub table: Option<Vec<PileRow>>,
    /// The fault it has cleared.
    pub cleared: Option<FaultCode>,
}

/// The answers as data: what was not asked is left out, a value that is not known is null.
#[derive(Debug, Serialize)]
pub struct Document {
    pile: Option<PileId>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cleared: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    state: Option<State>,
    #[serde(skip_serializing_if = "Option::is_none")]
    readings: Option<Readings>,
    #[serde(skip_serializing_if = "Option::is_none")]
    faults: Option<Vec<Fault>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    parameters: Option<Parameters>,
    #[serde(skip_serializing_if = "Option::is_none")]
    passes: Option<Vec<Pass>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    table: Option<Vec<Row>>,
}

#[derive(Debug, Serialize)]
struct State {
    availability: &'static str,
    energised: bool,
    remaining: f32,
    planned_s: f32,
    elapsed_s: f32,
    lease: Option<LeaseRef>,
    ended: Option<Ended>,
}

#[derive(Debug, Serialize)]
struct Ended {
    lease: LeaseRef,
    reason: &'static str,
    charged_s: f32,
}

#[derive(Debug, Serialize)]
struct Readings {
    voltage_v: Option<f32>,
    current_a: Option<f32>,
    temperature_c: Option<f32>,
    current_limit_a: f32,
    contactor_closed: bool,
    mated: bool,
    emergency_stop: bool,
    mains: bool,
}

#[derive(Debug, Serialize)]
struct Fault {
    code: &'static str,
    active: bool,
    latched: bool,
    meaning: &'static str,
    look_at: &'static str,
}

#[derive(Debug, Serialize)]
struct Parameters {
    power_w: f32,
    eta_s: f32,
    voltage_max_v: f32,
    current_max_a: f32,
    derate_from_c: f32,
    stop_at_c: f32,
    dock_enter_dbm: i8,
    dock_leave_dbm: i8,
}

#[derive(Debug, Serialize)]
struct Pass {
    tag: String,
    period: Option<u16>,
    passes: u32,
}

#[derive(Debug, Serialize)]
struct Row {
    pile: PileId,
    boot: u32,
    version: u32,
    stamp_ms: Option<u64>,
    availability: &'static str,
    remaining: f32,
    planned_s: f32,
}

impl Answers {
    /// As data for programs.
    #[must_use]
    pub fn document(&self) -> Document {
        Document {
            pile: self.pile,
            cleared: self.cleared.map(fault_name),
            state: self.state.as_ref().map(State::from),
            readings: self.readings.as_ref().map(Readings::from),
            faults: self.faults.as_ref().map(|faults| faults.iter().map(Fault::from).collect()),
            parameters: self.parameters.as_ref().map(Parameters::from),
            passes: self.passes.as_ref().map(|passes| passes.iter().map(Pass::from).collect()),
            table: self.table.as_ref().map(|table| table.iter().map(Row::from).collect()),
        }
    }
}

impl From<&PileState> for State {
    fn from(state: &PileState) -> Self {
        Self {
            availability: words::availability(state.row.availability),
            energised: state.energised,
            remaining: state.row.remaining.get(),
            planned_s: state.row.planned.as_seconds(),
            elapsed_s: state.elapsed.as_seconds(),
            lease: state.holder,
            ended: state.ended.map(|ended| Ended {
                lease: ended.lease,
                reason: words::end_name(ended.reason),
                charged_s: ended.charged.as_seconds(),
            }),
        }
    }
}

impl From<&PileReadings> for Readings {
    fn from(readings: &PileReadings) -> Self {
        Self {
            voltage_v: readings.voltage.map(|voltage| voltage.get()),
            current_a: readings.current.map(|current| current.get()),
            temperature_c: readings.temperature.map(|temperature| temperature.get()),
            current_limit_a: readings.current_limit.get(),
            contactor_closed: readings.contactor_closed,
            mated: readings.mated,
            emergency_stop: readings.emergency_stop,
            mains: readings.mains,
        }
    }
}

impl From<&FaultState> for Fault {
    fn from(fault: &FaultState) -> Self {
        let words::Fault { meaning, look_at } = words::fault(fault.code);
        Self { code: fault_name(fault.code), active: fault.active, latched: fault.latched, meaning, look_at }
    }
}

impl From<&PileParameters> for Parameters {
    fn from(parameters: &PileParameters) -> Self {
        Self {
            power_w: parameters.power.get(),
            eta_s: parameters.eta.as_seconds(),
            voltage_max_v: parameters.voltage_max.get(),
            current_max_a: parameters.current_max.get(),
            derate_from_c: parameters.derate_from.get(),
            stop_at_c: parameters.stop_at.get(),
            dock_enter_dbm: parameters.dock_enter_dbm,
            dock_leave_dbm: parameters.dock_leave_dbm,
        }
    }
}

impl From<&PendingPass> for Pass {
    fn from(count: &PendingPass) -> Self {
        Self { tag: count.tag.to_string(), period: count.period, passes: count.passes }
    }
}

impl From<&PileRow> for Row {
    fn from(row: &PileRow) -> Self {
        Self {
            pile: row.pile,
            boot: row.boot.0,
            version: row.version,
            stamp_ms: row.stamp.map(|stamp| stamp.0),
            availability: words::availability(row.availability),
            remaining: row.remaining.get(),
            planned_s: row.planned.as_seconds(),
        }
    }
}
