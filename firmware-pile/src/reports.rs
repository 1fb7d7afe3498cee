//! Reports that are repeated until acknowledged: faults and passes, one at a time and in order.

use firmware_common::passes::PassCounter;
use protocol::{
    BootEpoch, DurationMs, Fault, FaultCode, Message, Millis, PassCount, PassReport, ReportId, limits,
};

use crate::faults::Faults;

/// How long passes are collected before they are reported.
pub const PASS_INTERVAL: DurationMs = DurationMs(2_000);

#[derive(Clone, Debug)]
enum Content {
    Fault(FaultCode, bool),
    Passes(heapless::Vec<PassCount, { limits::PASSES_PER_REPORT }>),
}

#[derive(Clone, Debug)]
struct Outstanding {
    content: Content,
    sent_at: Option<Millis>,
}

/// The report that waits for its acknowledgement.
#[derive(Clone, Debug)]
pub struct Reports {
    boot: BootEpoch,
    /// The number of the outstanding report, or else of the last.
    number: u32,
    outstanding: Option<Outstanding>,
    passes_taken_at: Option<Millis>,
}

impl Reports {
    /// Nothing to report in the start `boot`; the first report will have number 1.
    #[must_use]
    pub const fn new(boot: BootEpoch) -> Self {
        Self { boot, number: 0, outstanding: None, passes_taken_at: None }
    }

    /// Report `of` has arrived.
    pub fn acknowledged(&mut self, of: ReportId) {
        if of == self.name() {
            self.outstanding = None;
        }
    }

    /// The report to send now, if one is due: faults before passes. What is taken out of `faults`
    /// and `passes` stays here until it is acknowledged.
    pub fn due(
        &mut self,
        now: Millis,
        period: Option<u16>,
        faults: &mut Faults,
        passes: &mut PassCounter,
    ) -> Option<Message> {
        if self.outstanding.is_none() {
            let content = self.next(now, period, faults, passes)?;
            self.number = self.number.wrapping_add(1);
            self.outstanding = Some(Outstanding { content, sent_at: None });
        }
        let report = self.name();
        let outstanding = self.outstanding.as_mut()?;
        if outstanding.sent_at.is_some_and(|sent_at| now.since(sent_at) < limits::REPEAT_INTERVAL) {
            return None;
        }
        outstanding.sent_at = Some(now);
        Some(match &outstanding.content {
            Content::Fault(code, active) => Message::Fault(Fault { report, code: *code, active: *active }),
            Content::Passes(passes) => Message::PassReport(PassReport { report, passes: passes.clone() }),
        })
    }

    const fn name(&self) -> ReportId {
        ReportId { boot: self.boot, number: self.number }
    }

    fn next(
        &mut self,
        now: Millis,
        period: Option<u16>,
        faults: &mut Faults,
        passes: &mut PassCounter,
    ) -> Option<Content> {
        if let Some((code, active)) = faults.take_change() {
            return Some(Content::Fault(code, active));
        }
        let taken_at = *self.passes_taken_at.get_or_insert(now);
        if now.since(taken_at) < PASS_INTERVAL {
            return None;
        }
        self.passes_taken_at = Some(now);
        let passes = passes.take(period);
        (!passes.is_empty()).then_some(Content::Passes(passes))
    }
}
