//! What can go wrong, and when it does.
//!
//! Every kind of fault has its own source of chance, so that leaving one kind out moves the others as
//! little as possible. The faults of a run are numbered as they strike; a run can be told to let only
//! some of them happen, which is how a failing run is made small.

use std::{fmt, ops::Range, str::FromStr};

use protocol::DurationMs;

use super::super::random::Random;

/// A kind of fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// A frame is lost.
    Loss,
    /// A frame takes up to five seconds.
    Delay,
    /// A frame arrives twice.
    Duplicate,
    /// A frame overtakes others.
    Reorder,
    /// Some devices and the coordinator don't hear each other for up to a minute.
    Partition,
    /// A pile loses its power, perhaps while it stores something, and starts anew.
    PileCrash,
    /// A robot's computer starts anew.
    RobotCrash,
    /// The coordinator crashes, perhaps between recording events and their effects, and starts anew.
    CoordinatorCrash,
    /// The coordinator's computer starts anew with another time.
    Clock,
    /// The coordinator is away for minutes, in which robots and piles settle by themselves who charges.
    Outage,
}

impl Fault {
    /// All kinds.
    pub const ALL: [Self; 10] = [
        Self::Loss,
        Self::Delay,
        Self::Duplicate,
        Self::Reorder,
        Self::Partition,
        Self::PileCrash,
        Self::RobotCrash,
        Self::CoordinatorCrash,
        Self::Clock,
        Self::Outage,
    ];

    /// What it is called on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Loss => "loss",
            Self::Delay => "delay",
            Self::Duplicate => "duplicate",
            Self::Reorder => "reorder",
            Self::Partition => "partition",
            Self::PileCrash => "pile-crash",
            Self::RobotCrash => "robot-crash",
            Self::CoordinatorCrash => "coordinator-crash",
            Self::Clock => "clock",
            Self::Outage => "outage",
        }
    }

    /// How likely it strikes a frame; 0 for a fault that strikes by the clock.
    const fn chance(self) -> f64 {
        match self {
            Self::Loss | Self::Duplicate => 0.03,
            Self::Delay => 0.01,
            Self::Reorder => 0.1,
            _ => 0.0,
        }
    }

    /// How often it strikes on average, in the whole site of `piles` and `robots`, in seconds; `None` for
    /// a fault that strikes frames.
    fn mean_s(self, piles: usize, robots: usize) -> Option<f64> {
        match self {
            Self::Loss | Self::Delay | Self::Duplicate | Self::Reorder => None,
            Self::Partition => Some(300.0),
            Self::PileCrash => Some(2_400.0 / piles.max(1) as f64),
            Self::RobotCrash => Some(3_600.0 / robots.max(1) as f64),
            Self::CoordinatorCrash => Some(400.0),
            Self::Clock => Some(1_200.0),
            Self::Outage => Some(2_400.0),
        }
    }
}

/// Some kinds of faults.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Faults(u16);

impl Faults {
    /// No fault at all.
    pub const NONE: Self = Self(0);
    /// Every kind but an outage, in which nobody decides for the whole site: that has to be named.
    pub const ALL: Self = Self((1 << Fault::ALL.len()) - 1).without(Fault::Outage);

    /// Whether `fault` is one of them.
    #[must_use]
    pub const fn contains(self, fault: Fault) -> bool {
        self.0 & (1 << fault as u16) != 0
    }

    /// These and `fault`.
    #[must_use]
    pub const fn with(self, fault: Fault) -> Self {
        Self(self.0 | (1 << fault as u16))
    }

    /// These but `fault`.
    #[must_use]
    pub const fn without(self, fault: Fault) -> Self {
        Self(self.0 & !(1 << fault as u16))
    }

    /// The kinds.
    pub fn iter(self) -> impl Iterator<Item = Fault> {
        Fault::ALL.into_iter().filter(move |&fault| self.contains(fault))
    }
}

/// A word is no kind of fault.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "\"{word}\" is no kind of fault: name none, all, or some of {}, with commas between",
    names(Fault::ALL)
)]
pub struct UnknownFault {
    /// The word.
    word: String,
}

fn names(faults: impl IntoIterator<Item = Fault>) -> String {
    faults.into_iter().map(Fault::name).collect::<Vec<_>>().join(",")
}

impl FromStr for Faults {
    type Err = UnknownFault;

