//! How the contacts become live and dead: the contactor switches at no current, and the current
//! follows ramps. Only what cannot wait opens it under load.
//!
//! ```text
//!  open ──▶ closed, no current ──▶ current ramps up ──▶ at the limit
//!   ▲                │                    │                 │
//!   └─── no current, or STOP_TIME over ◀──┴─ ramps down ◀───┘
//! ```
//! A stop that has begun is finished, even if its reason goes away meanwhile: then the contactor
//! rests open for [`REST_TIME`], so that a contact that chatters does not wear it out.

use protocol::{DurationMs, Millis};

use super::Limits;

/// The current is at the limit this long after it begins.
pub const RAMP_UP_TIME: DurationMs = DurationMs(1_000);
/// A current at the highest limit is taken away within this time.
pub const RAMP_DOWN_TIME: DurationMs = DurationMs(100);
/// The power stage is given this long to follow the end of a ramp, whatever the current's sensor says:
/// it may be what is broken.
pub const SETTLING_TIME: DurationMs = DurationMs(50);
/// The contactor is told to open this long after a stop has begun, at the latest.
pub const STOP_TIME: DurationMs = DurationMs(300);
/// A contactor that was opened stays open this long.
pub const REST_TIME: DurationMs = DurationMs(1_000);

/// The contactor's command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contactor {
    /// The contacts are dead.
    Open,
    /// The contacts are connected with the power stage.
    Closed,
}

/// What the power stage and its contactor shall do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Power {
    /// The contactor's command.
    pub contactor: Contactor,
    /// The most the power stage may give, in amperes, finite and at least 0; always 0 while the
    /// contactor is told to be open.
    pub current_limit_a: f32,
}

impl Power {
    /// Nothing is given, and nothing is connected.
    pub const OFF: Self = Self { contactor: Contactor::Open, current_limit_a: 0.0 };

    /// Whether the contacts are connected with the power stage.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.contactor == Contactor::Closed
    }
}

impl Default for Power {
    fn default() -> Self {
        Self::OFF
    }
}

/// What may be given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Permit {
    /// As much as this, in amperes.
    UpTo(f32),
    /// Nothing any more.
    Nothing,
    /// Nothing, and the contactor must not wait for the current to go.
    OpenNow,
}

/// What the contacts were found to do last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// When.
    pub at: Millis,
    /// Whether the contactor is found closed.
    pub closed: bool,
    /// The current, in amperes, if it is known.
    pub current_a: Option<f32>,
}

/// Where between open and the limit the power is. Ramps go from one look at the contacts to the
/// next.
#[derive(Clone, Debug)]
pub struct Sequence {
    power: Power,
    looked_at: Millis,
    stopping_since: Option<Millis>,
    /// Since when a stop tells the power stage to give nothing.
    nothing_since: Option<Millis>,
    opened_at: Option<Millis>,
}

impl Sequence {
    /// Open.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            power: Power::OFF,
            looked_at: Millis(0),
            stopping_since: None,
            nothing_since: None,
            opened_at: None,
        }
    }

    /// The command in force.
    #[must_use]
    pub const fn power(&self) -> Power {
        self.power
    }

    /// The command from now on.
    pub fn command(&mut self, now: Millis, limits: &Limits, permit: Permit, found: Found) -> Power {
        // A look that comes late makes no ramp steeper.
        let passed = found.at.since(self.looked_at).min(RAMP_DOWN_TIME);
        self.looked_at = found.at;
        if !self.power.is_closed() {
            if let Permit::UpTo(_) = permit
                && self.opened_at.is_none_or(|opened| now.since(opened) >= REST_TIME)
            {
                self.power.contactor = Contactor::Closed;
            }
            return self.power;
        }
        match permit {
            Permit::OpenNow => self.open(now),
            Permit::UpTo(limit_a) if self.stopping_since.is_none() => {
                // Nothing flows through a contactor that is not closed yet, or not any more.
                let target_a = if found.closed { limit_a } else { 0.0 };
                self.approach(target_a, limits.current_max_a, passed);
            }
            Permit::UpTo(_) | Permit::Nothing => self.stop(now, limits, passed, found),
        }
        self.power
    }

    fn stop(&mut self, now: Millis, limits: &Limits, passed: DurationMs, found: Found) {
        let since = *self.stopping_since.get_or_insert(now);
        self.approach(0.0, limits.current_max_a, passed);
        if self.power.current_limit_a == 0.0 {
            self.nothing_since.get_or_insert(now);
        }
        let has_settled = self.nothing_since.is_some_and(|nothing| now.since(nothing) >= SETTLING_TIME);
        let is_nothing = found.current_a.is_some_and(|current_a| current_a.abs() < limits.zero_a());
        if (has_settled && is_nothing) || now.since(since) >= STOP_TIME {
            self.open(now);
        }
    }

    const fn open(&mut self, now: Millis) {
        self.power = Power::OFF;
        self.stopping_since = None;
        self.nothing_since = None;
        self.opened_at = Some(now);
    }

    /// Moves the limit towards `target_a`, by as much as ramps of `full_a` have for the time.
    fn approach(&mut self, target_a: f32, full_a: f32, passed: DurationMs) {
        let share = |time: DurationMs| full_a * (passed.0 as f32 / time.0 as f32);
        let before = self.power.current_limit_a;
        let limit_a = target_a.min(before + share(RAMP_UP_TIME)).max(before - share(RAMP_DOWN_TIME));
        self.power.current_limit_a = if limit_a.is_finite() { limit_a.max(0.0) } else { 0.0 };
    }
}

