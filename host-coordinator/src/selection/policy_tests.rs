use std::collections::{BTreeMap, BTreeSet};

use proptest::{collection::vec, option, prelude::*};
use protocol::{Availability, CoordinateM, EnergyJ, PileId, Position, RobotId, SiteMillis, TaskPriority};

use super::*;
use crate::selection::{Asker, Candidate, Holder, Offer, Stage, Times, Verdict, priority};

/// A pile as all robots see it.
#[derive(Clone, Copy, Debug)]
struct Pile {
    availability: Option<Availability>,
    next_is_open: bool,
    free_in_s: f64,
    holder: Option<Holder>,
}

fn free() -> Pile {
    Pile { availability: Some(Availability::Free), next_is_open: false, free_in_s: 0.0, holder: None }
}

fn occupied(free_in_s: f64) -> Pile {
    Pile { availability: Some(Availability::Charging), next_is_open: true, free_in_s, holder: None }
}

/// A robot that asked at `asked_s` and drives one cell a second, `distances` from the piles.
fn asker(number: u16, asked_s: u64, share: f64, piles: &[Pile], distances: &[Option<f64>]) -> Asker {
    let waited_s = 1_000.0 - asked_s as f64;
    let offers = (1..).zip(piles.iter().zip(distances)).map(|(pile, (what, &distance))| {
        let candidate = Candidate {
            pile: PileId(pile),
            availability: what.availability,
            remaining: 0.5,
            distance,
            probability: 0.0,
        };
        let times = distance.map(|distance| Times {
            drive_s: distance,
            doors_s: 0.0,
            free_in_s: what.free_in_s,
            charge_s: 100.0,
            back_s: distance,
            lasts_s: 10_000.0,
        });
        let times = times.filter(|_| what.availability != Some(Availability::Fault));
        let free_in_s = Some(what.free_in_s);
        Offer {
            candidate,
            stands_here: false,
            free_in_s,
            next_is_open: what.next_is_open,
            holder: what.holder,
            times,
        }
    });
    Asker {
        robot: RobotId(number),
        position: Position { x: CoordinateM::default(), y: CoordinateM::default() },
        energy: EnergyJ::MIN,
        asked_at: SiteMillis(asked_s * 1_000),
        waited_s,
        urgency: priority::urgency(share, TaskPriority::USUAL, waited_s),
        is_critical: priority::score(share, TaskPriority::USUAL).is_none(),
        reach: 100.0 * share,
        sure_reach: 80.0 * share,
        standing_w: 30.0,
        offers: offers.collect(),
    }
}

fn chosen(policy: PolicyName, askers: Vec<Asker>) -> Vec<Option<u16>> {
    let choices = policy.policy(0.9).choose(&Situation { askers });
    choices.into_iter().map(|choice| choice.chosen.map(|pile| pile.0)).collect()
}

#[test]
fn together_no_robot_takes_the_only_pile_that_another_reaches() {
    let piles = [free(), free()];
    let both = |number, asked, distances: [Option<f64>; 2]| asker(number, asked, 0.5, &piles, &distances);
    let askers = vec![both(1, 0, [Some(10.0), Some(12.0)]), both(2, 1, [Some(11.0), None])];
    assert_eq!(chosen(PolicyName::Nearest, askers.clone()), [Some(1), None], "first come, first served");
    assert_eq!(chosen(PolicyName::Joint, askers), [Some(2), Some(1)]);
}

#[test]
fn the_critical_robot_comes_first_where_urgency_counts() {
    let piles = [free()];
    let askers = vec![asker(1, 998, 0.9, &piles, &[Some(1.0)]), asker(2, 999, 0.05, &piles, &[Some(2.0)])];
    assert_eq!(chosen(PolicyName::Nearest, askers.clone()), [Some(1), None]);
    assert_eq!(chosen(PolicyName::Access, askers.clone()), [None, Some(1)]);
    assert_eq!(chosen(PolicyName::Joint, askers), [None, Some(1)]);
}

