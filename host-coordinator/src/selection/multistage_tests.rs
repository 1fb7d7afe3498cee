use proptest::{collection::vec, option, prelude::*};

use super::*;

fn candidate(
    pile: u16,
    availability: Availability,
    remaining: f64,
    distance: f64,
    probability: f64,
) -> Candidate {
    Candidate {
        pile: PileId(pile),
        availability: Some(availability),
        remaining,
        distance: Some(distance),
        probability,
    }
}

fn idle(pile: u16, distance: f64, probability: f64) -> Candidate {
    candidate(pile, Availability::Free, 0.0, distance, probability)
}

#[test]
fn a_robot_that_reaches_all_goes_where_it_is_wanted() {
    let choice = choose(&[idle(1, 10.0, 0.2), idle(2, 90.0, 0.8)], 100.0, 0.9, Rule::Corrected);
    assert_eq!((choice.stage, choice.chosen), (Stage::ReachAll, Some(PileId(2))));
    assert_eq!(choice.explanations[0].verdict, Verdict::Outscored { by: PileId(2) });
}

#[test]
fn only_the_literal_rule_sends_a_robot_beyond_its_reach() {
    let piles = [idle(1, 10.0, 0.1), idle(2, 20.0, 0.1), idle(3, 90.0, 0.9)];
    let literal = choose(&piles, 50.0, 0.9, Rule::PaperLiteral);
    assert_eq!((literal.stage, literal.chosen), (Stage::ReachSome, Some(PileId(3))));
    let corrected = choose(&piles, 50.0, 0.9, Rule::Corrected);
    assert_eq!((corrected.stage, corrected.chosen), (Stage::ReachSome, Some(PileId(1))));
    assert_eq!(corrected.explanations[2].verdict, Verdict::OutOfReach { reach: 50.0 });
    assert_eq!(corrected.explanations[2].score, None);
}

#[test]
fn a_robot_that_reaches_no_idle_pile_gets_one_almost_charged() {
    let piles = [
        idle(1, 90.0, 0.9),
        candidate(2, Availability::Charging, 0.05, 30.0, 0.0),
        candidate(3, Availability::Charging, 0.5, 10.0, 0.1),
    ];
    let choice = choose(&piles, 50.0, 0.9, Rule::Corrected);
    assert_eq!((choice.stage, choice.chosen), (Stage::AlmostCharged, Some(PileId(2))));
    assert_eq!(choice.explanations[2].verdict, Verdict::StillCharging { remaining: 0.5 });
    let choice = choose(&piles, 100.0, 0.9, Rule::Corrected);
    assert_eq!(choice.explanations[1].verdict, Verdict::IdleInReach);
}

#[test]
fn the_literal_rule_takes_q_as_printed() {
    let piles = [candidate(2, Availability::Charging, 0.95, 30.0, 0.0)];
    assert_eq!(choose(&piles, 50.0, 0.9, Rule::PaperLiteral).chosen, Some(PileId(2)));
    assert_eq!(choose(&piles, 50.0, 0.9, Rule::Corrected).chosen, None);
}

#[test]
fn one_pile_or_all_as_far_divide_by_nothing() {
    for rule in [Rule::PaperLiteral, Rule::Corrected] {
        let one = choose(&[candidate(4, Availability::Charging, 0.5, 5.0, 0.3)], 9.0, 0.5, rule);
        assert_eq!((one.chosen, one.explanations[0].score), (Some(PileId(4)), Some(0.3)));
        let equal = choose(&[idle(1, 5.0, 0.1), idle(2, 5.0, 0.2), idle(3, 9.0, 0.0)], 5.0, 0.5, rule);
        assert_eq!(equal.chosen, Some(PileId(2)));
        let only = choose(&[idle(1, 0.0, 0.0)], 0.0, 0.5, rule);
        assert_eq!((only.stage, only.chosen), (Stage::ReachAll, Some(PileId(1))));
    }
}

#[test]
fn equal_scores_go_to_the_nearer_pile_then_to_the_lower_number() {
    let piles = [idle(9, 7.0, 0.1), idle(3, 5.0, 0.1), idle(2, 5.0, 0.1)];
    let choice = choose(&piles, 50.0, 0.9, Rule::Corrected);
    assert_eq!(choice.chosen, Some(PileId(2)));
    assert_eq!(choice.explanations[0].verdict, Verdict::Tied { with: PileId(2) });
}

#[test]
fn numbers_that_are_none_choose_nothing() {
    for reach in [f64::NAN, -1.0, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(choose(&[idle(1, 1.0, 0.1)], reach, 0.9, Rule::Corrected).chosen, None);
    }
    for distance in [f64::NAN, f64::INFINITY, -1.0] {
        let choice = choose(&[idle(1, distance, 0.1)], 1e9, 0.9, Rule::Corrected);
        assert_eq!(choice.explanations[0].verdict, Verdict::NoPath);
    }
}

