//! What holds whatever happens to a pile: [`Witness`] checks it after every step. Numbers are few
//! and small, so that robots, leases, epochs and commands collide.

use proptest::{prelude::*, strategy::ValueTree, test_runner::TestRunner};
use protocol::{Epoch, LeaseId, LeaseRef, RobotId};

use crate::witness::Witness;

#[derive(Clone, Debug)]
enum Event {
    Sleep(u64),
    StepBack(u64),
    Stand { robot: u16, reads: u8 },
    Read { robot: u16, rssi_dbm: i8 },
    ReadNothing,
    FindContactor(bool),
    Synchronise,
    Acknowledge(u32),
    Grant { lease: LeaseRef, charge_ms: u16, life_ms: u16, lease_ms: u16 },
    Revoke { lease: LeaseRef, life_ms: u16 },
    Repeat(usize),
}

fn tell(witness: &mut Witness, event: &Event) {
    match *event {
        Event::Sleep(ms) => witness.sleep(ms),
        Event::StepBack(ms) => witness.step_back(ms),
        Event::Stand { robot, reads } => {
            for _ in 0..reads {
                witness.sleep(100);
                witness.read(robot, -45);
            }
        }
        Event::Read { robot, rssi_dbm } => witness.read(robot, rssi_dbm),
        Event::ReadNothing => witness.read_nothing(),
        Event::FindContactor(closed) => witness.find_contactor(closed),
        Event::Synchronise => witness.synchronise(),
        Event::Acknowledge(report) => witness.acknowledge(report),
        Event::Grant { lease, charge_ms, life_ms, lease_ms } => {
            witness.grant(lease, charge_ms, life_ms, lease_ms)
        }
        Event::Revoke { lease, life_ms } => witness.revoke(lease, life_ms),
        Event::Repeat(index) => witness.repeat(index),
    }
}

/// Leases whose numbers mostly belong to one robot, as a coordinator would give them.
fn any_lease() -> impl Strategy<Value = LeaseRef> {
    (0u32..3, 0u32..6, 0u16..10).prop_map(|(epoch, lease, robot)| LeaseRef {
        epoch: Epoch(epoch),
        lease: LeaseId(lease),
        robot: RobotId(if robot < 8 { u16::try_from(lease % 2).unwrap_or(0) } else { robot % 3 }),
    })
}

fn any_event() -> impl Strategy<Value = Event> {
    let any_sleep = prop_oneof![6 => 0u64..500, 2 => 500u64..5_000, 1 => 5_000u64..200_000];
    let any_grant = (any_lease(), 0u16..15_000, 0u16..5_000, 0u16..20_000).prop_map(
        |(lease, charge_ms, life_ms, lease_ms)| Event::Grant { lease, charge_ms, life_ms, lease_ms },
    );
    prop_oneof![
        6 => any_sleep.prop_map(Event::Sleep),
        1 => (0u64..10_000).prop_map(Event::StepBack),
        8 => (0u16..3, 1u8..60).prop_map(|(robot, reads)| Event::Stand { robot, reads }),
        4 => (0u16..3, -75i8..-50).prop_map(|(robot, rssi_dbm)| Event::Read { robot, rssi_dbm }),
        3 => Just(Event::ReadNothing),
        2 => prop::bool::ANY.prop_map(Event::FindContactor),
        4 => Just(Event::Synchronise),
        2 => (0u32..8).prop_map(Event::Acknowledge),
        8 => any_grant,
        1 => (any_lease(), 0u16..5_000).prop_map(|(lease, life_ms)| Event::Revoke { lease, life_ms }),
        2 => (0usize..50).prop_map(Event::Repeat),
    ]
}

fn any_history() -> impl Strategy<Value = Vec<Event>> {
    prop::collection::vec(any_event(), 0..120)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn contacts_are_live_only_for_the_robot_that_holds_the_lease(history in any_history()) {
        let mut witness = Witness::new();
        for event in &history {
            tell(&mut witness, event);
        }
    }
}

/// The property above would hold for a pile that never does anything.
#[test]
fn the_histories_charge_many_robots() {
    let mut runner = TestRunner::deterministic();
    let (mut live, mut completed) = (0, 0);
    for _ in 0..300 {
        let history = any_history().new_tree(&mut runner).unwrap().current();
        let mut witness = Witness::new();
        history.iter().for_each(|event| tell(&mut witness, event));
        live += usize::from(witness.live_steps > 0);
        completed += witness.completed;
    }
    assert!(live > 100, "only {live} of 300 histories had live contacts");
    assert!(completed > 50, "only {completed} charges were completed");
}