#[test]
fn an_occupied_pile_is_promised_when_the_robot_has_to_set_off_and_no_sooner() {
    let one = |free_in_s| {
        let piles = [occupied(free_in_s)];
        let situation = Situation { askers: vec![asker(1, 900, 0.5, &piles, &[Some(20.0)])] };
        let choice = Joint.choose(&situation).remove(0);
        (choice.chosen.is_some(), choice.stage, choice.explanations[0].verdict)
    };
    assert_eq!(one(49.0), (true, Stage::Together, Verdict::Chosen));
    assert_eq!(one(51.0), (false, Stage::Later, Verdict::NotYet { free_in_s: 51.0 }));
}

#[test]
fn a_robot_goes_beyond_its_sure_reach_only_where_nothing_else_is_left() {
    let to = |near: Pile| {
        let piles = [near, free()];
        chosen(PolicyName::Joint, vec![asker(1, 900, 0.5, &piles, &[Some(39.0), Some(45.0)])])
    };
    assert_eq!(to(free()), [Some(1)]);
    assert_eq!(to(Pile { availability: Some(Availability::Fault), ..free() }), [Some(2)]);
    assert_eq!(to(occupied(500.0)), [None], "it waits for what it surely reaches");
}

#[test]
fn a_robot_is_not_sent_where_its_battery_would_be_empty_before_its_turn_comes() {
    let piles = [occupied(200.0), occupied(400.0)];
    let to = |lasts_s| {
        let mut asker = asker(1, 900, 0.5, &piles, &[Some(39.0), Some(2.0)]);
        asker.offers.iter_mut().flat_map(|offer| &mut offer.times).for_each(|times| {
            times.charge_s = if times.drive_s < 10.0 { 0.0 } else { 300.0 };
            times.lasts_s = lasts_s;
        });
        let choice = Joint.choose(&Situation { askers: vec![asker] }).remove(0);
        choice.explanations.iter().position(|row| matches!(row.verdict, Verdict::NotYet { .. }))
    };
    assert_eq!(to(10_000.0), Some(1), "there it works again sooner");
    assert_eq!(to(300.0), Some(0), "there its battery would be empty");
    assert_eq!(to(100.0), Some(0), "there it is empty for less long");
}

#[test]
fn no_charge_is_cut_short_far_away_for_a_robot_that_a_pile_nearby_serves_in_time() {
    let holder = Some(Holder { robot: RobotId(9), priority: TaskPriority::USUAL, share: 0.9 });
    let piles = [occupied(300.0), Pile { holder, next_is_open: false, ..occupied(300.0) }];
    // It surely gets 8 cells far, and on average 10.
    let to = |lasts_s| {
        let mut asker = asker(1, 900, 0.1, &piles, &[Some(1.0), Some(9.0)]);
        asker.offers.iter_mut().flat_map(|offer| &mut offer.times).for_each(|times| times.lasts_s = lasts_s);
        Joint.choose(&Situation { askers: vec![asker] }).remove(0).chosen
    };
    assert_eq!(to(400.0), None);
    assert_eq!(to(200.0), Some(PileId(2)), "standing still is no better");
}

#[test]
fn what_is_said_to_change_the_choice_does() {
    let piles = [free(), free(), free()];
    let askers = |shorter: f64| {
        vec![
            asker(1, 900, 0.5, &piles, &[Some(10.0 - shorter), Some(4.0), Some(30.0)]),
            asker(2, 900, 0.5, &piles, &[Some(12.0), Some(3.0), Some(9.0)]),
        ]
    };
    let choices = Joint.choose(&Situation { askers: askers(0.0) });
    assert_eq!(choices[0].chosen, Some(PileId(2)));
    let Verdict::Costlier { by_s, to: None } = choices[0].explanations[0].verdict else {
        panic!("{choices:?}")
    };
    // Both the way there and the way back are shorter.
    assert_eq!(chosen(PolicyName::Joint, askers(by_s / 2.0 - 0.1))[0], Some(2));
    assert_eq!(chosen(PolicyName::Joint, askers(by_s / 2.0 + 0.1))[0], Some(1));
}

