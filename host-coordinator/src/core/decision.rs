//! A choice of a pile, kept so that a person can ask why.
//!
//! The event log and the API show it in the same form, which is plain data with no borrowed
//! type of the selection in it: an old log stays readable when the selection learns new reasons.

use protocol::{PileId, RequestId, RobotId, SiteMillis};
use serde::{Deserialize, Serialize};

use crate::selection::{Asker, Choice, PolicyName, Times};

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
    /// Which policy chose.
    #[serde(default)]
    pub policy: String,
    /// Which of its rules decided, for LMPP the case of eq. 9: the names of
    /// [`Stage`](crate::selection::Stage).
    pub stage: String,
    /// How far the robot gets on average, in cells (eq. 6).
    pub reach: f64,
    /// How far it gets almost surely, in cells.
    #[serde(default)]
    pub sure_reach: f64,
    /// For how long it had waited, in seconds.
    #[serde(default)]
    pub waited_s: f64,
    /// How urgent its need was ([`priority`](crate::selection::priority)).
    #[serde(default)]
    pub urgency: f64,
    /// What was known of every pile.
    pub explanations: Vec<Explanation>,
}

/// Why a pile was or was not chosen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Explanation {
    /// Which pile.
    pub pile: PileId,
    /// How it could be chosen: `idle`, `almost_charged`, `next_open`, `unusable`.
    pub stage: String,
    /// The length of the way to it in cells.
    pub distance: Option<f64>,
    /// How often the robot is near it at that time of day, 0 to 1 (eq. 5).
    pub probability: f64,
    /// What eq. 9 gives it.
    pub score: Option<f64>,
    /// What it would cost the robot in time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub times: Option<Times>,
    /// One word for programs.
    pub verdict: String,
    /// A few words for people.
    pub reason: String,
    /// What would have had to be different for it to be chosen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unless: Option<String>,
}

impl Decision {
    /// Keeps a choice.
    #[must_use]
    pub fn new(
        id: u64,
        at_ms: SiteMillis,
        request: RequestId,
        policy: PolicyName,
        asker: &Asker,
        choice: &Choice,
    ) -> Self {
        let explanations = choice.explanations.iter().map(|one| Explanation {
            pile: one.pile,
            stage: one.stage.name().to_owned(),
            distance: one.distance,
            probability: one.probability,
            score: one.score.filter(|score| score.is_finite()),
            times: one.times,
            verdict: one.verdict.name().to_owned(),
            reason: one.verdict.to_string(),
            unless: one.unless(),
        });
        Self {
            id,
            at_ms,
            robot: asker.robot,
            request,
            chosen: choice.chosen,
            policy: policy.name().to_owned(),
            stage: choice.stage.name().to_owned(),
            reach: asker.reach,
            sure_reach: asker.sure_reach,
            waited_s: asker.waited_s,
            urgency: asker.urgency,
            explanations: explanations.collect(),
        }
    }
}
