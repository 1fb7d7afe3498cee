//! A pile is freed for a critical robot (Access 2.3).
//!
//! Where a robot's battery is about to be empty and it gets no pile, the charge of another is cut short:
//! of those that may be ([`Holder`]) the one with the least important next task, and of equals the one
//! with the most charge. Whoever is charged only gives way to a robot that is critical, and critical robots
//! come in the order of their urgency.

use std::collections::BTreeSet;

use protocol::PileId;

use super::{
    explain::{Choice, PileStage, Stage, Verdict},
    priority,
    situation::{Asker, Offer, Situation},
};

/// A pile that is free no later than so many seconds after the robot can be there is waited for.
const WORTH_S: f64 = 60.0;

/// Lets critical robots that got no pile in `choices` take one from a robot that is charged.
pub(super) fn preempt(situation: &Situation, choices: &mut [Choice]) {
    let mut given: BTreeSet<PileId> = choices.iter().filter_map(|choice| choice.chosen).collect();
    let mut order: Vec<_> = (0..situation.askers.len().min(choices.len())).collect();
    order.sort_by(|&one, &other| priority::order(&situation.askers[one], &situation.askers[other]));
    for place in order {
        let (asker, choice) = (&situation.askers[place], &mut choices[place]);
        if !asker.is_critical || choice.chosen.is_some() || is_soon_served(asker, choice) {
            continue;
        }
        let Some(offer) = best(asker, &given) else { continue };
        let pile = offer.candidate.pile;
        given.insert(pile);
        choice.chosen = Some(pile);
        choice.stage = Stage::Preempting;
        let row = choice.explanations.iter_mut().find(|row| row.pile == pile);
        if let (Some(row), Some(holder)) = (row, offer.holder) {
            row.stage = PileStage::Preemptable;
            row.times = offer.times;
            row.verdict = Verdict::Preempts { robot: holder.robot };
        }
    }
}

/// Whether a pile that the robot waits for is free about when it can be there.
fn is_soon_served(asker: &Asker, choice: &Choice) -> bool {
    let rows = choice.explanations.iter().zip(&asker.offers);
    rows.filter(|(row, _)| matches!(row.verdict, Verdict::NotYet { .. }))
        .any(|(_, offer)| offer.times.is_some_and(|times| times.wait_s() <= WORTH_S))
}

fn best<'a>(asker: &'a Asker, given: &BTreeSet<PileId>) -> Option<&'a Offer> {
    let range = asker.range();
    let candidates = asker.offers.iter().filter_map(|offer| {
        let in_reach = offer.candidate.distance.is_some_and(|distance| distance <= range);
        let holder = offer.holder.filter(|_| in_reach && !given.contains(&offer.candidate.pile))?;
        Some((holder, offer))
    });
    let least = candidates.min_by(|(one, a), (other, b)| {
        let important = one.priority.cmp(&other.priority);
        important.then(other.share.total_cmp(&one.share)).then(a.candidate.pile.cmp(&b.candidate.pile))
    });
    least.map(|(_, offer)| offer)
}
