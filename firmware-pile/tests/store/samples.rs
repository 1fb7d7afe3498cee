//! Things to keep.

use embassy_futures::block_on;
use firmware_pile::store::{Identity, Kept, Record, Report, Store, StoreError};
use protocol::*;

use crate::flash::{Flash, NoPower};

/// Starts the board: opens the store.
pub fn load(flash: &Flash) -> Result<(Store<Flash>, Kept), StoreError<NoPower>> {
    block_on(Store::load(flash.clone(), 0))
}

pub fn identity() -> Identity {
    Identity {
        pile: PileId(7),
        device_key: Key::new([0xA5; 32]),
        site_key: Key::new([0x5A; 32]),
        boot_floor: BootEpoch(0),
        parameters: PileParameters {
            power: PowerW::new(500.0).unwrap(),
            eta: DurationMs(5_000),
            voltage_max: VoltageV::new(30.0).unwrap(),
            current_max: CurrentA::new(20.0).unwrap(),
            derate_from: TemperatureC::new(60.0).unwrap(),
            stop_at: TemperatureC::new(80.0).unwrap(),
            dock_enter_dbm: -60,
            dock_leave_dbm: -66,
        },
    }
}

/// A report of passes, as large as one gets.
pub fn passes(boot: u32, number: u32) -> Report {
    let count = |robot: u16| PassCount { tag: TagId([robot as u8; 12]), period: u16::MAX, passes: u32::MAX };
    Report::Passes(PassReport {
        report: ReportId { boot: BootEpoch(boot), number },
        passes: (0..8).map(count).collect(),
    })
}

/// A report of a charge, as large as one gets.
pub fn charge(boot: u32, number: u32) -> Report {
    Report::Charge(ChargeReport {
        report: ReportId { boot: BootEpoch(boot), number },
        lease: LeaseRef { epoch: Epoch(u32::MAX), lease: LeaseId(u32::MAX), robot: RobotId(u16::MAX) },
        tag: TagId([7; 12]),
        reason: EndReason::Completed,
        began: SiteMillis::MAX,
        ended: Some(SiteMillis::MAX),
        charged: DurationMs::MAX,
        energy: EnergyJ::MAX,
    })
}

/// What is kept once `record` is, too.
pub fn with(mut kept: Kept, record: &Record) -> Kept {
    match record.clone() {
        Record::Identity(identity) => kept.identity = Some(identity),
        Record::Epoch(epoch) => kept.epoch = epoch,
        Record::Latched(latched) => kept.latched = latched,
        Record::Counters(counters) => kept.counters = counters,
        Record::Waiting(slot, report) => kept.journal[usize::from(slot)] = Some(report),
        Record::Acknowledged(slot) => kept.journal[usize::from(slot)] = None,
    }
    kept
}