fn held_by(robot: u16, priority: u8, share: f64) -> Holder {
    Holder { robot: RobotId(robot), priority: TaskPriority::new(priority).unwrap(), share }
}

const fn is_chosen(verdict: &Verdict) -> bool {
    matches!(verdict, Verdict::Chosen | Verdict::Preempts { .. })
}

#[test]
fn a_critical_robot_takes_the_pile_of_the_least_important_and_then_best_charged() {
    let held = |priority, share| Pile { holder: Some(held_by(7, priority, share)), ..occupied(900.0) };
    let piles = [held(8, 0.9), held(3, 0.6), held(3, 0.7), Pile { holder: None, ..occupied(900.0) }];
    let ways = [Some(1.0), Some(2.0), Some(2.0), Some(1.0)];
    for name in [PolicyName::Access, PolicyName::Joint] {
        assert_eq!(chosen(name, vec![asker(1, 900, 0.05, &piles, &ways)]), [Some(3)], "{name}");
        assert_eq!(
            chosen(name, vec![asker(1, 900, 0.3, &piles, &ways)]),
            [None],
            "{name}: it is not critical"
        );
        let far = [None, None, Some(80.0), Some(80.0)];
        assert_eq!(
            chosen(name, vec![asker(1, 900, 0.05, &piles, &far)]),
            [None],
            "{name}: it would not get there"
        );
    }
    let one = |number, asked| asker(number, asked, 0.05, &piles[..2], &ways[..2]);
    let both = vec![one(1, 950), one(2, 900)];
    assert_eq!(chosen(PolicyName::Joint, both), [Some(1), Some(2)], "who waits longer comes first");
    for name in [PolicyName::Nearest, PolicyName::Lmpp] {
        assert_eq!(chosen(name, vec![one(1, 900)]), [None], "{name} cuts no charge short");
    }
}

#[test]
fn nobody_is_sent_off_for_a_robot_that_is_served_soon_anyway() {
    let piles = [Pile { holder: Some(held_by(7, 1, 0.9)), ..occupied(900.0) }, occupied(55.0)];
    let situation = Situation { askers: vec![asker(1, 900, 0.08, &piles, &[Some(2.0), Some(3.0)])] };
    assert_eq!(Joint.choose(&situation)[0].stage, Stage::Later);
}

fn situations() -> impl Strategy<Value = Situation> {
    let availability = prop_oneof![
        4 => Just(Availability::Free),
        3 => Just(Availability::Charging),
        1 => Just(Availability::Reserved),
        1 => Just(Availability::Done),
        1 => Just(Availability::Fault),
    ];
    let holder = option::of((0u8..=10, 0.0..1.0));
    let pile = (option::weighted(0.9, availability), any::<bool>(), 0.0..200.0, holder).prop_map(
        |(availability, open, free_in_s, holder)| {
            let occupied = matches!(availability, Some(Availability::Charging | Availability::Reserved));
            let charging = availability == Some(Availability::Charging) && open;
            let holder = holder.filter(|_| charging).map(|(priority, share)| held_by(99, priority, share));
            Pile { availability, next_is_open: open && occupied, free_in_s, holder }
        },
    );
    vec(pile, 0..6).prop_flat_map(|piles| {
        let ways = vec(option::weighted(0.9, 0.0..100.0), piles.len());
        vec((0u64..1_000, 0.0..1.0, ways), 0..6).prop_map(move |robots| {
            let askers = (1..)
                .zip(robots)
                .map(|(number, (asked_s, share, ways))| asker(number, asked_s, share, &piles, &ways));
            Situation { askers: askers.collect() }
        })
    })
}

