//! What can break in a pile, and how it is noticed.
//!
//! A silent reader and a welded contactor are faults for as long as they last. A contactor that
//! did not close stays a fault until the next start: told to open it agrees again, and nobody may
//! close it to see.

use heapless::Vec;
use protocol::{DurationMs, FaultCode, Millis};

/// A reader that has said nothing for this long is silent.
pub const READER_TIMEOUT: DurationMs = DurationMs(5_000);
/// A contactor has this long to do as it is told.
pub const CONTACTOR_TIMEOUT: DurationMs = DurationMs(500);

const CODES: [FaultCode; 3] =
    [FaultCode::ReaderSilent, FaultCode::ContactorWelded, FaultCode::ContactorStuckOpen];

/// The faults of a pile and the changes nobody was told of yet.
#[derive(Clone, Debug, Default)]
pub struct Faults {
    reader_heard: Option<Millis>,
    disagrees_since: Option<Millis>,
    active: Vec<FaultCode, { CODES.len() }>,
    untold: Vec<(FaultCode, bool), { 2 * CODES.len() }>,
}

impl Faults {
    /// All is well.
    #[must_use]
    pub const fn new() -> Self {
        Self { reader_heard: None, disagrees_since: None, active: Vec::new(), untold: Vec::new() }
    }

    /// The faults that are there now.
    #[must_use]
    pub fn active(&self) -> &[FaultCode] {
        &self.active
    }

    /// The reader answered.
    pub fn reader_answered(&mut self, now: Millis) {
        self.reader_heard = Some(now);
        self.set(FaultCode::ReaderSilent, false);
    }

    /// Whether the reader has answered within `time`, so that a tag it does not see is not there.
    #[must_use]
    pub fn reader_answered_within(&self, now: Millis, time: DurationMs) -> bool {
        self.reader_heard.is_some_and(|heard| now.since(heard) < time)
    }

    /// Time has passed; the reader's silence counts from the first call.
    pub fn tick(&mut self, now: Millis) {
        let heard = *self.reader_heard.get_or_insert(now);
        if now.since(heard) >= READER_TIMEOUT {
            self.set(FaultCode::ReaderSilent, true);
        }
    }

    /// The contactor is told something else and gets its time to do it.
    pub fn contactor_switched(&mut self) {
        self.disagrees_since = None;
    }

    /// The contactor is found `closed`, or open, while it is told to be `told_closed`.
    pub fn contactor_found(&mut self, now: Millis, closed: bool, told_closed: bool) {
        if !closed {
            self.set(FaultCode::ContactorWelded, false);
        }
        if closed == told_closed {
            self.disagrees_since = None;
        } else if now.since(*self.disagrees_since.get_or_insert(now)) >= CONTACTOR_TIMEOUT {
            let code = if closed { FaultCode::ContactorWelded } else { FaultCode::ContactorStuckOpen };
            self.set(code, true);
        }
    }

    /// The next change to report, in order. A fault that comes and goes faster than it can be
    /// reported is reported as having come and gone once.
    pub fn take_change(&mut self) -> Option<(FaultCode, bool)> {
        if self.untold.is_empty() { None } else { Some(self.untold.remove(0)) }
    }

    fn set(&mut self, code: FaultCode, active: bool) {
        if self.active.contains(&code) == active {
            return;
        }
        if active {
            // It fits: every code is there at most once.
            let _ = self.active.push(code);
        } else {
            self.active.retain(|&other| other != code);
        }
        // Changes of one fault alternate, so that the last of two and this one cancel out: at most
        // two of each wait.
        if self.untold.iter().filter(|(other, _)| *other == code).count() < 2 {
            let _ = self.untold.push((code, active));
        } else if let Some(last) = self.untold.iter().rposition(|(other, _)| *other == code) {
            self.untold.remove(last);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn changes(faults: &mut Faults) -> std::vec::Vec<(FaultCode, bool)> {
        core::iter::from_fn(|| faults.take_change()).collect()
    }

    #[test]
    fn a_reader_is_silent_after_its_timeout_and_heals_when_it_answers() {
        let mut faults = Faults::new();
        faults.tick(Millis(1_000));
        faults.tick(Millis(5_999));
        assert_eq!(faults.active(), []);
        faults.tick(Millis(6_000));
        assert_eq!(faults.active(), [FaultCode::ReaderSilent]);
        faults.reader_answered(Millis(6_100));
        assert_eq!(faults.active(), []);
        assert_eq!(changes(&mut faults), [(FaultCode::ReaderSilent, true), (FaultCode::ReaderSilent, false)]);
    }

    #[test]
    fn a_contactor_has_its_time_after_every_switch() {
        let mut faults = Faults::new();
        faults.contactor_found(Millis(0), false, true);
        faults.contactor_found(Millis(499), false, true);
        faults.contactor_switched();
        faults.contactor_found(Millis(600), true, false);
        faults.contactor_found(Millis(1_099), true, false);
        assert_eq!(faults.active(), []);
    }

    #[test]
    fn a_welded_contactor_heals_and_one_that_will_not_close_does_not() {
        let mut faults = Faults::new();
        faults.contactor_found(Millis(0), true, false);
        faults.contactor_found(Millis(500), true, false);
        assert_eq!(faults.active(), [FaultCode::ContactorWelded]);
        faults.contactor_found(Millis(600), false, false);
        assert_eq!(faults.active(), []);
        faults.contactor_found(Millis(700), false, true);
        faults.contactor_found(Millis(1_200), false, true);
        faults.contactor_found(Millis(1_300), false, false);
        assert_eq!(faults.active(), [FaultCode::ContactorStuckOpen]);
    }

    #[test]
    fn a_fault_that_flutters_is_told_as_come_and_gone() {
        let mut faults = Faults::new();
        faults.tick(Millis(0));
        for flutter in 1..100 {
            faults.tick(Millis(flutter * 5_000));
            faults.reader_answered(Millis(flutter * 5_000));
        }
        assert_eq!(changes(&mut faults), [(FaultCode::ReaderSilent, true), (FaultCode::ReaderSilent, false)]);
        for flutter in 200..301 {
            faults.tick(Millis(flutter * 5_000));
            if flutter < 300 {
                faults.reader_answered(Millis(flutter * 5_000));
            }
        }
        assert_eq!(changes(&mut faults), [(FaultCode::ReaderSilent, true)], "it stayed in the end");
    }
}