    fn from_str(text: &str) -> Result<Self, UnknownFault> {
        if text == "none" {
            return Ok(Self::NONE);
        }
        text.split(',').try_fold(Self::NONE, |faults, word| {
            if word.trim() == "all" {
                return Ok(Self(faults.0 | Self::ALL.0));
            }
            let named = Fault::ALL.into_iter().find(|fault| fault.name() == word.trim());
            named.map(|fault| faults.with(fault)).ok_or_else(|| UnknownFault { word: word.to_owned() })
        })
    }
}

impl fmt::Display for Faults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NONE => f.write_str("none"),
            Self::ALL => f.write_str("all"),
            some => f.write_str(&names(some.iter())),
        }
    }
}

/// Says when faults strike in one run.
#[derive(Clone, Debug)]
pub struct Troubles {
    faults: Faults,
    only: Range<u64>,
    struck: u64,
    chances: [Random; Fault::ALL.len()],
}

impl Troubles {
    /// The faults of the run of `seed`: of those that strike, only the ones numbered `only` happen.
    #[must_use]
    pub fn new(seed: u64, faults: Faults, only: Range<u64>) -> Self {
        let chances = Fault::ALL.map(|fault| Random::new(seed, 0x1_0000 + fault as u64));
        Self { faults, only, struck: 0, chances }
    }

    /// How many have struck, whether or not they were let happen.
    #[must_use]
    pub const fn struck(&self) -> u64 {
        self.struck
    }

    /// The source of chance of one kind.
    pub fn chance(&mut self, fault: Fault) -> &mut Random {
        let [loss, delay, duplicate, reorder, partition, pile, robot, coordinator, clock, outage] =
            &mut self.chances;
        match fault {
            Fault::Loss => loss,
            Fault::Delay => delay,
            Fault::Duplicate => duplicate,
            Fault::Reorder => reorder,
            Fault::Partition => partition,
            Fault::PileCrash => pile,
            Fault::RobotCrash => robot,
            Fault::CoordinatorCrash => coordinator,
            Fault::Clock => clock,
            Fault::Outage => outage,
        }
    }

    /// Whether a fault strikes a frame now.
    pub fn strikes(&mut self, fault: Fault) -> bool {
        self.faults.contains(fault) && self.chance(fault).between(0.0, 1.0) < fault.chance() && self.happens()
    }

    /// Whether a fault that strikes now is one of those that happen.
    pub fn happens(&mut self) -> bool {
        let number = self.struck;
        self.struck += 1;
        self.only.contains(&number)
    }

    /// How long it takes until a fault strikes the next time, if it strikes by the clock: between half and
    /// one and a half times its mean.
    pub fn next(&mut self, fault: Fault, piles: usize, robots: usize) -> Option<DurationMs> {
        let mean_s = fault.mean_s(piles, robots).filter(|_| self.faults.contains(fault))?;
        Some(DurationMs::from_seconds((mean_s * self.chance(fault).between(0.5, 1.5)) as f32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_said_of_faults_is_what_was_read() {
        for text in ["none", "all", "loss", "delay,clock", "partition,pile-crash,coordinator-crash"] {
            assert_eq!(text.parse::<Faults>().unwrap().to_string(), text);
        }
        let more = Faults::ALL.with(Fault::Outage);
        assert_eq!("all,outage".parse::<Faults>().unwrap(), more);
        assert_eq!(more.to_string().parse::<Faults>().unwrap(), more);
        assert_eq!("clock, loss".parse::<Faults>().unwrap().to_string(), "loss,clock");
        let error = "loss,fire".parse::<Faults>().unwrap_err().to_string();
        assert!(error.contains("\"fire\"") && error.contains("pile-crash"), "{error}");
    }

    #[test]
    fn faults_that_are_left_out_neither_strike_nor_count() {
        let mut troubles = Troubles::new(1, Faults::NONE.with(Fault::Loss), 0..u64::MAX);
        assert!((0..1_000).all(|_| !troubles.strikes(Fault::Duplicate)));
        assert_eq!(troubles.next(Fault::Clock, 1, 1), None);
        assert_eq!(troubles.struck(), 0);
        assert!((0..1_000).any(|_| troubles.strikes(Fault::Loss)));
    }

    #[test]
    fn a_span_of_numbers_lets_just_these_happen() {
        let mut all = Troubles::new(1, Faults::ALL, 0..u64::MAX);
        let mut few = Troubles::new(1, Faults::ALL, 3..5);
        let strikes = |troubles: &mut Troubles| -> Vec<usize> {
            (0..1_000).filter(|_| troubles.strikes(Fault::Loss)).collect()
        };
        let (all, few) = (strikes(&mut all), strikes(&mut few));
        assert_eq!(few, all[3..5]);
    }
}
