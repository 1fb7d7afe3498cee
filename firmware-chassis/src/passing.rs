//! Which piles the robot passes, by the tags on them (LMPP eq. 4): counted by period of the day and
//! reported until acknowledged, one report at a time and in order.
//!
//! The period needs the site's time, for which the robot's computer is asked; it passes on the
//! coordinator's.

use firmware_common::{
    clock::SiteClock,
    passes::{PassCounter, PassRule, period_of},
    reader::TagRead,
};
use protocol::{BootEpoch, DurationMs, Millis, PassReport, ReportId, TimeRequest, TimeSync, limits};

/// How long passes are collected before they are reported.
pub const PASS_INTERVAL: DurationMs = DurationMs(2_000);

/// How a day is divided, and what a pass is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PassParameters {
    /// What a pass is (eq. 4).
    pub rule: PassRule,
    /// The length of a period (lambda).
    pub period: DurationMs,
    /// Periods of a day.
    pub periods: u16,
}

/// Passes, and their report under way.
#[derive(Clone, Debug)]
pub struct Passing {
    parameters: PassParameters,
    boot: BootEpoch,
    clock: SiteClock,
    counter: PassCounter,
    /// The number of the report under way, or else of the last.
    number: u32,
    outstanding: Option<PassReport>,
    sent_at: Option<Millis>,
    taken_at: Option<Millis>,
}

impl Passing {
    /// No pile was passed in the start `boot`.
    #[must_use]
    pub const fn new(parameters: PassParameters, boot: BootEpoch) -> Self {
        Self {
            parameters,
            boot,
            clock: SiteClock::new(),
            counter: PassCounter::new(parameters.rule),
            number: 0,
            outstanding: None,
            sent_at: None,
            taken_at: None,
        }
    }

    /// The reader read a tag.
    pub fn read(&mut self, now: Millis, read: TagRead) {
        self.counter.read(now, self.period(now), read.tag, read.rssi_dbm);
    }

    /// The site's time arrived.
    pub fn synchronise(&mut self, now: Millis, sync: &TimeSync) {
        self.clock.accept(now, sync);
    }

    /// The question for the site's time, if one is due.
    pub fn time_request(&mut self, now: Millis) -> Option<TimeRequest> {
        self.clock.request(now, false)
    }

    /// Report `of` has arrived.
    pub fn acknowledged(&mut self, of: ReportId) {
        if of == self.name() {
            self.outstanding = None;
        }
    }

    /// The report to send now, if one is due: a new one, or one that was not acknowledged.
    pub fn due(&mut self, now: Millis) -> Option<PassReport> {
        let is_new = self.outstanding.is_none();
        if is_new {
            let taken_at = *self.taken_at.get_or_insert(now);
            if now.since(taken_at) < PASS_INTERVAL {
                return None;
            }
            self.taken_at = Some(now);
            let passes = self.counter.take(self.period(now));
            if passes.is_empty() {
                return None;
            }
            self.number = self.number.wrapping_add(1);
            self.outstanding = Some(PassReport { report: self.name(), passes });
        } else if self.sent_at.is_some_and(|sent_at| now.since(sent_at) < limits::REPEAT_INTERVAL) {
            return None;
        }
        self.sent_at = Some(now);
        self.outstanding.clone()
    }

    const fn name(&self) -> ReportId {
        ReportId { boot: self.boot, number: self.number }
    }

    fn period(&self, now: Millis) -> Option<u16> {
        let PassParameters { period, periods, .. } = self.parameters;
        self.clock.site_now(now).map(|site_now| period_of(site_now, period, periods))
    }
}
