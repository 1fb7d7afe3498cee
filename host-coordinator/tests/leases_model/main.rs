//! The lease protocol, every order of events to a depth: the real coordinator core and the real leases
//! of a pile among messages that are lost, repeated and late, and crashes of everyone.
//!
//! Two piles, two robots, a clock of five seconds. A message may arrive any number of times, in any order,
//! or never. Coordinators, piles and robots crash and start again, a coordinator with its log and a pile
//! with its epoch. The piles' clocks are right, or late by as much as the coordinator allows for.
//!
//! Three questions are asked of the same world ([`world::Rule`]):
//! - **Succession**: one log. A coordinator that crashes is followed by another, and what the first has sent
//!   may still arrive. Every lease that is alive at a pile is the one in the log.
//! - **Claims**: the same, and robots claim piles by themselves. No lease takes the place of another, whatever
//!   the coordinator gives at the same time, and it learns of what they settle.
//! - **Rivals**: two coordinators at once, the second with the first one's log from before its leases,
//!   as when somebody restores a backup. Both command; a pile obeys the higher epoch. What that
//!   coordinator has been promised by a pile is never given to another robot.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod interner;
mod office;
mod pile;
mod rules;
mod world;

use std::time::Instant;

use pile::Firmware;
use stateright::{Checker, HasDiscoveries, Model};
use world::{Rule, World};

/// Explores all orders of up to `actions` things that happen, until `enough` is found, and says what that
/// took.
fn explore(world: World, actions: usize, enough: HasDiscoveries) -> impl Checker<World> {
    let begun = Instant::now();
    let name = format!("{:?} with {:?} piles", world.rule, world.firmware);
    // The checker counts the first state too, and looks at no state of the depth it is told.
    let checker = world.checker().target_max_depth(actions + 2).finish_when(enough).spawn_bfs().join();
    println!(
        "{name}: {} states, {} of them different, {actions} actions deep, {:.1} s",
        checker.state_count(),
        checker.unique_state_count(),
        begun.elapsed().as_secs_f64()
    );
    checker
}

#[test]
fn one_log_whatever_happens_never_two_holders_and_every_lease_ends() {
    explore(World::new(Rule::Succession, Firmware::Real, [2, 1, 1]), 6, HasDiscoveries::AnyFailures)
        .assert_properties();
}

/// Claims are not bound to any time of silence here.
#[test]
fn robots_that_claim_piles_by_themselves_never_two_holders_and_every_lease_ends() {
    explore(World::new(Rule::Claims, Firmware::Real, [1, 1, 0]), 5, HasDiscoveries::AnyFailures)
        .assert_properties();
}

#[test]
fn two_coordinators_at_once_never_two_holders_and_every_lease_ends() {
    explore(World::new(Rule::Rivals, Firmware::Real, [1, 1, 1]), 5, HasDiscoveries::AnyFailures)
        .assert_properties();
}

/// The model is worth something: it finds what a defect leads to.
#[test]
fn a_pile_that_breaks_a_rule_is_found_out() {
    for (rule, firmware, crashes, broken) in [
        (Rule::Succession, Firmware::BelievesFramesForOtherStarts, [0, 1, 0], rules::TWO_HOLDERS),
        (Rule::Rivals, Firmware::IgnoresEpochs, [0, 0, 0], rules::LOWER_EPOCH),
    ] {
        let enough = HasDiscoveries::AnyOf([broken].into());
        let found = explore(World::new(rule, firmware, crashes), 6, enough);
        println!("{broken}, but for {:?}", found.assert_any_discovery(broken).into_actions());
    }
}
