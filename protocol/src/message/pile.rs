//! What a pile says of itself and of what it sees.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use super::lease::{EndReason, EndedLease, LeaseRef};
use crate::{
    ids::{BootEpoch, PileId, ReportId, TagId},
    limits,
    units::{CurrentA, DurationMs, EnergyJ, Fraction, SiteMillis, TemperatureC, VoltageV},
};

/// A pile's report on itself, at every change and at least every
/// [`limits::STATE_INTERVAL`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PileState {
    /// What others may know too.
    pub row: PileRow,
    /// How long the current charge has run (eq. 1).
    pub elapsed: DurationMs,
    /// The lease the pile holds to.
    pub holder: Option<LeaseRef>,
    /// Whether the contacts are live.
    pub energised: bool,
    /// The lease that ended last since the pile's start, and why.
    pub ended: Option<EndedLease>,
    /// Who stands at the contacts without a lease, as the reader sees: there may be more than one.
    pub standing: Option<TagId>,
    /// What flows out of the contacts, as measured; none if the sensor cannot be believed.
    pub current: Option<CurrentA>,
}

/// What one pile said of itself: a row of the table Q.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PileRow {
    /// Which pile.
    pub pile: PileId,
    /// The pile's start in which it said so; with `version` the age of the row.
    pub boot: BootEpoch,
    /// Grows with every change since that start.
    pub version: u32,
    /// When it said so, if it knew the site's time.
    pub stamp: Option<SiteMillis>,
    /// What the pile does with its place.
    pub availability: Availability,
    /// The share of the planned charge still ahead (LMPP eq. 1): 1 when a charge begins,
    /// 0 when it is done and when there is none.
    pub remaining: Fraction,
    /// The planned time of the charge (LMPP eq. 2); 0 when there is none.
    pub planned: DurationMs,
}

/// What a pile does with its one place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(rename_all = "snake_case")]
pub enum Availability {
    /// Nobody is here and nobody is expected.
    Free,
    /// A lease is held; its robot is not here yet.
    Reserved,
    /// A robot is being charged.
    Charging,
    /// A robot stands here without a lease: its charge is over, or it never had one.
    Done,
    /// The pile must not be used.
    Fault,
}

/// All piles' states as the sender knows them (LMPP's Q), a part a frame. The receiver takes
/// every row that is newer than its own, so that rows may come in any order and any number of
/// times (LMPP Figs. 2 and 3 with a stamp for each row).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PileTable {
    /// Some of the table's rows.
    pub rows: Vec<PileRow, { limits::ROWS_PER_TABLE }>,
}

/// Robots that passed a pile (LMPP eq. 4), repeated until acknowledged, one report at a time
/// and in order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PassReport {
    /// Against repeats.
    pub report: ReportId,
    /// What to add to the counts.
    pub passes: Vec<PassCount, { limits::PASSES_PER_REPORT }>,
}

/// Passes of one robot in one period of the day.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PassCount {
    /// The robot's tag.
    pub tag: TagId,
    /// The period T_j of the day, from 0 (eq. 8).
    pub period: u16,
    /// How often it passed since the last report.
    pub passes: u32,
}

/// A fault that appeared or went, repeated until acknowledged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Fault {
    /// Against repeats.
    pub report: ReportId,
    /// Which.
    pub code: FaultCode,
    /// Whether it is there now.
    pub active: bool,
}

/// A charge that is over, repeated until acknowledged.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ChargeReport {
    /// Against repeats.
    pub report: ReportId,
    /// Under which lease.
    pub lease: LeaseRef,
    /// Whose tag stood at the contacts.
    pub tag: TagId,
    /// Why it is over.
    pub reason: EndReason,
    /// When it began.
    pub began: SiteMillis,
    /// When it was over; none if the pile has restarted in between.
    pub ended: Option<SiteMillis>,
    /// For how long the contacts were live.
    pub charged: DurationMs,
    /// What went over the contacts, as measured.
    pub energy: EnergyJ,
}

/// What a pile measures and commands. A value that no healthy sensor gives is none.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PileReadings {
    /// At the contacts.
    pub voltage: Option<VoltageV>,
    /// Out of the contacts.
    pub current: Option<CurrentA>,
    /// Of the contacts.
    pub temperature: Option<TemperatureC>,
    /// What the power stage is told to give at most.
    pub current_limit: CurrentA,
    /// Whether the contactor is found closed, whatever it was told.
    pub contactor_closed: bool,
    /// Whether a robot's contacts touch the pile's.
    pub mated: bool,
    /// Whether the emergency stop is pressed.
    pub emergency_stop: bool,
    /// Whether the mains are there.
    pub mains: bool,
}

/// What can be wrong with a pile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FaultCode {
    /// The RFID reader does not answer: no robot can be recognised.
    ReaderSilent,
    /// The contactor stays closed though it was told to open.
    ContactorWelded,
    /// The contactor stays open though it was told to close.
    ContactorStuckOpen,
    /// More current than the pile bears.
    OverCurrent,
    /// More voltage than the pile bears.
    OverVoltage,
    /// The contacts are too hot.
    OverTemperature,
    /// The battery is the wrong way round.
    ReversedPolarity,
    /// Current flows though the contactor is open.
    StrayCurrent,
    /// The voltage sensor says what cannot be.
    VoltageSensor,
    /// The current sensor says what cannot be.
    CurrentSensor,
    /// The temperature sensor says what cannot be.
    TemperatureSensor,
    /// The emergency stop is pressed.
    EmergencyStop,
    /// The mains are lost.
    MainsLost,
    /// The non-volatile memory does not keep what it is given.
    StoreFailed,
}

impl FaultCode {
    /// All of them.
    pub const ALL: [Self; 14] = [
        Self::ReaderSilent,
        Self::ContactorWelded,
        Self::ContactorStuckOpen,
        Self::OverCurrent,
        Self::OverVoltage,
        Self::OverTemperature,
        Self::ReversedPolarity,
        Self::StrayCurrent,
        Self::VoltageSensor,
        Self::CurrentSensor,
        Self::TemperatureSensor,
        Self::EmergencyStop,
        Self::MainsLost,
        Self::StoreFailed,
    ];
}
