//! What holds whatever happens to a pile: [`Witness`] checks it after every step. Numbers are few
//! and small, so that robots, leases, epochs and commands collide.

use std::collections::BTreeSet;

use firmware_pile::{ChargingPile, Input, Parameters, TagRead, plant::Says};
use proptest::{prelude::*, strategy::ValueTree, test_runner::TestRunner};
use protocol::*;

use crate::witness::Witness;

#[derive(Clone, Debug)]
enum Event {
    Sleep(u64),
    StepBack(u64),
    /// The sensors are read, the reader too, and the robot touches the contacts.
    Stand {
        robot: u16,
        reads: u8,
    },
    Sense(u32),
    Touch(bool),
    Read {
        robot: u16,
        rssi_dbm: i8,
    },
    ReadNothing,
    Weld(bool),
    Jam(bool),
    Mains(bool),
    Stop(bool),
    Reverse(bool),
    RunAway(Option<f32>),
    Leak(f32),
    Voltage(Says),
    Current(Says),
    Temperature(Says),
    /// Everything is sound again, and if `cleared` the pile is told so.
    Mend {
        cleared: bool,
    },
    Clear {
        code: FaultCode,
        service: bool,
    },
    Synchronise,
    Acknowledge(u32),
    Grant {
        lease: LeaseRef,
        charge_ms: u16,
        life_ms: u16,
        lease_ms: u16,
    },
    Revoke {
        lease: LeaseRef,
        life_ms: u16,
    },
    Repeat(usize),
}

fn tell(witness: &mut Witness, event: &Event) {
    match *event {
        Event::Sleep(ms) => witness.sleep(ms),
        Event::StepBack(ms) => witness.step_back(ms),
        Event::Stand { robot, reads } => {
            witness.touch(true);
            for _ in 0..reads {
                witness.sense(100);
                witness.read(robot, -45);
            }
        }
        Event::Read { robot, rssi_dbm } => witness.read(robot, rssi_dbm),
        Event::ReadNothing => witness.read_nothing(),
        Event::Sense(ms) => witness.sense(ms),
        Event::Touch(touches) => witness.touch(touches),
        Event::Weld(welded) => witness.plant.welded = welded,
        Event::Jam(jammed) => witness.plant.jammed = jammed,
        Event::Mains(mains) => witness.plant.mains = mains,
        Event::Stop(pressed) => witness.plant.emergency_stop = pressed,
        Event::Reverse(reversed) => {
            if let Some(battery) = &mut witness.plant.battery {
                battery.reversed = reversed;
            }
        }
        Event::RunAway(current_a) => witness.plant.runaway_a = current_a,
        Event::Leak(current_a) => witness.plant.leak_a = current_a,
        Event::Voltage(says) => witness.plant.voltage = says,
        Event::Current(says) => witness.plant.current = says,
        Event::Temperature(says) => witness.plant.temperature = says,
        Event::Mend { cleared } => {
            witness.mend();
            if cleared {
                witness.sense(1_200);
                FaultCode::ALL.into_iter().for_each(|code| witness.clear(code, true));
            }
        }
        Event::Clear { code, service } => witness.clear(code, service),
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
        2 => (0u32..600).prop_map(Event::Sense),
        2 => prop::bool::ANY.prop_map(Event::Touch),
        2 => any_break(),
        3 => prop::bool::weighted(0.8).prop_map(|cleared| Event::Mend { cleared }),
        3 => (prop::sample::select(&FaultCode::ALL[..]), prop::bool::ANY)
            .prop_map(|(code, service)| Event::Clear { code, service }),
        4 => Just(Event::Synchronise),
        2 => (0u32..8).prop_map(Event::Acknowledge),
        8 => any_grant,
        1 => (any_lease(), 0u16..5_000).prop_map(|(lease, life_ms)| Event::Revoke { lease, life_ms }),
        2 => (0usize..50).prop_map(Event::Repeat),
    ]
}

/// What a sensor of this range may say: mostly what it measures.
fn any_says(range: std::ops::Range<f32>) -> impl Strategy<Value = Says> {
    let nonsense = prop::sample::select(&[f32::NAN, f32::INFINITY, f32::NEG_INFINITY][..]);
    prop_oneof![
        range.clone().prop_map(Says::About),
        range.prop_map(Says::Exactly),
        nonsense.prop_map(Says::Exactly),
    ]
}

