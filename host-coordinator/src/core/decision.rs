//! A choice of a pile, kept so that a person can ask why.
//!
//! The event log and the API show it in the same form, which is plain data with no borrowed
//! type of the selection in it: an old log stays readable when the selection learns new reasons.

use protocol::{PileId, RequestId, RobotId, SiteMillis};
use serde::{Deserialize, Serialize};

use crate::selection::{self, Choice};

/// What was chosen for a robot, when and why.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Decision {
    /// Counts the decisions.
    pub id: u64,
    /// When.
    pub at_ms: SiteMillis,
    /// For whom.
    pub robot: RobotId,
    /// Its request.
    pub request: RequestId,
    /// The pile it is to use.
    pub chosen: Option<PileId>,
    /// Which case of LMPP eq. 9 decided: `reach_all`, `reach_some`, `almost_charged`, `none`.
    pub stage: String,
    /// How far the robot gets, in cells (eq. 6).
    pub reach: f64,
    /// What was known of every pile.
    pub explanations: Vec<Explanation>,
}

/// Why a pile was or was not chosen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Explanation {
    /// Which pile.
    pub pile: PileId,
    /// In which stage it could be chosen: `idle`, `almost_charged`, `unusable`.
    pub stage: String,
    /// The length of the way to it in cells.
    pub distance: Option<f64>,
    /// How often the robot is near it at that time of day, 0 to 1 (eq. 5).
    pub probability: f64,
    /// What eq. 9 gives it.
    pub score: Option<f64>,
    /// One word for programs.
    pub verdict: String,
    /// A few words for people.
    pub reason: String,
}

impl Decision {
    /// Keeps a choice.
    #[must_use]
    pub fn new(
        id: u64,
        at_ms: SiteMillis,
        robot: RobotId,
        request: RequestId,
        reach: f64,
        choice: &Choice,
    ) -> Self {
        let stage = match choice.stage {
            selection::Stage::ReachAll => "reach_all",
            selection::Stage::ReachSome => "reach_some",
            selection::Stage::AlmostCharged => "almost_charged",
            selection::Stage::None => "none",
        };
        let explanations = choice.explanations.iter().map(|one| Explanation {
            pile: one.pile,
            stage: one.stage.name().to_owned(),
            distance: one.distance,
            probability: one.probability,
            score: one.score.filter(|score| score.is_finite()),
            verdict: one.verdict.name().to_owned(),
            reason: one.verdict.to_string(),
        });
        Self {
            id,
            at_ms,
            robot,
            request,
            chosen: choice.chosen,
            stage: stage.to_owned(),
            reach,
            explanations: explanations.collect(),
        }
    }
}
