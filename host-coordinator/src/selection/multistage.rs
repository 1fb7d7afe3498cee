//! The multistage choice of a pile (LMPP eqs. 7 and 9).
//!
//! Idle piles come first. If the robot reaches all of them, the one near its later work wins; if
//! it reaches only some, nearness to the robot counts too. If it reaches none, piles whose
//! charge is almost done are ranked, mostly by their distance.

use protocol::{Availability, PileId};

use super::{
    explain::{Choice, Explanation, PileStage, Stage, Verdict},
    nearest::{Order, in_turn},
    policy::ChargingPolicy,
    situation::Situation,
};

/// Which reading of eq. 9 is meant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rule {
    /// As printed: an occupied pile counts as almost charged if q >= q_th, and once a stage is
    /// entered its piles beyond the robot's reach are ranked too. Reproduces Test 3.
    PaperLiteral,
    /// An occupied pile counts as almost charged if at most 1 - q_th of its charge is ahead,
    /// and only piles within reach are ranked. Reproduces Test 4.
    #[default]
    Corrected,
}

/// What is known of one pile for one robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Which pile.
    pub pile: PileId,
    /// What the pile does; none if it was silent for too long.
    pub availability: Option<Availability>,
    /// The share of its charge still ahead, 0 to 1 (q, eq. 1).
    pub remaining: f64,
    /// The length of the robot's way to it in cells; none if there is no way.
    pub distance: Option<f64>,
    /// The probability that the robot is active near it after the charge, 0 to 1 (p, eq. 5).
    pub probability: f64,
}

/// LMPP's choice for one robot after the other, as they asked.
#[derive(Clone, Copy, Debug)]
pub struct Multistage {
    /// Which reading of eq. 9.
    pub rule: Rule,
    /// How much of a charge counts as almost all of it (q_th), 0 to 1.
    pub q_threshold: f64,
}

impl ChargingPolicy for Multistage {
    fn choose(&self, situation: &Situation) -> Vec<Choice> {
        in_turn(situation, Order::Asked, |asker, candidates| {
            choose(candidates, asker.reach, self.q_threshold, self.rule)
        })
    }
}

/// Chooses among `candidates` for a robot that gets `reach` cells far (d_l, eq. 6).
///
/// `q_threshold` (q_th, 0 to 1) says when a charge counts as almost done. Equal scores go to the
/// nearer pile, equal distances to the lower number. A `reach` or probability that is no number
/// it could be counts as 0, such a distance as no way.
#[must_use]
pub fn choose(candidates: &[Candidate], reach: f64, q_threshold: f64, rule: Rule) -> Choice {
    let reach = if reach.is_finite() { reach.max(0.0) } else { 0.0 };
    let candidates: Vec<_> = candidates.iter().map(|candidate| candidate.tidied()).collect();
    let stage_of = |candidate: &Candidate| candidate.stage(q_threshold, rule);
    let set = |wanted: PileStage| {
        let of_set = candidates.iter().filter(move |candidate| stage_of(candidate) == wanted);
        of_set.filter_map(|candidate| Some((candidate, candidate.distance?)))
    };
    let nearest = |wanted| set(wanted).map(|(_, distance)| distance).fold(f64::INFINITY, f64::min);
    let farthest_idle = set(PileStage::Idle).map(|(_, distance)| distance).fold(0.0, f64::max);

    let (stage, ranked_set) = if reach >= farthest_idle && reach >= nearest(PileStage::Idle) {
        (Stage::ReachAll, PileStage::Idle)
    } else if reach >= nearest(PileStage::Idle) {
        (Stage::ReachSome, PileStage::Idle)
    } else if reach >= nearest(PileStage::AlmostCharged) {
        (Stage::AlmostCharged, PileStage::AlmostCharged)
    } else {
        (Stage::None, PileStage::Unusable)
    };

    let size = set(ranked_set).count() as f64;
    let span = Span::of(candidates.iter().filter_map(|candidate| candidate.distance));
    let score = |candidate: &Candidate| {
        let distance = candidate.distance?;
        let ranked = stage_of(candidate) == ranked_set && (distance <= reach || rule == Rule::PaperLiteral);
        ranked.then(|| stage.score(candidate.probability, span.normalised(distance), size)).flatten()
    };
    let best = candidates
        .iter()
        .filter_map(|candidate| Some((candidate, score(candidate)?)))
        .max_by(|(a, a_score), (b, b_score)| {
            let nearer = || b.distance.partial_cmp(&a.distance).unwrap_or(std::cmp::Ordering::Equal);
            a_score.total_cmp(b_score).then_with(nearer).then(b.pile.cmp(&a.pile))
        })
        .map(|(candidate, score)| (candidate.pile, score));

    let explanations = candidates
        .iter()
        .map(|candidate| {
            let (stage, score) = (stage_of(candidate), score(candidate));
            let verdict = candidate.verdict(stage, score, best, reach);
            let &Candidate { pile, distance, probability, .. } = candidate;
            Explanation { pile, stage, distance, probability, score, times: None, verdict }
        })
        .collect();
    Choice { chosen: best.map(|(pile, _)| pile), stage, explanations }
}

