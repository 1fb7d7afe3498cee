//! What is told about a choice: for every pile its stage, distance, probability, score and why
//! it was or was not chosen.

use std::fmt;

use protocol::{Availability, PileId, RobotId};
use serde::Serialize;

use super::situation::Times;

/// A pile chosen among others, or none, and why.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Choice {
    /// The pile the robot should use; none if it must wait or be fetched.
    pub chosen: Option<PileId>,
    /// By which rule: for LMPP, which case of eq. 9 decided.
    pub stage: Stage,
    /// One for every candidate, in the order given.
    pub explanations: Vec<Explanation>,
}

/// The rule that decided; the first three are the cases of LMPP eq. 9.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Every idle pile is within reach: the one near the robot's work wins.
    ReachAll,
    /// Some idle piles are within reach: nearness to the work and to the robot both count.
    ReachSome,
    /// No idle pile is within reach, an almost charged one is.
    AlmostCharged,
    /// The nearest free pile wins.
    Nearest,
    /// The pile is part of what is cheapest for all robots that wait.
    Together,
    /// So is an occupied pile for which it is too early to set off.
    Later,
    /// The robot is critical, and another's charge is cut short for it.
    Preempting,
    /// Nothing is within reach.
    #[default]
    None,
}

impl Stage {
    /// One word for programs.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::ReachAll => "reach_all",
            Self::ReachSome => "reach_some",
            Self::AlmostCharged => "almost_charged",
            Self::Nearest => "nearest",
            Self::Together => "together",
            Self::Later => "later",
            Self::Preempting => "preempting",
            Self::None => "none",
        }
    }
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ReachAll => "every idle pile is within reach",
            Self::ReachSome => "some idle piles are within reach",
            Self::AlmostCharged => "only almost charged piles are within reach",
            Self::Nearest => "the nearest free pile",
            Self::Together => "the least time away from work for all robots that wait",
            Self::Later => "it is best to wait for a pile that is still occupied",
            Self::Preempting => "the robot is critical: another's charge is cut short",
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
    /// Occupied, and promised to nobody: it can be the robot's next.
    NextOpen,
    /// Its robot's charge can be cut short.
    Preemptable,
    /// In none of them.
    Unusable,
}

impl PileStage {
    /// One word for programs.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Idle => "idle",
            Self::AlmostCharged => "almost_charged",
            Self::NextOpen => "next_open",
            Self::Preemptable => "preemptable",
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
    /// What it would cost the robot in time; none if the policy does not ask, or it can't have it.
    pub times: Option<Times>,
    /// Why it was or was not chosen.
    pub verdict: Verdict,
}

impl Explanation {
    /// What would have had to be different for this pile to be chosen; none where nothing near would do.
    #[must_use]
    pub fn unless(&self) -> Option<String> {
        match self.verdict {
            Verdict::Farther { by, .. } => Some(format!("if it were {by:.1} cells nearer")),
            Verdict::Costlier { .. } => {
                Some("if its way, its wait or its charge took the robot that much less".to_owned())
            }
            Verdict::NotYet { free_in_s } => {
                let way_s = self.times.map(|times| times.way_s())?;
                Some(format!(
                    "if it were free in {way_s:.0} s, not {free_in_s:.0}, or the robot farther away"
                ))
            }
            Verdict::OutOfReach { reach } => {
                let lacks = self.distance? - reach;
                Some(format!("if the robot got {lacks:.1} cells farther"))
            }
            Verdict::StillCharging { .. } | Verdict::Taken(Availability::Done | Availability::Reserved) => {
                Some("if it were free".to_owned())
            }
            Verdict::Given { to } => Some(format!("if robot {to} did not wait, or came later")),
            Verdict::NoPower => Some("if another pile drew no power".to_owned()),
            Verdict::Unknown => Some("if it could be heard".to_owned()),
            Verdict::Taken(Availability::Fault) => Some("if it were mended".to_owned()),
            Verdict::Chosen
            | Verdict::Preempts { .. }
            | Verdict::Outscored { .. }
            | Verdict::Tied { .. }
            | Verdict::NoPath
            | Verdict::IdleInReach
            | Verdict::Taken(Availability::Free | Availability::Charging) => None,
        }
    }
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
    /// Another pile is nearer.
    Farther {
        /// The chosen pile.
        than: PileId,
        /// How much nearer that is, in cells.
        by: f64,
    },
    /// Another pile for this robot, or another robot for this pile, takes less time for all together.
    Costlier {
        /// By so much it would have to take this robot less time, at least, in seconds.
        by_s: f64,
        /// Who gets it instead.
        to: Option<RobotId>,
    },
    /// It is the best for the robot, which does not have to set off yet.
    NotYet {
        /// When it is free, in seconds from now.
        free_in_s: f64,
    },
    /// It was, and the charge of the robot on it is cut short.
    Preempts {
        /// Whose charge.
        robot: RobotId,
    },
    /// Another robot that waits is served before and gets it.
    Given {
        /// Who.
        to: RobotId,
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
    /// It is free, and the facility has no power left for it.
    NoPower,
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
            Self::Farther { .. } => "farther",
            Self::Costlier { .. } => "costlier",
            Self::NotYet { .. } => "not_yet",
            Self::Preempts { .. } => "preempts",
            Self::Given { .. } => "given",
            Self::Tied { .. } => "tied",
            Self::OutOfReach { .. } => "out_of_reach",
            Self::NoPath => "no_path",
            Self::IdleInReach => "idle_in_reach",
            Self::StillCharging { .. } => "still_charging",
            Self::Taken(Availability::Reserved) => "reserved",
            Self::Taken(Availability::Done) => "done",
            Self::Taken(Availability::Fault) => "fault",
            Self::Taken(Availability::Free | Availability::Charging) => "taken",
            Self::NoPower => "no_power",
            Self::Unknown => "unknown",
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Chosen => f.write_str("chosen"),
            Self::Outscored { by } => write!(f, "pile {by} has a higher score"),
            Self::Farther { than, by } => write!(f, "pile {than} is {by:.1} cells nearer"),
            Self::Costlier { by_s, to: None } => {
                write!(f, "takes at least {by_s:.1} s too long for this robot")
            }
            Self::Costlier { by_s, to: Some(robot) } => {
                write!(f, "saves more for robot {robot}, by at least {by_s:.1} s")
            }
            Self::NotYet { free_in_s } => {
                write!(f, "the best, and free in {free_in_s:.0} s: the robot need not set off yet")
            }
            Self::Preempts { robot } => {
                write!(f, "chosen: robot {robot} has enough for its next task, and makes way")
            }
            Self::Given { to } => write!(f, "given to robot {to}, which comes first"),
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
            Self::NoPower => f.write_str("free, and the facility has no power left for it"),
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
    #[serde(skip_serializing_if = "Option::is_none")]
    times: Option<Times>,
    verdict: &'static str,
    reason: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    unless: Option<String>,
}

impl From<Explanation> for Row {
    fn from(explanation: Explanation) -> Self {
        let Explanation { pile, stage, distance, probability, score, times, verdict } = explanation;
        let (reason, unless) = (verdict.to_string(), explanation.unless());
        let verdict = verdict.name();
        Self { pile, stage, distance, probability, score, times, verdict, reason, unless }
    }
}