proptest! {
    #[test]
    fn together_nobody_overtakes_who_asked_so_much_later_for_a_pile_that_both_can_have(
        shares in (0.3..1.0, 0.3..1.0), ways in (0.0..20.0, 0.0..20.0), asked_s in 100u64..200,
    ) {
        let piles = [free()];
        let first = asker(1, 0, shares.0, &piles, &[Some(ways.0)]);
        // There and back, one cell a second.
        let takes_less_s = f64::max(0.0, 2.0 * (ways.0 - ways.1));
        let later_s = priority::CRITICAL * priority::AGEING_S + takes_less_s.ceil() + 1.0 + asked_s as f64;
        let second = asker(2, later_s as u64, shares.1, &piles, &[Some(ways.1)]);
        prop_assert_eq!(chosen(PolicyName::Joint, vec![first, second]), [Some(1), None]);
    }

    #[test]
    fn no_pile_is_chosen_twice_and_every_choice_is_possible_and_explained(situation in situations()) {
        for name in PolicyName::ALL {
            let choices = name.policy(0.9).choose(&situation);
            prop_assert_eq!(choices.len(), situation.askers.len(), "{}", name);
            let mut given = BTreeSet::new();
            for (asker, choice) in situation.askers.iter().zip(&choices) {
                prop_assert_eq!(choice.explanations.len(), asker.offers.len());
                prop_assert_eq!(choice.chosen.is_none(), matches!(choice.stage, Stage::None | Stage::Later));
                let marked: Vec<_> =
                    choice.explanations.iter().filter(|row| is_chosen(&row.verdict)).collect();
                prop_assert_eq!(marked.first().map(|row| row.pile), choice.chosen);
                let Some(pile) = choice.chosen else { continue };
                prop_assert!(given.insert(pile), "{name}: pile {pile} twice");
                let offer = asker.offers.iter().find(|offer| offer.candidate.pile == pile).unwrap();
                let distance = offer.candidate.distance.unwrap();
                prop_assert!(distance <= asker.reach || name == PolicyName::LmppLiteral);
                let usable = [Some(Availability::Free), Some(Availability::Charging)];
                prop_assert!(usable.contains(&offer.candidate.availability) || offer.next_is_open);
            }
        }
    }

    #[test]
    fn the_order_of_the_robots_does_not_matter(
        (situation, shuffled) in situations().prop_flat_map(|situation| {
            let askers = Just(situation.askers.clone()).prop_shuffle();
            (Just(situation), askers.prop_map(|askers| Situation { askers }))
        }),
    ) {
        let by_robot = |name: PolicyName, situation: &Situation| -> BTreeMap<RobotId, Option<PileId>> {
            let choices = name.policy(0.9).choose(situation);
            situation.askers.iter().map(|asker| asker.robot).zip(choices.iter().map(|choice| choice.chosen)).collect()
        };
        for name in [PolicyName::Nearest, PolicyName::Access, PolicyName::Lmpp] {
            prop_assert_eq!(by_robot(name, &situation), by_robot(name, &shuffled), "{}", name);
        }
    }

    #[test]
    fn together_no_more_robots_could_be_served(situation in situations()) {
        let served = |name: PolicyName| {
            let choices = name.policy(0.9).choose(&situation);
            let later = choices.iter().filter(|choice| choice.stage == Stage::Later).count();
            choices.iter().filter(|choice| choice.chosen.is_some()).count() + later
        };
        // The nearest-free policy drives as far as the mean reach; that is compared where both mean the same.
        let surely = situation.askers.iter().all(|asker| {
            asker.offers.iter().all(|offer| {
                offer.candidate.distance.is_none_or(|way| way <= asker.sure_reach || way > asker.reach)
            })
        });
        prop_assume!(surely);
        prop_assert!(served(PolicyName::Joint) >= served(PolicyName::Nearest));
    }
}

#[test]
fn every_policy_is_found_by_its_name_and_no_other_is() {
    for policy in PolicyName::ALL {
        assert_eq!(policy.name().parse(), Ok(policy));
    }
    let error = "best".parse::<PolicyName>().unwrap_err().to_string();
    for policy in PolicyName::ALL {
        assert!(error.contains(policy.name()), "{error}");
    }
}
