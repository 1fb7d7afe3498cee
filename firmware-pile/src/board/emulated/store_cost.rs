//! What the core does to store a record, besides waiting for the flash: encoding, finding the place,
//! checksums, reading back. The log says it at a start that forgets everything.

use cortex_m::peripheral::SYST;
use embassy_futures::block_on;
use embedded_storage_async::nor_flash::NorFlash;
use firmware_common::emulated::elapsed_cycles;
use protocol::{
    BootEpoch, ChargeReport, DurationMs, EndReason, EnergyJ, Epoch, LeaseId, LeaseRef, PassCount, PassReport,
    ReportId, RobotId, SiteMillis, TagId, limits,
};

use crate::store::{Record, Report, Store};

/// Logs what the largest record of each kind costs, in instructions under `-icount shift=0`.
pub fn log<F: NorFlash>(store: &mut Store<F>) {
    let report = ReportId { boot: BootEpoch(u32::MAX), number: u32::MAX };
    let charge = ChargeReport {
        report,
        lease: LeaseRef { epoch: Epoch(u32::MAX), lease: LeaseId(u32::MAX), robot: RobotId(u16::MAX) },
        tag: TagId([0xFF; 12]),
        reason: EndReason::Completed,
        began: SiteMillis::MAX,
        ended: Some(SiteMillis::MAX),
        charged: DurationMs::MAX,
        energy: EnergyJ::MAX,
    };
    let count = PassCount { tag: TagId([0xFF; 12]), period: u16::MAX, passes: u32::MAX };
    let passes = core::iter::repeat_n(count, limits::PASSES_PER_REPORT).collect();
    for (name, record) in [
        ("epoch", Record::Epoch(Epoch(u32::MAX))),
        ("charge", Record::Waiting(0, Report::Charge(charge))),
        ("passes", Record::Waiting(0, Report::Passes(PassReport { report, passes }))),
        ("acknowledged", Record::Acknowledged(0)),
    ] {
        let start = SYST::get_current();
        let stored = block_on(store.append(&record));
        let instructions = elapsed_cycles(start).saturating_mul(1_000) / 168;
        if stored.is_ok() {
            defmt::info!("cost of a record: {=str} {}", name, instructions);
        }
    }
}
