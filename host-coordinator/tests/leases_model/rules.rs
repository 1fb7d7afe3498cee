//! What must hold whatever happens, and what must be possible so that it means anything.

use std::collections::BTreeSet;

use host_coordinator::core::{
    CLOCK_MARGIN, Fact,
    event::LeaseEnd,
    state::{Lease, Phase},
};
use protocol::{EndReason, Epoch, limits};
use stateright::Property;

use crate::world::{Rule, Snapshot, World};

/// The rule for which there are leases.
pub const TWO_HOLDERS: &str = "a pile never has two holders";

/// Why the older of two coordinators does no harm.
pub const LOWER_EPOCH: &str = "no lower epoch is obeyed after a higher one";

/// All of them, and what is met within the depth to which a rule is followed.
pub fn properties(rule: Rule) -> Vec<Property<World>> {
    let mut properties = vec![
        Property::always(TWO_HOLDERS, no_two_holders),
        Property::always("no lease takes the place of one that has not ended", |world, of| {
            world.each_pile(of, |pile| !pile.replaced)
        }),
        Property::always("a robot never has two piles", no_two_piles),
        Property::always(LOWER_EPOCH, |world, of| world.each_pile(of, |pile| !pile.misled)),
        Property::always("at a pile a lease is over by its expiry, a charge by its plan", |world, of| {
            world.each_pile(of, |pile| pile.ends_in_time(of.piles_now()))
        }),
        Property::always(
            "in the log a lease is over by its expiry and margin, or its pile is heard",
            leaves_the_log,
        ),
        Property::sometimes("a charge is complete", |world, of| has_ended(world, of, EndReason::Completed)),
        Property::sometimes("a lease is taken back", |world, of| has_ended(world, of, EndReason::Revoked)),
        Property::sometimes("a lease runs out at its pile", |world, of| {
            has_ended(world, of, EndReason::Expired)
        }),
    ];
    if rule != Rule::Claims {
        // With claims the world is not followed that far.
        properties.push(Property::sometimes("a pile obeys a second epoch", |world, of| {
            !world.each_pile(of, |pile| pile.obeyed <= Epoch(1))
        }));
    }
    if rule == Rule::Claims {
        properties.push(Property::sometimes(
            "a lease that a pile made for itself is adopted",
            |world, of| {
                !world.each_desk(of, |desk| {
                    let adopted =
                        |fact: &Fact| matches!(fact, Fact::Adopted { lease, .. } if lease.lease.is_local());
                    desk.log.iter().all(|event| !adopted(&event.fact))
                })
            },
        ));
        properties.push(Property::sometimes(
            "a robot is charged under a lease that its pile made",
            |world, of| {
                !world.each_pile(of, |pile| {
                    let charges = |lease: &firmware_pile::lease::Lease| {
                        lease.name.lease.is_local() && lease.charge.is_some()
                    };
                    !pile.leases.current().is_some_and(charges)
                })
            },
        ));
    }
    if rule == Rule::Succession {
        // Rivals are not followed that far.
        properties.push(Property::sometimes("a lease runs out in the log", |world, of| {
            !world.each_desk(of, |desk| {
                desk.log.iter().all(|event| !matches!(event.fact, Fact::Ended { why: LeaseEnd::RanOut, .. }))
            })
        }));
    }
    properties
}

/// With one log: a lease that is alive at a pile is the one that the log has for it, so nobody else can
/// have been given that pile. With two: what a pile has promised to the coordinator with the highest epoch
/// it knows is not given to another robot while the promise lasts.
fn no_two_holders(world: &World, of: &Snapshot) -> bool {
    world.each_pile_and_desk(of, |id, pile, desk| {
        let recorded = desk.state.lease(id);
        let Some(alive) = pile.leases.current().filter(|lease| of.piles_now() < lease.expiry) else {
            return true;
        };
        let same =
            |lease: &Lease| (lease.name.lease, lease.name.robot) == (alive.name.lease, alive.name.robot);
        match world.rule {
            // The log learns of it when the pile is heard.
            Rule::Claims if alive.name.lease.is_local() => true,
            Rule::Succession | Rule::Claims => recorded.is_some_and(same),
            Rule::Rivals => recorded
                .filter(|lease| {
                    let lasts = matches!(lease.phase, Phase::Held { until } if of.now() < until);
                    lasts && lease.command.is_none() && lease.name.epoch == pile.leases.highest_epoch()
                })
                .is_none_or(same),
        }
    })
}

/// No coordinator means two leases for one robot to last.
fn no_two_piles(world: &World, of: &Snapshot) -> bool {
    world.each_desk(of, |desk| {
        let leases = desk.state.piles.values().filter_map(|record| record.lease.as_ref());
        let mut robots = BTreeSet::new();
        leases.filter(|lease| lease.is_wanted()).all(|lease| robots.insert(lease.name.robot))
    })
}

fn leaves_the_log(world: &World, of: &Snapshot) -> bool {
    let now = of.now();
    world.each_at_work(of, |desk| {
        desk.state.piles.values().zip(&desk.heard).all(|(record, heard)| {
            let is_heard = now.since(heard.map_or(desk.started, |(_, at)| at)) <= limits::SILENCE;
            record.lease.is_none_or(|lease| {
                let held = matches!(lease.phase, Phase::Held { .. });
                now <= lease.expiry.after(CLOCK_MARGIN) || (held && is_heard)
            })
        })
    })
}

fn has_ended(world: &World, of: &Snapshot, reason: EndReason) -> bool {
    !world.each_pile(of, |pile| pile.leases.ended().is_none_or(|ended| ended.reason != reason))
}