impl Default for Sequence {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits::new(500.0);

    /// A power stage that follows its limit at once, and its contactor.
    struct Bench {
        sequence: Sequence,
        now: Millis,
        obeys: bool,
    }

    impl Bench {
        fn new() -> Self {
            Self { sequence: Sequence::new(), now: Millis(0), obeys: true }
        }

        fn step(&mut self, permit: Permit) -> Power {
            self.now.0 += 10;
            let before = self.sequence.power();
            let current_a = if self.obeys { before.current_limit_a } else { 20.0 };
            let found = Found { at: self.now, closed: before.is_closed(), current_a: Some(current_a) };
            self.sequence.command(self.now, &LIMITS, permit, found)
        }

        fn full() -> Self {
            let mut bench = Self::new();
            for _ in 0..102 {
                bench.step(Permit::UpTo(20.0));
            }
            assert_eq!(bench.sequence.power().current_limit_a, 20.0);
            bench
        }
    }

    #[test]
    fn the_contactor_closes_at_no_current_and_the_limit_rises_on_a_ramp() {
        let mut bench = Bench::new();
        assert_eq!(
            bench.step(Permit::UpTo(20.0)),
            Power { contactor: Contactor::Closed, current_limit_a: 0.0 }
        );
        let mut before = 0.0;
        for _ in 0..79 {
            let limit_a = bench.step(Permit::UpTo(20.0)).current_limit_a;
            assert!((limit_a - before - 0.25).abs() < 1e-4);
            before = limit_a;
        }
    }

    #[test]
    fn a_contactor_that_is_not_closed_gets_no_current() {
        let mut sequence = Sequence::new();
        for step in 0..100 {
            let found = Found { at: Millis(step * 10), closed: false, current_a: Some(0.0) };
            let power = sequence.command(found.at, &LIMITS, Permit::UpTo(20.0), found);
            assert_eq!(power.current_limit_a, 0.0);
        }
    }

    #[test]
    fn a_stop_brings_the_current_to_nothing_before_the_contactor_opens() {
        let mut bench = Bench::full();
        let mut before = 20.0;
        let steps = (1..).find(|_| {
            let power = bench.step(Permit::Nothing);
            assert!(power.is_closed() || before == 0.0, "opened at {before} A");
            before = power.current_limit_a;
            !power.is_closed()
        });
        assert_eq!(steps, Some(13), "eight steps of 2.5 A, and 50 ms at nothing");
    }

    #[test]
    fn a_current_that_does_not_go_is_waited_for_no_longer_than_the_bound() {
        let mut bench = Bench::full();
        bench.obeys = false;
        let steps = (1..).find(|_| !bench.step(Permit::Nothing).is_closed());
        assert_eq!(steps, Some(31));
    }

    #[test]
    fn what_cannot_wait_opens_in_the_same_step() {
        let mut bench = Bench::full();
        assert_eq!(bench.step(Permit::OpenNow), Power::OFF);
    }

    #[test]
    fn a_stop_that_has_begun_is_finished_and_followed_by_a_rest() {
        let mut bench = Bench::full();
        bench.step(Permit::Nothing);
        let opened = (1..).find(|_| !bench.step(Permit::UpTo(20.0)).is_closed());
        assert_eq!(opened, Some(12));
        let closed = (1..).find(|_| bench.step(Permit::UpTo(20.0)).is_closed());
        assert_eq!(closed, Some(100));
    }
}