fn any_break() -> impl Strategy<Value = Event> {
    prop_oneof![
        prop::bool::ANY.prop_map(Event::Weld),
        prop::bool::ANY.prop_map(Event::Jam),
        prop::bool::ANY.prop_map(Event::Mains),
        prop::bool::ANY.prop_map(Event::Stop),
        prop::bool::ANY.prop_map(Event::Reverse),
        prop::option::of(0.0f32..12.0).prop_map(Event::RunAway),
        (0.0f32..2.0).prop_map(Event::Leak),
        any_says(-70.0..70.0).prop_map(Event::Voltage),
        any_says(-12.0..12.0).prop_map(Event::Current),
        any_says(20.0..130.0).prop_map(Event::Temperature),
    ]
}

fn any_history() -> impl Strategy<Value = Vec<Event>> {
    prop::collection::vec(any_event(), 0..120)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn contacts_are_live_only_under_every_condition_and_every_fault_is_reported(history in any_history()) {
        let mut witness = Witness::new();
        for event in &history {
            tell(&mut witness, event);
        }
        witness.conclude();
    }
}

fn any_message() -> impl Strategy<Value = Message> {
    let head = (any::<u32>(), any::<u64>()).prop_map(|(id, valid_until)| CommandHead {
        id: CommandId(id),
        valid_until: SiteMillis(valid_until),
    });
    let lease = (any::<u32>(), 0u32..3).prop_map(|(epoch, lease)| LeaseRef {
        epoch: Epoch(epoch),
        lease: LeaseId(lease),
        robot: RobotId(1),
    });
    let grant = (head, lease, any::<u64>(), any::<f32>()).prop_map(|(head, lease, expiry, energy)| {
        let expiry = SiteMillis(expiry);
        Message::Grant(Grant { head, lease, tag: TagId::default(), expiry, energy: EnergyJ::clamped(energy) })
    });
    let sync = (any::<u64>(), any::<u64>()).prop_map(|(asked_at, site_now)| {
        Message::TimeSync(TimeSync { asked_at: Millis(asked_at), site_now: SiteMillis(site_now) })
    });
    let rows = prop::collection::vec((any::<u16>(), any::<u32>(), any::<u32>()), 0..8).prop_map(|rows| {
        let row = |(pile, boot, version)| PileRow {
            pile: PileId(pile),
            boot: BootEpoch(boot),
            version,
            stamp: None,
            availability: Availability::Free,
            remaining: Fraction::MIN,
            planned: DurationMs(0),
        };
        Message::PileTable(PileTable { rows: rows.into_iter().map(row).collect() })
    });
    prop_oneof![grant, sync, rows]
}

proptest! {
    /// Times jump from one end of the clock to the other, parameters and messages are absurd.
    #[test]
    fn no_input_panics(
        power_w: f32,
        [eta, period, tag_timeout] in any::<[u32; 3]>().prop_map(|all| all.map(DurationMs)),
        periods: u16,
        inputs in prop::collection::vec((any::<u64>(), any::<i8>(), prop::option::of(any_message())), 0..50),
    ) {
        let usual = Parameters::new(PileId(1), power_w);
        let mut pile = ChargingPile::new(Parameters { eta, period, periods, tag_timeout, ..usual });
        for (now, rssi_dbm, message) in inputs {
            let header = Header::new(DeviceId::Coordinator, BootEpoch(1), Sequence(0));
            let frame = message.map(|message| Frame { header, message });
            let tag = TagRead { tag: TagId::default(), rssi_dbm };
            let outputs = pile.step(Millis(now), frame.as_ref().map_or(Input::Tag(tag), Input::Frame));
            for outgoing in &outputs.messages {
                if let Message::TimeRequest(TimeRequest { asked_at }) = outgoing.message {
                    let message = Message::TimeSync(TimeSync { asked_at, site_now: SiteMillis(now) });
                    pile.step(Millis(now), Input::Frame(&Frame { header, message }));
                }
            }
        }
    }
}

/// What holds for the witness would hold for a pile that never does anything.
#[test]
fn the_histories_charge_many_robots() {
    let mut runner = TestRunner::deterministic();
    let (mut live, mut completed, mut steps) = (0, 0, 0);
    let mut faults = BTreeSet::new();
    for _ in 0..300 {
        let history = any_history().new_tree(&mut runner).unwrap().current();
        let mut witness = Witness::new();
        history.iter().for_each(|event| tell(&mut witness, event));
        live += usize::from(witness.live_steps > 0);
        completed += witness.completed;
        steps += witness.steps;
        witness.conclude();
        faults.extend(witness.reported());
    }
    assert!(live > 100, "only {live} of 300 histories had live contacts");
    assert!(completed > 25, "only {completed} charges were completed");
    // These are a seventh of the histories above.
    assert!(steps > 1_000_000, "only {steps} steps were taken");
    let met = FaultCode::ALL.into_iter().filter(|&code| code != FaultCode::StoreFailed);
    assert_eq!(faults, met.collect(), "not every fault was met");
}
