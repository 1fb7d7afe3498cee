//! What is wrong with a pile, since when, and what of it nobody was told yet.
//!
//! A fault is *active* from the moment its cause is found until the cause has been gone for
//! [`HEALING_TIME`]. A fault that says that the pile itself may be damaged is also *latched*
//! ([`LATCHING`]): it outlives its cause and every restart until somebody who may clears it. Faults
//! that come from outside and go with it are not: a reader that is silent, a robot with reversed
//! contacts, an emergency stop, lost mains.

use heapless::Vec;
use protocol::{DurationMs, FaultCode, FaultState, Millis, PileFaults};

/// A reader that has said nothing for this long is silent.
pub const READER_TIMEOUT: DurationMs = DurationMs(5_000);
/// A fault is over when its cause has been gone for this long, so that one that flutters is one.
pub const HEALING_TIME: DurationMs = DurationMs(1_000);

/// Faults that outlive their cause.
pub const LATCHING: FaultSet = FaultSet::of(&[
    FaultCode::ContactorWelded,
    FaultCode::ContactorStuckOpen,
    FaultCode::OverCurrent,
    FaultCode::OverVoltage,
    FaultCode::OverTemperature,
    FaultCode::StrayCurrent,
    FaultCode::VoltageSensor,
    FaultCode::CurrentSensor,
    FaultCode::TemperatureSensor,
]);

/// A set of faults: a bit for each code, at its number on the wire.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FaultSet(u32);

impl FaultSet {
    /// None.
    pub const EMPTY: Self = Self(0);

    /// These.
    #[must_use]
    pub const fn of(codes: &[FaultCode]) -> Self {
        let mut bits = 0;
        let mut rest = codes;
        while let [code, others @ ..] = rest {
            bits |= bit(*code);
            rest = others;
        }
        Self(bits)
    }

    /// The bits, for a store.
    #[must_use]
    pub const fn bits(self) -> u32 {
        self.0
    }

    /// The set with these bits; bits of no code are dropped.
    #[must_use]
    pub const fn from_bits(bits: u32) -> Self {
        Self(bits & Self::of(&FaultCode::ALL).0)
    }

    /// Whether there is none.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether `code` is in it.
    #[must_use]
    pub const fn contains(self, code: FaultCode) -> bool {
        self.0 & bit(code) != 0
    }

    /// Puts `code` in.
    pub const fn insert(&mut self, code: FaultCode) {
        self.0 |= bit(code);
    }

    /// Takes `code` out.
    pub const fn remove(&mut self, code: FaultCode) {
        self.0 &= !bit(code);
    }

    /// What is in one of both.
    #[must_use]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// What is in both.
    #[must_use]
    pub const fn intersection(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// What is in this one only.
    #[must_use]
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// The codes, in their order on the wire.
    pub fn iter(self) -> impl Iterator<Item = FaultCode> {
        FaultCode::ALL.into_iter().filter(move |&code| self.contains(code))
    }
}

const fn bit(code: FaultCode) -> u32 {
    1 << code as u32
}

/// The faults of a pile and the changes nobody was told of yet.
#[derive(Clone, Debug)]
pub struct Faults {
    reader_heard: Option<Millis>,
    /// Whose cause was there at the last look.
    caused: FaultSet,
    /// When that was, by the code's number.
    caused_at: [Millis; FaultCode::ALL.len()],
    active: FaultSet,
    latched: FaultSet,
    untold: Vec<(FaultCode, bool), { 2 * FaultCode::ALL.len() }>,
}

impl Faults {
    /// What was `latched` before the restart is still there, and has to be told again.
    #[must_use]
    pub fn new(latched: FaultSet) -> Self {
        let latched = latched.intersection(LATCHING);
        Self {
            reader_heard: None,
            caused: FaultSet::EMPTY,
            caused_at: [Millis(0); FaultCode::ALL.len()],
            active: FaultSet::EMPTY,
            latched,
            untold: latched.iter().map(|code| (code, true)).collect(),
        }
    }

