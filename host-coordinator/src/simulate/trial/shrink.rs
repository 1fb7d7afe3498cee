//! The smallest run that still fails: by kinds of faults, robots, single faults, and time.
//!
//! A run with a fault less is another run, in which other things coincide. So where the seed does not fail
//! any more, some others are tried: what is wanted is a small run that fails in the same way, not the same
//! run. Nothing is proven minimal; what is found does fail, and its command line repeats it.

use std::mem;

use protocol::DurationMs;

use super::{Ground, Trial, faults::Fault, outcome::Failure};

/// How many other seeds are tried.
const OTHER_SEEDS: u64 = 12;

/// A trial that fails, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// The trial.
    pub trial: Trial,
    /// What becomes of it.
    pub failure: Failure,
}

impl Case {
    /// A trial that failed.
    #[must_use]
    pub fn new(trial: Trial, failure: Failure) -> Self {
        let mut case = Self { trial, failure };
        case.cut();
        case
    }

    /// The smallest that was found; `fails` says how a trial fails, if it does.
    #[must_use]
    pub fn shrunk(mut self, mut fails: impl FnMut(&Trial) -> Option<Failure>) -> Self {
        for fault in Fault::ALL {
            let faults = self.trial.faults.without(fault);
            if faults != self.trial.faults {
                self.attempt(Trial { faults, ..self.trial.clone() }, &mut fails);
            }
        }
        let fewer = [1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64];
        for robots in fewer.into_iter().take_while(|&robots| robots < self.trial.robots).collect::<Vec<_>>() {
            if self.attempt(Trial { robots, ..self.trial.clone() }, &mut fails) {
                break;
            }
        }
        self.fewer_faults(&mut fails);
        self
    }

    /// Leaves out the last faults, then the first ones.
    fn fewer_faults(&mut self, fails: &mut impl FnMut(&Trial) -> Option<Failure>) {
        let (mut few, mut many) = (self.trial.only.start, self.trial.only.end);
        while few < many {
            let end = few + (many - few) / 2;
            let only = self.trial.only.start..end;
            if self.attempt(Trial { only, ..self.trial.clone() }, fails) {
                many = end;
            } else {
                few = end + 1;
            }
        }
        let (mut few, mut many) = (self.trial.only.start, self.trial.only.end);
        while few < many {
            let start = few + (many - few).div_ceil(2);
            let only = start..self.trial.only.end;
            if self.attempt(Trial { only, ..self.trial.clone() }, fails) {
                few = start;
            } else {
                many = start - 1;
            }
        }
    }

    /// Takes a smaller trial if it fails in the same way.
    fn attempt(&mut self, trial: Trial, fails: &mut impl FnMut(&Trial) -> Option<Failure>) -> bool {
        let same =
            |failure: &Failure| mem::discriminant(&failure.breach) == mem::discriminant(&self.failure.breach);
        let found = (0..=OTHER_SEEDS).find_map(|other| {
            let trial = Trial { seed: trial.seed.wrapping_add(other), ..trial.clone() };
            fails(&trial).filter(same).map(|failure| Self::new(trial, failure))
        });
        let is_found = found.is_some();
        *self = found.unwrap_or_else(|| self.clone());
        is_found
    }

    /// Nothing after the failure matters.
    fn cut(&mut self) {
        self.trial.duration = DurationMs::saturating(self.failure.at.0 + 1);
        self.trial.only.end = self.trial.only.end.min(self.failure.struck);
        self.trial.only.start = self.trial.only.start.min(self.trial.only.end);
    }
}

/// How `trial` fails on `ground`, if it does.
#[must_use]
pub fn failure(ground: &Ground, trial: &Trial) -> Option<Failure> {
    trial.run(ground).failure
}

#[cfg(test)]
mod tests {
    use protocol::{Millis, PileId};

    use super::{
        super::{breach::Breach, faults::Faults},
        *,
    };

    /// Fails when a pile crashes as fault 137 among at least three robots.
    fn fails(trial: &Trial) -> Option<Failure> {
        let needed = trial.faults.contains(Fault::PileCrash)
            && trial.only.contains(&137)
            && trial.robots >= 3
            && trial.duration > DurationMs(70_000);
        needed.then_some(Failure {
            at: Millis(70_000),
            breach: Breach::Unleased { pile: PileId(1) },
            struck: 200,
        })
    }

    #[test]
    fn a_failing_run_shrinks_to_what_it_needs() {
        let trial = Trial {
            seed: 5,
            robots: 50,
            duration: DurationMs(3_600_000),
            faults: Faults::ALL,
            only: 0..u64::MAX,
        };
        let failure = fails(&trial).unwrap();
        let smallest = Case::new(trial, failure).shrunk(fails).trial;
        let expected = Trial {
            seed: 5,
            robots: 3,
            duration: DurationMs(70_001),
            faults: Faults::NONE.with(Fault::PileCrash),
            only: 137..138,
        };
        assert_eq!(smallest, expected);
    }
}
