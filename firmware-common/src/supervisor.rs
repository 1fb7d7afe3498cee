//! The watchdog is fed only if every task has checked in.
//!
//! Each task holds a [`Place`] on a [`Roll`] and checks in at least once a [`PERIOD`], also while
//! it waits. Once a period the supervisor calls the roll; the watchdog is fed if nobody is missing.
//! A task that hangs, and one that keeps its executor from running, thus both end in a reset.

use core::sync::atomic::{AtomicU32, Ordering};

use protocol::DurationMs;

/// How often the roll is called. A watchdog whose time is three of these forgives one late call.
pub const PERIOD: DurationMs = DurationMs(100);

/// Who has checked in since the roll was called last. Tasks of any priority share one.
#[derive(Debug)]
pub struct Roll<const TASKS: usize> {
    present: AtomicU32,
}

/// A task's place on a [`Roll`].
#[derive(Clone, Copy, Debug)]
pub struct Place {
    present: &'static AtomicU32,
    bit: u32,
}

/// Tasks that did not check in, as bits in the order of their places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Missing(pub u32);

impl<const TASKS: usize> Roll<TASKS> {
    const ALL: u32 = {
        assert!(TASKS < 32, "a roll has at most 31 places");
        (1 << TASKS) - 1
    };

    /// Nobody has checked in.
    #[must_use]
    pub const fn new() -> Self {
        Self { present: AtomicU32::new(0) }
    }

    /// Every task's place.
    pub fn places(&'static self) -> [Place; TASKS] {
        core::array::from_fn(|index| Place { present: &self.present, bit: 1 << index })
    }

    /// Calls the roll: everybody has to check in anew.
    ///
    /// # Errors
    /// [`Missing`] names who did not check in since the last call.
    pub fn call(&self) -> Result<(), Missing> {
        let missing = Self::ALL & !self.present.swap(0, Ordering::AcqRel);
        if missing == 0 { Ok(()) } else { Err(Missing(missing)) }
    }
}

impl<const TASKS: usize> Default for Roll<TASKS> {
    fn default() -> Self {
        Self::new()
    }
}

impl Place {
    /// The task is alive.
    pub fn check_in(self) {
        self.present.fetch_or(self.bit, Ordering::AcqRel);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_full_roll_feeds_and_it_feeds_once() {
        static ROLL: Roll<3> = Roll::new();
        let [first, second, third] = ROLL.places();
        assert_eq!(ROLL.call(), Err(Missing(0b111)));
        [first, third, third].into_iter().for_each(Place::check_in);
        assert_eq!(ROLL.call(), Err(Missing(0b010)));
        second.check_in();
        assert_eq!(ROLL.call(), Err(Missing(0b101)), "who was there last time has to check in again");
        [first, second, third].into_iter().for_each(Place::check_in);
        assert_eq!(ROLL.call(), Ok(()));
        assert_eq!(ROLL.call(), Err(Missing(0b111)));
    }
}
