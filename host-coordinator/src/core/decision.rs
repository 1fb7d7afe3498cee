//! A choice of a pile, kept so that a person can ask why.
//!
//! The event log and the API show it in the same form, which is plain data with no borrowed
//! type of the selection in it: an old log stays readable when the selection learns new reasons.

use protocol::{Availability, EnergyJ, PileId, Position, RequestId, RobotId, SiteMillis};
use serde::{Deserialize, Serialize};

use crate::selection::{Asker, Choice, Holder, PolicyName, Situation, Times};

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
    /// What it takes while it stands, in watts; none in the logs of programs that did not record it.
    #[serde(default)]
    pub standing_w: Option<f64>,
    /// Where it was, in metres of the site; none in the logs of programs that did not record it.
    #[serde(default)]
    pub position: Option<Position>,
    /// What its battery held.
    #[serde(default)]
    pub energy_j: EnergyJ,
    /// When it asked first.
    #[serde(default)]
    pub asked_at_ms: SiteMillis,
    /// For how long it had waited, in seconds.
    #[serde(default)]
    pub waited_s: f64,
    /// Whether its battery was about to be empty (Access eq. 5).
    #[serde(default)]
    pub is_critical: bool,
    /// How urgent its need was ([`priority`](crate::selection::priority)).
    #[serde(default)]
    pub urgency: f64,
    /// Who else was to be given a pile at that instant.
    #[serde(default)]
    pub beside: Vec<RobotId>,
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
    /// What the pile could be used for; none if it was silent for too long.
    #[serde(default)]
    pub availability: Option<Availability>,
    /// Whether it was free to that robot alone, which stood there without a lease.
    #[serde(default)]
    pub stands_here: bool,
    /// The share of its charge still ahead, 0 to 1 (q, eq. 1).
    #[serde(default)]
    pub remaining: f64,
    /// When it was to be free, in seconds from then; none if nobody knew.
    #[serde(default)]
    pub free_in_s: Option<f64>,
    /// Whether it was occupied and promised to nobody, so that it could be the robot's next.
    #[serde(default)]
    pub next_is_open: bool,
    /// Who was charged there, if that could be cut short.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub holder: Option<Holder>,
    /// What it would cost the robot in time; none if no way leads there or nobody knew when it is free.
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
        situation: &Situation,
        asker: &Asker,
        choice: &Choice,
    ) -> Self {
        let beside = situation.askers.iter().map(|other| other.robot);
        let rows = choice.explanations.iter().zip(&asker.offers);
        let explanations = rows.map(|(one, offer)| Explanation {
            pile: one.pile,
            stage: one.stage.name().to_owned(),
            distance: one.distance,
            probability: one.probability,
            score: one.score.filter(|score| score.is_finite()),
            availability: offer.candidate.availability,
            stands_here: offer.stands_here,
            remaining: offer.candidate.remaining,
            free_in_s: offer.free_in_s,
            next_is_open: offer.next_is_open,
            holder: offer.holder,
            times: offer.times,
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
            standing_w: Some(asker.standing_w),
            position: Some(asker.position),
            energy_j: asker.energy,
            asked_at_ms: asker.asked_at,
            waited_s: asker.waited_s,
            is_critical: asker.is_critical,
            urgency: asker.urgency,
            beside: beside.filter(|other| *other != asker.robot).collect(),
            explanations: explanations.collect(),
        }
    }
}