    /// The faults whose cause is there, or was just now.
    #[must_use]
    pub const fn active(&self) -> FaultSet {
        self.active
    }

    /// The faults that wait to be cleared.
    #[must_use]
    pub const fn latched(&self) -> FaultSet {
        self.latched
    }

    /// The faults for which the pile must not be used.
    #[must_use]
    pub const fn standing(&self) -> FaultSet {
        self.active.union(self.latched)
    }

    /// All that stands, as it is told.
    #[must_use]
    pub fn told(&self) -> PileFaults {
        let state = |code| FaultState {
            code,
            active: self.active.contains(code),
            latched: self.latched.contains(code),
        };
        PileFaults { faults: self.standing().iter().map(state).collect() }
    }

    /// The reader answered.
    pub const fn reader_answered(&mut self, now: Millis) {
        self.reader_heard = Some(now);
        self.caused.remove(FaultCode::ReaderSilent);
    }

    /// Whether the reader has answered within `time`, so that a tag it does not see is not there.
    #[must_use]
    pub fn reader_answered_within(&self, now: Millis, time: DurationMs) -> bool {
        self.reader_heard.is_some_and(|heard| now.since(heard) < time)
    }

    /// Of the faults that can be `seen` by a look at something, these causes were `found`.
    pub fn look(&mut self, now: Millis, seen: FaultSet, found: FaultSet) {
        self.caused = self.caused.without(seen).union(found.intersection(seen));
        self.tick(now);
    }

    /// Time has passed; the reader's silence counts from the first call.
    pub fn tick(&mut self, now: Millis) {
        let heard = *self.reader_heard.get_or_insert(now);
        if now.since(heard) >= READER_TIMEOUT {
            self.caused.insert(FaultCode::ReaderSilent);
        }
        for code in self.caused.union(self.active).iter() {
            let Some(caused_at) = self.caused_at.get_mut(code as usize) else { continue };
            if self.caused.contains(code) {
                *caused_at = now;
                let known = self.standing().contains(code);
                self.active.insert(code);
                if LATCHING.contains(code) {
                    self.latched.insert(code);
                }
                if !known {
                    self.tell(code, true);
                }
            } else if now.since(*caused_at) >= HEALING_TIME {
                self.active.remove(code);
                if !self.latched.contains(code) {
                    self.tell(code, false);
                }
            }
        }
    }

    /// Clears a latched fault. Answers whether it is gone: one whose cause is there stays.
    pub fn clear(&mut self, code: FaultCode) -> bool {
        if self.active.contains(code) {
            return false;
        }
        if self.latched.contains(code) {
            self.latched.remove(code);
            self.tell(code, false);
        }
        true
    }

    /// The next change to report, in order: a fault that stands from now on, or does no more. One
    /// that comes and goes faster than it can be reported is reported as having come and gone once.
    pub fn take_change(&mut self) -> Option<(FaultCode, bool)> {
        if self.untold.is_empty() { None } else { Some(self.untold.remove(0)) }
    }

