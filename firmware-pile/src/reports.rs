//! Reports that are repeated until acknowledged: faults, charges and passes.
//!
//! Charges and passes go through a journal in the store: they are written down before they are sent,
//! and crossed out when they were acknowledged, so that a restart forgets none. The coordinator takes a
//! report of a kind only if it is later than the last of that kind, so that none counts twice; each
//! kind is sent in order. A charge is written down twice under the same name: as interrupted when it
//! begins, and as it was when it is over.
//!
//! Faults are not written down, because those that last are found or remembered again. They are sent
//! before everything else.

use firmware_common::passes::PassCounter;
use protocol::{
    BootEpoch, ChargeReport, DurationMs, EndReason, EnergyJ, Fault, FaultCode, LeaseRef, Message, Millis,
    PassCount, PassReport, ReportId, SiteMillis, TagId, limits,
};

use crate::faults::Faults;
use crate::store::{JOURNAL, Journal, Record, Report, Slot};

/// How long passes are collected after a report, so that the flash lasts.
pub const PASS_INTERVAL: DurationMs = DurationMs(60_000);

/// Places of the journal that passes leave for charges.
const FOR_CHARGES: usize = JOURNAL / 2;

/// The reports that wait for their acknowledgements.
#[derive(Clone, Debug)]
pub struct Reports {
    boot: BootEpoch,
    /// The number of the last report.
    number: u32,
    fault: Option<(ReportId, FaultCode, bool)>,
    journal: Journal,
    /// Whose places were changed since they were stored.
    unsaved: [bool; JOURNAL],
    /// The place of the charge under way.
    charge: Option<Slot>,
    /// What was sent last, and when.
    sent: Option<(ReportId, Millis)>,
    passes_taken_at: Option<Millis>,
}

impl Reports {
    /// What `journal` still holds is reported first. The first new report of the start `boot` will
    /// have number 1.
    #[must_use]
    pub const fn new(boot: BootEpoch, journal: Journal) -> Self {
        Self {
            boot,
            number: 0,
            fault: None,
            journal,
            unsaved: [false; JOURNAL],
            charge: None,
            sent: None,
            passes_taken_at: None,
        }
    }

    /// Whether there is a place for another charge. A coordinator that grants one acknowledges those
    /// before, so that there is.
    #[must_use]
    pub fn has_place(&self) -> bool {
        self.free() > 0
    }

    /// A charge begins.
    pub fn begin_charge(&mut self, lease: LeaseRef, tag: TagId, began: SiteMillis) {
        let report = ChargeReport {
            report: self.next_id(),
            lease,
            tag,
            reason: EndReason::Fault,
            began,
            ended: None,
            charged: DurationMs(0),
            energy: EnergyJ::MIN,
        };
        self.charge = self.write(Report::Charge(report));
    }

    /// The charge under way has delivered `energy` so far.
    pub fn deliver(&mut self, energy: EnergyJ) {
        if let Some(report) = self.charge_under_way() {
            report.energy = energy;
        }
    }

    /// The charge under way, if there is one, is over. Answers whether there was one.
    pub fn end_charge(&mut self, reason: EndReason, charged: DurationMs, ended: Option<SiteMillis>) -> bool {
        let Some(report) = self.charge_under_way() else { return false };
        // The coordinator takes none for a restart.
        let ended = ended.unwrap_or(report.began.after(charged));
        *report = ChargeReport { reason, charged, ended: Some(ended), ..*report };
        if let Some(unsaved) = self.charge.take().and_then(|slot| self.unsaved.get_mut(usize::from(slot))) {
            *unsaved = true;
        }
        true
    }

    /// Takes passes out of their counter when it is time to report them and there is a place.
    pub fn take_passes(&mut self, now: Millis, period: Option<u16>, passes: &mut PassCounter) {
        let waits = |taken_at| now.since(taken_at) < PASS_INTERVAL;
        if self.free() <= FOR_CHARGES || self.passes_taken_at.is_some_and(waits) {
            return;
        }
        let passes = passes.take(period);
        if !passes.is_empty() {
            self.passes_taken_at = Some(now);
            let report = self.next_id();
            self.write(Report::Passes(PassReport { report, passes }));
        }
    }

    /// Report `of` has arrived.
    pub fn acknowledged(&mut self, of: ReportId) {
        self.fault = self.fault.filter(|(report, ..)| *report != of);
        let under_way = self.charge.map(usize::from);
        for (slot, (place, unsaved)) in self.journal.iter_mut().zip(&mut self.unsaved).enumerate() {
            if place.as_ref().is_some_and(|report| report.id() == of) && Some(slot) != under_way {
                *place = None;
                *unsaved = true;
            }
        }
    }

    /// The passes that wait for their acknowledgement, sent or not.
    pub fn pending(&self) -> impl Iterator<Item = PassCount> {
        let reports = self.journal.iter().filter_map(|place| match place {
            Some(Report::Passes(report)) => Some(&report.passes),
            _ => None,
        });
        reports.flatten().copied()
    }

    /// The next change of the journal to store.
    pub fn record(&mut self) -> Option<Record> {
        let (slot, unsaved) = self.unsaved.iter_mut().enumerate().find(|(_, unsaved)| **unsaved)?;
        *unsaved = false;
        let place = Slot::try_from(slot).ok()?;
        Some(match self.journal.get(slot)? {
            Some(report) => Record::Waiting(place, report.clone()),
            None => Record::Acknowledged(place),
        })
    }

    /// Nobody knows what of the journal is stored.
    pub const fn store_failed(&mut self) {
        self.unsaved = [true; JOURNAL];
    }

    /// The report to send now, if one is due. What is not stored is not sent.
    pub fn due(&mut self, now: Millis, faults: &mut Faults) -> Option<Message> {
        if self.fault.is_none()
            && let Some((code, active)) = faults.take_change()
        {
            self.fault = Some((self.next_id(), code, active));
        }
        let (report, message) = match self.fault {
            Some((report, code, active)) => (report, Message::Fault(Fault { report, code, active })),
            None => self.oldest().map(|report| (report.id(), report.message()))?,
        };
        let waits = |&(of, at): &(ReportId, Millis)| of == report && now.since(at) < limits::REPEAT_INTERVAL;
        if self.sent.as_ref().is_some_and(waits) {
            return None;
        }
        self.sent = Some((report, now));
        Some(message)
    }

    /// The stored report that waits longest. The charge under way is not over yet.
    fn oldest(&self) -> Option<&Report> {
        let under_way = self.charge.map(usize::from);
        let places = self.journal.iter().zip(&self.unsaved).enumerate();
        places
            .filter(|(slot, (_, unsaved))| !**unsaved && Some(*slot) != under_way)
            .filter_map(|(_, (report, _))| report.as_ref())
            .min_by_key(|report| report.id())
    }

    fn charge_under_way(&mut self) -> Option<&mut ChargeReport> {
        match self.journal.get_mut(usize::from(self.charge?))? {
            Some(Report::Charge(report)) => Some(report),
            _ => None,
        }
    }

    fn free(&self) -> usize {
        self.journal.iter().filter(|place| place.is_none()).count()
    }

    fn write(&mut self, report: Report) -> Option<Slot> {
        let slot = self.journal.iter().position(Option::is_none)?;
        *self.journal.get_mut(slot)? = Some(report);
        *self.unsaved.get_mut(slot)? = true;
        Slot::try_from(slot).ok()
    }

    fn next_id(&mut self) -> ReportId {
        self.number = self.number.saturating_add(1);
        ReportId { boot: self.boot, number: self.number }
    }
}
