//! The nearest free pile, one robot after the other: what fleet managers have, and Access 2.3.

use std::collections::BTreeMap;

use protocol::{Availability, PileId, RobotId};

use super::{
    explain::{Choice, Explanation, PileStage, Stage, Verdict},
    multistage::Candidate,
    policy::ChargingPolicy,
    preempt::preempt,
    priority,
    situation::{Asker, Situation},
};

/// Gives each robot in turn the nearest free pile within its reach.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    /// Whose turn it is.
    pub order: Order,
}

/// In which order robots are served.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// As they asked.
    Asked,
    /// The most urgent first ([`priority`]).
    Urgency,
}

impl Order {
    /// The places of a situation's askers, in this order.
    pub(super) fn of(self, situation: &Situation) -> Vec<usize> {
        let mut order: Vec<_> = (0..situation.askers.len()).collect();
        let asked = |asker: &Asker| (asker.asked_at, asker.robot);
        order.sort_by(|&one, &other| {
            let (one, other) = (&situation.askers[one], &situation.askers[other]);
            match self {
                Self::Asked => asked(one).cmp(&asked(other)),
                Self::Urgency => priority::order(one, other),
            }
        });
        order
    }
}

/// Lets the askers choose one after the other; what one has chosen, the next ones can't.
pub(super) fn in_turn(
    situation: &Situation,
    order: Order,
    choose: impl Fn(&Asker, &[Candidate]) -> Choice,
) -> Vec<Choice> {
    let mut given: BTreeMap<PileId, RobotId> = BTreeMap::new();
    let mut choices: Vec<_> = situation.askers.iter().map(|_| Choice::default()).collect();
    for place in order.of(situation) {
        let asker = &situation.askers[place];
        let mut choice = choose(asker, &asker.candidates(&given));
        for row in &mut choice.explanations {
            if let Some(&to) = given.get(&row.pile) {
                row.verdict = Verdict::Given { to };
            }
        }
        given.extend(choice.chosen.map(|pile| (pile, asker.robot)));
        choices[place] = choice;
    }
    choices
}

impl ChargingPolicy for Nearest {
    fn choose(&self, situation: &Situation) -> Vec<Choice> {
        let mut choices = in_turn(situation, self.order, nearest);
        if self.order == Order::Urgency {
            preempt(situation, &mut choices);
        }
        choices
    }
}

fn nearest(asker: &Asker, candidates: &[Candidate]) -> Choice {
    let reach = asker.reach;
    let usable = |candidate: &&Candidate| {
        candidate.availability == Some(Availability::Free)
            && candidate.distance.is_some_and(|distance| distance <= reach)
    };
    let best = candidates.iter().filter(usable).min_by(|one, other| {
        let distance = |candidate: &Candidate| candidate.distance.unwrap_or(f64::INFINITY);
        distance(one).total_cmp(&distance(other)).then(one.pile.cmp(&other.pile))
    });
    let explanations = candidates.iter().map(|candidate| {
        let &Candidate { pile, distance, probability, .. } = candidate;
        let verdict = match (best, distance, candidate.availability) {
            (Some(best), ..) if best.pile == pile => Verdict::Chosen,
            (_, _, None) => Verdict::Unknown,
            (_, _, Some(Availability::Charging)) => Verdict::StillCharging { remaining: candidate.remaining },
            (_, _, Some(taken)) if taken != Availability::Free => Verdict::Taken(taken),
            (_, None, _) => Verdict::NoPath,
            (Some(best), Some(distance), _) if distance <= reach => {
                Verdict::Farther { than: best.pile, by: distance - best.distance.unwrap_or_default() }
            }
            _ => Verdict::OutOfReach { reach },
        };
        let stage = if candidate.availability == Some(Availability::Free) {
            PileStage::Idle
        } else {
            PileStage::Unusable
        };
        Explanation { pile, stage, distance, probability, score: None, times: None, verdict }
    });
    Choice {
        chosen: best.map(|best| best.pile),
        stage: if best.is_some() { Stage::Nearest } else { Stage::None },
        explanations: explanations.collect(),
    }
}
