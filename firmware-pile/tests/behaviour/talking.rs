//! What a pile says unasked, and to whom it listens.

use firmware_pile::{ChargingPile, Input, Parameters, To};
use protocol::*;

use crate::bench::{Bench, tag};

fn hellos(bench: &Bench) -> usize {
    bench.sent.iter().filter(|message| matches!(message, Message::Hello(_))).count()
}

fn hello(epoch: u32) -> Message {
    Message::Hello(Hello {
        min: version::MIN,
        current: version::CURRENT,
        software: [0, 1, 0],
        epoch: Epoch(epoch),
    })
}

fn frame(sender: DeviceId, message: Message) -> Frame {
    Frame { header: Header::new(sender, BootEpoch(1), Sequence(0)), message }
}

fn row(pile: u16, version: u32) -> PileRow {
    PileRow {
        pile: PileId(pile),
        boot: BootEpoch(1),
        version,
        stamp: None,
        availability: Availability::Charging,
        remaining: Fraction::MAX,
        planned: DurationMs(1_000),
    }
}

fn table(rows: &[PileRow]) -> Message {
    Message::PileTable(PileTable { rows: rows.iter().copied().collect() })
}

#[test]
fn hello_is_repeated_until_the_coordinator_answers() {
    let mut bench = Bench::new();
    bench.wait(2_900);
    assert_eq!(hellos(&bench), 3);
    bench.hear(hello(4));
    bench.wait(10_000);
    assert_eq!(hellos(&bench), 3);
    assert_eq!(bench.pile.leases().highest_epoch(), Epoch(4));
}

#[test]
fn a_coordinator_that_speaks_first_hears_hello_too() {
    let mut pile = ChargingPile::new(Parameters::new(PileId(1), 100.0));
    let outputs = pile.step(Millis(0), Input::Frame(&frame(DeviceId::Coordinator, hello(1))));
    assert!(outputs.messages.iter().any(|sent| matches!(sent.message, Message::Hello(_))));
}

#[test]
fn a_coordinator_that_starts_again_is_answered_but_not_forever() {
    let mut bench = Bench::new();
    bench.hear(hello(1));
    bench.wait(5_000);
    let before = hellos(&bench);
    // Each Hello of the pile provokes another of a coordinator that answers every one.
    for _ in 0..10 {
        bench.hear(hello(2));
    }
    assert_eq!(hellos(&bench), before + 1);
}

#[test]
fn the_state_is_told_at_every_change_and_every_second() {
    let mut bench = Bench::new();
    let states =
        |bench: &Bench| bench.sent.iter().filter(|sent| matches!(sent, Message::PileState(_))).count();
    let before = states(&bench);
    bench.wait(10_000);
    assert_eq!(states(&bench), before + 10);
    let grant = bench.grant(1, 1, 3, 1_000.0);
    let answer = bench.hear(Message::Grant(grant)).messages;
    assert!(answer.iter().any(|sent| matches!(
        &sent.message,
        Message::PileState(state) if state.holder == Some(grant.lease) && state.row.availability == Availability::Reserved
    )));
}

#[test]
fn versions_and_stamps_only_grow() {
    let mut bench = Bench::new();
    let grant = bench.grant(1, 1, 3, 5_000.0);
    bench.send(grant);
    bench.standing = Some((tag(3), -45));
    bench.wait(60_000);
    let rows: Vec<PileRow> = bench
        .sent
        .iter()
        .filter_map(|message| match message {
            Message::PileState(state) => Some(state.row),
            _ => None,
        })
        .collect();
    assert!(rows.len() > 80, "about every hundredth of a charge is told, not {}", rows.len());
    assert!(rows.is_sorted_by(|a, b| a.version < b.version && a.stamp <= b.stamp));
}

#[test]
fn other_piles_rows_are_passed_on_and_its_own_is_not_taken_from_others() {
    let mut bench = Bench::new();
    let gossip = table(&[row(2, 5), row(1, 9_999)]);
    bench.step(Input::Frame(&frame(DeviceId::Pile(PileId(2)), gossip)));
    assert_eq!(bench.pile.table().rows(), [row(2, 5)]);
    bench.step(Input::Frame(&frame(DeviceId::Pile(PileId(3)), table(&[row(2, 4)]))));
    assert_eq!(bench.pile.table().rows(), [row(2, 5)]);
    bench.gossip.clear();
    bench.wait(5_000);
    let Some(Message::PileTable(told)) = bench.gossip.last() else { panic!("no gossip in five seconds") };
    assert!(told.rows.contains(&row(2, 5)));
    assert!(told.rows.iter().any(|row| row.pile == PileId(1) && row.availability == Availability::Free));
}

#[test]
fn nobody_but_the_coordinator_commands() {
    let mut bench = Bench::new();
    for sender in [DeviceId::Pile(PileId(2)), DeviceId::Robot(RobotId(3))] {
        let grant = bench.grant(1, 1, 3, 1_000.0);
        let outputs = bench.step(Input::Frame(&frame(sender, Message::Grant(grant))));
        assert!(outputs.messages.is_empty());
        assert!(bench.pile.leases().current().is_none());
    }
}

#[test]
fn a_tool_is_answered_whatever_it_knows_of_the_pile_but_not_faster_than_it_may_ask() {
    let sender = DeviceId::Service;
    let greeting = frame(sender, hello(0));
    for asks in [
        Input::Frame(&greeting),
        Input::Discarded(FrameError::Unsealed { sender }),
        Input::Discarded(FrameError::Unauthentic { sender }),
    ] {
        let mut pile = ChargingPile::new(Parameters::new(PileId(1), 100.0));
        let answered = (0..40).filter(|tick| {
            let outputs = pile.step(Millis(tick * 50), asks);
            outputs.messages.iter().any(|sent| sent.to == To::Service)
        });
        assert_eq!(answered.collect::<Vec<_>>(), [0, 20], "{asks:?}");
    }
}