impl Candidate {
    /// The same without numbers that are none.
    fn tidied(self) -> Self {
        let distance = self.distance.filter(|distance| distance.is_finite() && *distance >= 0.0);
        let probability = if (0.0..=1.0).contains(&self.probability) { self.probability } else { 0.0 };
        Self { distance, probability, ..self }
    }

    /// Q1, Q2 or neither.
    fn stage(&self, q_threshold: f64, rule: Rule) -> PileStage {
        let almost_charged = match rule {
            Rule::PaperLiteral => self.remaining >= q_threshold,
            Rule::Corrected => self.remaining <= 1.0 - q_threshold,
        };
        match self.availability {
            Some(Availability::Free) => PileStage::Idle,
            Some(Availability::Charging) if almost_charged => PileStage::AlmostCharged,
            _ => PileStage::Unusable,
        }
    }

    fn verdict(
        &self,
        stage: PileStage,
        score: Option<f64>,
        best: Option<(PileId, f64)>,
        reach: f64,
    ) -> Verdict {
        match (self.availability, stage, score, best) {
            (_, _, Some(_), Some((pile, _))) if pile == self.pile => Verdict::Chosen,
            (_, _, Some(score), Some((pile, best))) if score == best => Verdict::Tied { with: pile },
            (_, _, Some(_), Some((pile, _))) => Verdict::Outscored { by: pile },
            (None, ..) => Verdict::Unknown,
            (Some(Availability::Charging), PileStage::Unusable, ..) => {
                Verdict::StillCharging { remaining: self.remaining }
            }
            (Some(taken), PileStage::Unusable, ..) => Verdict::Taken(taken),
            _ => match self.distance {
                None => Verdict::NoPath,
                Some(distance) if distance <= reach => Verdict::IdleInReach,
                Some(_) => Verdict::OutOfReach { reach },
            },
        }
    }
}

impl Stage {
    /// Eq. 9 for one pile out of a set of `size`; none where nothing is ranked.
    fn score(self, probability: f64, normalised: f64, size: f64) -> Option<f64> {
        let few = 1.0 / size;
        match self {
            Self::ReachAll => Some(probability),
            Self::ReachSome => Some((1.0 - few) * probability + few * (1.0 - normalised)),
            Self::AlmostCharged => Some(few * probability + (1.0 - few) * (1.0 - normalised)),
            Self::Nearest | Self::Together | Self::Later | Self::Preempting | Self::None => None,
        }
    }
}

/// The shortest and the longest way to any pile.
struct Span {
    shortest: f64,
    longest: f64,
}

impl Span {
    fn of(distances: impl Iterator<Item = f64>) -> Self {
        let none = Self { shortest: f64::INFINITY, longest: f64::NEG_INFINITY };
        distances.fold(none, |span, distance| Self {
            shortest: span.shortest.min(distance),
            longest: span.longest.max(distance),
        })
    }

    /// Eq. 7: 0 for the nearest pile, 1 for the farthest; 0 if all are as far.
    fn normalised(&self, distance: f64) -> f64 {
        let width = self.longest - self.shortest;
        if width > 0.0 { (distance - self.shortest) / width } else { 0.0 }
    }
}

#[cfg(test)]
#[path = "multistage_tests.rs"]
mod tests;
