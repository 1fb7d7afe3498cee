//! Latched faults: they outlive their cause and a restart, and are cleared by command.

use firmware_pile::{Input, Outputs, Parameters, faults::FaultSet, store::Record};
use protocol::*;

use crate::bench::Bench;

const WELDED: FaultCode = FaultCode::ContactorWelded;

fn clear(bench: &mut Bench, sender: DeviceId, command: u32, code: FaultCode) -> Outputs {
    let header = Header::new(sender, BootEpoch(1), Sequence(0));
    let message = Message::ClearFault(ClearFault { command: CommandId(command), code });
    bench.step(Input::Frame(&Frame { header, message }))
}

fn cleared(command: u32) -> Message {
    Message::Ack(Ack { of: Reference::Command(CommandId(command)) })
}

fn not_cleared(command: u32) -> Message {
    Message::Nack(Nack { of: Reference::Command(CommandId(command)), reason: NackReason::NotCleared })
}

fn answer(outputs: &Outputs) -> &Message {
    &outputs.messages.first().expect("an answer").message
}

/// A pile whose contactor was welded a while ago and is not any more.
fn was_welded() -> Bench {
    let mut bench = Bench::new();
    bench.plant.welded = true;
    bench.wait(400);
    bench.plant.welded = false;
    bench.wait(2_000);
    assert_eq!(bench.pile.availability(), Availability::Fault);
    bench
}

#[test]
fn a_fault_is_stored_before_it_is_told() {
    let mut bench = Bench::new();
    bench.plant.welded = true;
    let step =
        std::iter::from_fn(|| Some(bench.sample())).take(100).find(|outputs| !outputs.store.is_empty());
    let latched = FaultSet::of(&[WELDED]);
    assert_eq!(step.expect("it is stored").store.as_slice(), [Record::Latched(latched)]);
    let told = |bench: &Bench| bench.sent.iter().filter(|sent| matches!(sent, Message::Fault(_))).count();
    assert_eq!(told(&bench), 1);
}

#[test]
fn a_latched_fault_survives_a_restart_and_is_told_again() {
    let latched = FaultSet::of(&[WELDED]);
    let mut bench =
        Bench::with(Parameters { latched, boot: BootEpoch(2), ..Parameters::new(PileId(1), 100.0) });
    bench.wait(2_000);
    assert_eq!(bench.pile.availability(), Availability::Fault);
    let told = bench
        .sent
        .iter()
        .any(|sent| matches!(sent, Message::Fault(Fault { code: WELDED, active: true, .. })));
    assert!(told);
    let grant = bench.grant(1, 1, 3, 1_000.0);
    assert_eq!(bench.send(grant), crate::bench::nack(&grant, NackReason::Faulted));
}

#[test]
fn coordinator_and_tool_clear_a_fault_whose_cause_is_gone() {
    for sender in [DeviceId::Coordinator, DeviceId::Service] {
        let mut bench = was_welded();
        let outputs = clear(&mut bench, sender, 1, WELDED);
        assert_eq!(answer(&outputs), &cleared(1));
        assert_eq!(outputs.store.as_slice(), [Record::Latched(FaultSet::EMPTY)]);
        assert_eq!(bench.serviced.len(), usize::from(sender == DeviceId::Service));
        bench.wait(2_000);
        assert_eq!(bench.pile.availability(), Availability::Free);
        let last = bench.sent.iter().rev().find(|sent| matches!(sent, Message::Fault(_)));
        assert!(matches!(last, Some(Message::Fault(Fault { code: WELDED, active: false, .. }))), "{last:?}");
    }
}

#[test]
fn nobody_else_clears_a_fault() {
    let mut bench = was_welded();
    for sender in [
        DeviceId::Robot(RobotId(1)),
        DeviceId::Pile(PileId(2)),
        DeviceId::Chassis(RobotId(1)),
        DeviceId::Factory,
    ] {
        let outputs = clear(&mut bench, sender, 1, WELDED);
        assert!(outputs.messages.iter().all(|sent| sent.message != cleared(1)));
    }
    assert_eq!(bench.pile.availability(), Availability::Fault);
}

#[test]
fn a_fault_whose_cause_is_there_is_not_cleared() {
    let mut bench = Bench::new();
    bench.plant.welded = true;
    bench.wait(400);
    assert_eq!(answer(&clear(&mut bench, DeviceId::Service, 1, WELDED)), &not_cleared(1));
    assert_eq!(bench.pile.availability(), Availability::Fault);
    bench.plant.welded = false;
    bench.wait(1_100);
    assert_eq!(answer(&clear(&mut bench, DeviceId::Service, 1, WELDED)), &not_cleared(1), "a repeat");
    assert_eq!(answer(&clear(&mut bench, DeviceId::Service, 2, WELDED)), &cleared(2));
}

#[test]
fn a_repeat_clears_no_fault_that_came_later() {
    let mut bench = was_welded();
    assert_eq!(answer(&clear(&mut bench, DeviceId::Service, 1, WELDED)), &cleared(1));
    bench.plant.welded = true;
    bench.wait(400);
    bench.plant.welded = false;
    bench.wait(2_000);
    assert_eq!(answer(&clear(&mut bench, DeviceId::Service, 1, WELDED)), &cleared(1));
    assert_eq!(bench.pile.availability(), Availability::Fault);
}

#[test]
fn lost_mains_are_told_in_one_last_frame_ahead_of_all_others() {
    let mut bench = Bench::new();
    bench.sent.clear();
    bench.plant.mains = false;
    let outputs = bench.sample();
    assert!(outputs.urgent);
    let state = FaultState { code: FaultCode::MainsLost, active: true, latched: false };
    let faults = PileFaults { faults: [state].into_iter().collect() };
    assert_eq!(bench.sent, [Message::PileFaults(faults)]);
    bench.wait(5_000);
    let grant = bench.grant(1, 1, 3, 1_000.0);
    bench.hear(Message::Grant(grant));
    assert_eq!(bench.sent.len(), 1, "{:?}", bench.sent);

    bench.plant.mains = true;
    bench.wait(5_000);
    assert_eq!(bench.pile.availability(), Availability::Free);
    let reported = bench.sent.iter().filter_map(|sent| match sent {
        Message::Fault(fault) => Some((fault.code, fault.active)),
        _ => None,
    });
    let lost = FaultCode::MainsLost;
    assert_eq!(reported.collect::<Vec<_>>(), [(lost, true), (lost, false)]);
}
