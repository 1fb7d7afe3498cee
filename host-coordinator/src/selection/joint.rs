//! All robots that wait are given piles together, by one cost: the time from now until each works again.
//!
//! A pair of robot and pile costs [`Times::away_s`], the drive with the congestion of its doors, the
//! wait until the pile is free, the charge, and the drive to where the robot is wanted after it. Of all
//! ways to give every pile to at most one robot the cheapest is taken in which as many robots as possible
//! get one ([`planning::assign`]). When not all can, the more urgent a robot is ([`priority`]), the more
//! its pairs are worth: a second of waiting as much as a second of cost.
//!
//! An occupied pile can be promised as well, but no sooner than its robot has to set off: until then
//! everything may turn out otherwise, so the robot waits and is given piles anew at every change.

use planning::assign::{Assignment, PairCost};
use protocol::Availability;

use super::{
    explain::{Choice, Explanation, PileStage, Stage, Verdict},
    multistage::Candidate,
    policy::ChargingPolicy,
    preempt::preempt,
    priority,
    situation::{Asker, Offer, Situation, Times},
};

/// An occupied pile is promised to a robot this long before it has to set off, in seconds: the planned
/// times of charges are no more exact.
const AHEAD_S: f64 = 30.0;
/// A battery is to last so much longer than until the charge should begin, in seconds: crowded doors, charges
/// that take longer than planned and networks that are cut take their time.
const PRUDENCE_S: f64 = 90.0;
/// What a second costs that a robot would stand empty for, in seconds away from work.
const EMPTY: f64 = 20.0;
/// The unit of costs, in seconds: fine enough that no two piles a cell apart cost the same.
const COST_UNIT_S: f64 = 0.01;

/// Gives piles to all robots together.
#[derive(Clone, Copy, Debug)]
pub struct Joint;

impl ChargingPolicy for Joint {
    fn choose(&self, situation: &Situation) -> Vec<Choice> {
        let askers = &situation.askers;
        let piles = askers.first().map_or(0, |asker| asker.offers.len());
        let most_urgent = askers.iter().map(|asker| asker.urgency).fold(0.0, f64::max);
        let ranges: Vec<f64> = askers.iter().map(Asker::range).collect();
        let least_empty_s: Vec<f64> = askers.iter().zip(&ranges).map(least_empty_s).collect();
        let mut assignment = Assignment::default();
        assignment.solve(askers.len(), piles, |row, column| {
            let (asker, offer) = (askers.get(row)?, askers.get(row)?.offers.get(column)?);
            let times = usable(offer, *ranges.get(row)?)?;
            let empty_s = times.empty_s(PRUDENCE_S) - least_empty_s.get(row)?;
            let yielding_s = (most_urgent - asker.urgency) * priority::AGEING_S;
            // The cast saturates: such a pair is as dear as a pair can be.
            Some(((times.away_s() + EMPTY * empty_s + yielding_s) / COST_UNIT_S) as PairCost)
        });
        let rows = askers.iter().zip(ranges).enumerate();
        let choices = rows.map(|(row, (asker, range))| explained(situation, &assignment, row, asker, range));
        let mut choices: Vec<_> = choices.collect();
        preempt(situation, &mut choices);
        choices
    }
}

/// For how long a robot stands empty at the least, whichever pile it gets.
fn least_empty_s((asker, range): (&Asker, &f64)) -> f64 {
    let empty_s = asker.offers.iter().filter_map(|offer| Some(usable(offer, *range)?.empty_s(PRUDENCE_S)));
    empty_s.fold(f64::INFINITY, f64::min)
}

/// The times of a pile that a robot with this reach could be given, now or next.
fn usable(offer: &Offer, reach: f64) -> Option<Times> {
    let now = offer.candidate.availability == Some(Availability::Free);
    let in_reach = offer.candidate.distance.is_some_and(|distance| distance <= reach);
    offer.times.filter(|_| (now || offer.next_is_open) && in_reach)
}

fn explained(
    situation: &Situation,
    assignment: &Assignment,
    row: usize,
    asker: &Asker,
    reach: f64,
) -> Choice {
    let best = assignment.of_row(row);
    let is_time = |offer: &Offer| {
        offer.candidate.availability == Some(Availability::Free)
            || offer.times.is_some_and(|times| times.free_in_s <= times.way_s() + AHEAD_S)
    };
    let chosen = best.and_then(|column| asker.offers.get(column)).filter(|offer| is_time(offer));
    let explanations = asker.offers.iter().enumerate().map(|(column, offer)| {
        let times = usable(offer, reach);
        let verdict = match times {
            None => refusal(offer, reach),
            Some(_) if best == Some(column) && chosen.is_some() => Verdict::Chosen,
            Some(times) if best == Some(column) => Verdict::NotYet { free_in_s: times.free_in_s },
            Some(_) => {
                let margin = assignment.margin(row, column).unwrap_or_default();
                let other = assignment.of_column(column).and_then(|other| situation.askers.get(other));
                Verdict::Costlier { by_s: margin as f64 * COST_UNIT_S, to: other.map(|other| other.robot) }
            }
        };
        let Candidate { pile, distance, probability, .. } = offer.candidate;
        let stage = match (times, offer.candidate.availability) {
            (None, _) => PileStage::Unusable,
            (_, Some(Availability::Free)) => PileStage::Idle,
            _ => PileStage::NextOpen,
        };
        Explanation { pile, stage, distance, probability, score: None, times, verdict }
    });
    Choice {
        chosen: chosen.map(|offer| offer.candidate.pile),
        stage: match (chosen, best) {
            (Some(_), _) => Stage::Together,
            (None, Some(_)) => Stage::Later,
            (None, None) => Stage::None,
        },
        explanations: explanations.collect(),
    }
}

/// Why a pile can't be given to a robot at all.
fn refusal(offer: &Offer, reach: f64) -> Verdict {
    match (offer.candidate.availability, offer.candidate.distance) {
        (None, _) => Verdict::Unknown,
        (Some(taken), _) if taken != Availability::Free && !offer.next_is_open => Verdict::Taken(taken),
        (_, Some(distance)) if distance > reach => Verdict::OutOfReach { reach },
        _ => Verdict::NoPath,
    }
}