    /// Changes of one fault alternate, so that the last of two and this one cancel out: at most two
    /// of each wait, and all fit.
    fn tell(&mut self, code: FaultCode, stands: bool) {
        if self.untold.iter().filter(|(other, _)| *other == code).count() < 2 {
            let _ = self.untold.push((code, stands));
        } else if let Some(last) = self.untold.iter().rposition(|(other, _)| *other == code) {
            self.untold.remove(last);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WELDED: FaultSet = FaultSet::of(&[FaultCode::ContactorWelded]);
    const REVERSED: FaultSet = FaultSet::of(&[FaultCode::ReversedPolarity]);

    fn faults() -> Faults {
        Faults::new(FaultSet::EMPTY)
    }

    fn changes(faults: &mut Faults) -> std::vec::Vec<(FaultCode, bool)> {
        core::iter::from_fn(|| faults.take_change()).collect()
    }

    fn codes(set: FaultSet) -> std::vec::Vec<FaultCode> {
        set.iter().collect()
    }

    #[test]
    fn every_code_has_its_own_bit_at_its_number() {
        for (number, code) in FaultCode::ALL.into_iter().enumerate() {
            assert_eq!(code as usize, number);
            assert_eq!(codes(FaultSet::of(&[code])), [code]);
        }
    }

    #[test]
    fn a_reader_is_silent_after_its_timeout_and_heals_when_it_answers() {
        let mut faults = faults();
        faults.tick(Millis(1_000));
        faults.tick(Millis(5_999));
        assert!(faults.standing().is_empty());
        faults.tick(Millis(6_000));
        assert_eq!(codes(faults.standing()), [FaultCode::ReaderSilent]);
        faults.reader_answered(Millis(6_100));
        faults.tick(Millis(6_999));
        assert_eq!(codes(faults.standing()), [FaultCode::ReaderSilent]);
        faults.tick(Millis(7_000));
        assert!(faults.standing().is_empty());
        assert_eq!(changes(&mut faults), [(FaultCode::ReaderSilent, true), (FaultCode::ReaderSilent, false)]);
    }

    #[test]
    fn a_latched_fault_outlives_its_cause_until_it_is_cleared() {
        let mut faults = faults();
        faults.look(Millis(0), WELDED, WELDED);
        assert!(!faults.clear(FaultCode::ContactorWelded), "its cause is there");
        faults.look(Millis(10), WELDED, FaultSet::EMPTY);
        assert!(!faults.clear(FaultCode::ContactorWelded), "its cause was there just now");
        faults.look(Millis(1_010), WELDED, FaultSet::EMPTY);
        assert_eq!((faults.active(), faults.latched()), (FaultSet::EMPTY, WELDED));
        assert_eq!(changes(&mut faults), [(FaultCode::ContactorWelded, true)], "it still stands");
        assert!(faults.clear(FaultCode::ContactorWelded));
        assert!(faults.standing().is_empty());
        assert!(faults.clear(FaultCode::ContactorWelded), "clearing is idempotent");
        assert_eq!(changes(&mut faults), [(FaultCode::ContactorWelded, false)]);
    }

    #[test]
    fn a_latched_fault_outlives_a_restart_and_is_told_again() {
        let mut faults = Faults::new(WELDED.union(REVERSED));
        assert_eq!(faults.standing(), WELDED, "what never latches was not latched");
        assert_eq!(changes(&mut faults), [(FaultCode::ContactorWelded, true)]);
    }

    #[test]
    fn a_look_says_nothing_about_what_it_cannot_see() {
        let mut faults = faults();
        faults.look(Millis(0), REVERSED, REVERSED);
        faults.look(Millis(4_000), WELDED, FaultSet::EMPTY);
        assert_eq!(faults.active(), REVERSED);
    }

    #[test]
    fn a_fault_that_flutters_is_told_as_come_and_gone() {
        let mut faults = faults();
        let code = FaultCode::ReversedPolarity;
        for flutter in 0..100 {
            faults.look(Millis(flutter * 4_000), REVERSED, REVERSED);
            faults.reader_answered(Millis(flutter * 4_000));
            faults.look(Millis(flutter * 4_000 + 1_000), REVERSED, FaultSet::EMPTY);
        }
        assert_eq!(changes(&mut faults), [(code, true), (code, false)]);
        for flutter in 0..100 {
            faults.reader_answered(Millis(400_000 + flutter * 999));
            faults.look(Millis(400_000 + flutter * 999), REVERSED, FaultSet::EMPTY);
            faults.look(Millis(400_000 + flutter * 999), REVERSED, REVERSED);
        }
        assert_eq!(changes(&mut faults), [(code, true)], "it never healed");
    }
}