fn availability() -> impl Strategy<Value = Option<Availability>> {
    option::weighted(
        0.9,
        prop_oneof![
            3 => Just(Availability::Free),
            2 => Just(Availability::Charging),
            1 => Just(Availability::Reserved),
            1 => Just(Availability::Done),
            1 => Just(Availability::Fault),
        ],
    )
}

/// Few distinct values, so that ties, equal distances and exact reaches are common.
fn coarse(steps: u8, step: f64) -> impl Strategy<Value = f64> {
    (0..=steps).prop_map(move |count| f64::from(count) * step)
}

fn candidates() -> impl Strategy<Value = Vec<Candidate>> {
    let one = (availability(), coarse(4, 0.25), option::weighted(0.9, coarse(8, 10.0)), coarse(3, 0.1));
    vec(one, 0..12).prop_map(|rows| {
        let candidate = |(pile, (availability, remaining, distance, probability))| Candidate {
            pile: PileId(pile),
            availability,
            remaining,
            distance,
            probability,
        };
        (1..).zip(rows).map(candidate).collect()
    })
}

/// Any number that a float can be, and those that matter more often.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![any::<f64>(), Just(f64::INFINITY), Just(f64::NAN), 0.0..=1.0]
}

fn any_rule() -> impl Strategy<Value = Rule> {
    prop_oneof![Just(Rule::PaperLiteral), Just(Rule::Corrected)]
}

proptest! {
    #[test]
    fn the_chosen_pile_can_be_used(piles in candidates(), reach in coarse(9, 10.0), q in coarse(4, 0.25), rule in any_rule()) {
        let choice = choose(&piles, reach, q, rule);
        if let Some(chosen) = choice.chosen {
            let pile = piles.iter().find(|pile| pile.pile == chosen).unwrap();
            prop_assert!(matches!(pile.availability, Some(Availability::Free | Availability::Charging)));
            let distance = pile.distance.unwrap();
            prop_assert!(distance <= reach || rule == Rule::PaperLiteral);
            if pile.availability == Some(Availability::Charging) && rule == Rule::Corrected {
                prop_assert!(pile.remaining <= 1.0 - q);
            }
        }
    }

    #[test]
    fn nothing_in_reach_chooses_nothing_and_something_chooses_something(
        piles in candidates(), reach in coarse(9, 10.0), q in coarse(4, 0.25), rule in any_rule(),
    ) {
        let usable = piles.iter().any(|pile| {
            let set = pile.stage(q, rule);
            set != PileStage::Unusable && pile.distance.is_some_and(|distance| distance <= reach)
        });
        let choice = choose(&piles, reach, q, rule);
        prop_assert_eq!(choice.chosen.is_some(), usable);
        prop_assert_eq!(choice.stage == Stage::None, !usable);
    }

    #[test]
    fn the_order_of_the_candidates_does_not_matter(
        (piles, shuffled) in candidates().prop_flat_map(|piles| (Just(piles.clone()), Just(piles).prop_shuffle())),
        reach in coarse(9, 10.0), q in coarse(4, 0.25), rule in any_rule(),
    ) {
        prop_assert_eq!(choose(&piles, reach, q, rule).chosen, choose(&shuffled, reach, q, rule).chosen);
    }

    #[test]
    fn the_chosen_pile_has_the_best_score_and_ties_go_to_the_nearer_then_lower(
        piles in candidates(), reach in coarse(9, 10.0), q in coarse(4, 0.25), rule in any_rule(),
    ) {
        let choice = choose(&piles, reach, q, rule);
        let rows = &choice.explanations;
        if let Some(best) = rows.iter().find(|row| row.verdict == Verdict::Chosen) {
            prop_assert_eq!(choice.chosen, Some(best.pile));
            for other in rows.iter().filter(|row| row.score.is_some() && row.pile != best.pile) {
                let key = |row: &Explanation| (-row.score.unwrap(), row.distance.unwrap(), row.pile);
                prop_assert!(key(best) < key(other));
            }
        } else {
            prop_assert_eq!(choice.chosen, None);
        }
    }

    #[test]
    fn whatever_goes_in_no_score_is_nan_and_every_pile_is_explained(
        rows in vec((availability(), number(), option::of(number()), number()), 0..8),
        reach in number(), q in number(), rule in any_rule(),
    ) {
        let piles: Vec<_> = (1..).zip(rows).map(|(pile, (availability, remaining, distance, probability))| {
            Candidate { pile: PileId(pile), availability, remaining, distance, probability }
        }).collect();
        let choice = choose(&piles, reach, q, rule);
        prop_assert_eq!(choice.explanations.len(), piles.len());
        prop_assert_eq!(choice.chosen.is_none(), choice.stage == Stage::None);
        for row in &choice.explanations {
            prop_assert!(row.score.is_none_or(f64::is_finite));
            prop_assert!(row.probability.is_finite() && row.distance.is_none_or(f64::is_finite));
        }
    }
}
