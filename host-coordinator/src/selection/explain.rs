//! What is told about a choice: for every pile its stage, distance, probability, score and why
//! it was or was not chosen.

use std::fmt;

use protocol::{Availability, PileId};
use serde::Serialize;

/// A pile chosen among others, or none, and why.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Choice {
    /// The pile the robot should use; none if it must wait or be fetched.
    pub chosen: Option<PileId>,
    /// Which case of eq. 9 decided.
    pub stage: Stage,
    /// One for every candidate, in the order given.
    pub explanations: Vec<Explanation>,
}

/// The case of LMPP eq. 9 that decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Every idle pile is within reach: the one near the robot's work wins.
    ReachAll,
    /// Some idle piles are within reach: nearness to the work and to the robot both count.
    ReachSome,
    /// No idle pile is within reach, an almost charged one is.
    AlmostCharged,
    /// Nothing is within reach.
    None,
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ReachAll => "every idle pile is within reach",
            Self::ReachSome => "some idle piles are within reach",
            Self::AlmostCharged => "only almost charged piles are within reach",
            Self::None => "no usable pile is within reach",
        })
    }
}

/// In which stage a pile can be chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PileStage {
    /// Free: LMPP's Q1.
    Idle,
    /// Charging a robot that is almost done: LMPP's Q2.
    AlmostCharged,
    /// In neither set.
    Unusable,
}

impl PileStage {
    /// One word for programs.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Idle => "idle",
            Self::AlmostCharged => "almost_charged",
            Self::Unusable => "unusable",
        }
    }
}

/// Why one pile was or was not chosen.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(into = "Row")]
pub struct Explanation {
    /// Which pile.
    pub pile: PileId,
    /// In which stage it can be chosen.
    pub stage: PileStage,
    /// The length of the way to it in cells; none if there is no way.
    pub distance: Option<f64>,
    /// The probability that the robot is active near it after the charge (eq. 5).
    pub probability: f64,
    /// What eq. 9 gives it; none if it was not ranked.
    pub score: Option<f64>,
    /// Why it was or was not chosen.
    pub verdict: Verdict,
}

/// Why a pile was or was not chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// It was.
    Chosen,
    /// Another pile has a higher score.
    Outscored {
        /// The chosen pile.
        by: PileId,
    },
    /// The chosen pile has the same score and is nearer, or as near with a lower number.
    Tied {
        /// The chosen pile.
        with: PileId,
    },
    /// The robot would strand on the way.
    OutOfReach {
        /// How far the robot gets, in cells.
        reach: f64,
    },
    /// No way leads to it.
    NoPath,
    /// It is almost charged, and an idle pile is within reach.
    IdleInReach,
    /// Its charge has too much ahead.
    StillCharging {
        /// The share of the charge still ahead, 0 to 1.
        remaining: f64,
    },
    /// It is neither free nor charging.
    Taken(Availability),
    /// It was silent for too long.
    Unknown,
}

impl Verdict {
    /// One word for programs.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Chosen => "chosen",
            Self::Outscored { .. } => "outscored",
            Self::Tied { .. } => "tied",
            Self::OutOfReach { .. } => "out_of_reach",
            Self::NoPath => "no_path",
            Self::IdleInReach => "idle_in_reach",
            Self::StillCharging { .. } => "still_charging",
            Self::Taken(Availability::Reserved) => "reserved",
            Self::Taken(Availability::Done) => "done",
            Self::Taken(Availability::Fault) => "fault",
            Self::Taken(Availability::Free | Availability::Charging) => "taken",
            Self::Unknown => "unknown",
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Chosen => f.write_str("chosen"),
            Self::Outscored { by } => write!(f, "pile {by} has a higher score"),
            Self::Tied { with } => {
                write!(f, "pile {with} has the same score and is nearer, or as near with a lower number")
            }
            Self::OutOfReach { reach } => write!(f, "beyond the robot's reach of {reach:.1} cells"),
            Self::NoPath => f.write_str("no way leads there"),
            Self::IdleInReach => f.write_str("occupied, and an idle pile is within reach"),
            Self::StillCharging { remaining } => {
                write!(f, "occupied, with {:.0} % of the charge still ahead", 100.0 * remaining)
            }
            Self::Taken(Availability::Reserved) => f.write_str("reserved for another robot"),
            Self::Taken(Availability::Done) => f.write_str("a charged robot still stands there"),
            Self::Taken(Availability::Fault) => f.write_str("out of order"),
            Self::Taken(Availability::Free | Availability::Charging) => f.write_str("taken"),
            Self::Unknown => f.write_str("silent for too long, so its state is unknown"),
        }
    }
}

/// An [`Explanation`] as programs read it.
#[derive(Serialize)]
struct Row {
    pile: PileId,
    stage: PileStage,
    distance: Option<f64>,
    probability: f64,
    score: Option<f64>,
    verdict: &'static str,
    reason: String,
}

impl From<Explanation> for Row {
    fn from(explanation: Explanation) -> Self {
        let Explanation { pile, stage, distance, probability, score, verdict } = explanation;
        let (reason, verdict) = (verdict.to_string(), verdict.name());
        Self { pile, stage, distance, probability, score, verdict, reason }
    }
}
