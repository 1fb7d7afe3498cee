//! What a pile does when something in it breaks.

use firmware_pile::{Input, TagRead, store::Record};
use protocol::*;

use crate::bench::{Bench, Reader, ack, nack, tag};

fn faults(bench: &Bench) -> Vec<(FaultCode, bool)> {
    let faults = bench.sent.iter().filter_map(|message| match message {
        Message::Fault(fault) => Some((fault.code, fault.active)),
        _ => None,
    });
    faults.collect()
}

fn charging() -> Bench {
    let mut bench = Bench::new();
    let grant = bench.grant(1, 7, 3, 10_000.0);
    bench.send(grant);
    bench.standing = Some((tag(3), -45));
    bench.wait(1_000);
    assert!(bench.live());
    bench
}

fn reason(bench: &Bench) -> Option<EndReason> {
    bench.pile.leases().ended().map(|ended| ended.reason)
}

#[test]
fn a_reader_that_falls_silent_opens_the_contacts_and_then_is_a_fault() {
    let mut bench = charging();
    bench.reader = Reader::Silent;
    bench.wait(2_200);
    assert!(!bench.live(), "nobody knows whether the robot is still here");
    assert_eq!(reason(&bench), None, "nobody knows that it has left");
    bench.wait(3_000);
    assert_eq!(reason(&bench), Some(EndReason::Fault));
    assert_eq!(bench.pile.availability(), Availability::Fault);
    assert_eq!(faults(&bench), [(FaultCode::ReaderSilent, true)]);

    let grant = bench.grant(1, 8, 4, 1_000.0);
    assert_eq!(bench.send(grant), nack(&grant, NackReason::Faulted));
    bench.reader = Reader::Sees;
    bench.standing = None;
    bench.wait(3_000);
    assert_eq!(bench.pile.availability(), Availability::Free);
    assert_eq!(faults(&bench).last(), Some(&(FaultCode::ReaderSilent, false)));
    let again = bench.grant(1, 9, 4, 1_000.0);
    assert_eq!(bench.send(again), ack(&again));
}

#[test]
fn a_reader_that_comes_back_in_time_goes_on_with_the_charge() {
    let mut bench = charging();
    bench.reader = Reader::Silent;
    bench.wait(3_000);
    assert!(!bench.live());
    let elapsed = bench.pile.leases().current().unwrap().charge.unwrap().elapsed();
    bench.reader = Reader::Sees;
    bench.wait(100);
    assert_eq!(bench.pile.leases().current().unwrap().charge.unwrap().elapsed(), elapsed);
    bench.wait(1_000);
    assert!(bench.live());
}

#[test]
fn a_contactor_that_does_not_close_is_a_fault_even_when_it_is_open_as_told() {
    let mut bench = Bench::new();
    let grant = bench.grant(1, 7, 3, 10_000.0);
    bench.send(grant);
    bench.plant.jammed = true;
    bench.standing = Some((tag(3), -45));
    bench.wait(300);
    assert!(bench.live());
    bench.wait(200);
    assert!(!bench.live());
    assert_eq!(reason(&bench), Some(EndReason::Fault));
    bench.wait(5_000);
    assert_eq!(bench.pile.availability(), Availability::Fault);
    assert_eq!(faults(&bench), [(FaultCode::ContactorStuckOpen, true)]);
}

#[test]
fn a_welded_contactor_stays_a_fault_when_it_opens_after_all() {
    let mut bench = Bench::new();
    bench.plant.welded = true;
    bench.wait(400);
    assert_eq!(bench.pile.availability(), Availability::Fault);
    bench.plant.welded = false;
    bench.wait(5_000);
    assert_eq!(bench.pile.availability(), Availability::Fault);
    assert_eq!(faults(&bench), [(FaultCode::ContactorWelded, true)]);
    let grant = bench.grant(1, 8, 4, 1_000.0);
    assert_eq!(bench.send(grant), nack(&grant, NackReason::Faulted));
}

#[test]
fn a_fault_is_repeated_until_it_is_acknowledged_and_nothing_overtakes_it() {
    let mut bench = Bench::new();
    bench.coordinator = false;
    bench.plant.welded = true;
    bench.wait(600);
    bench.standing = Some((tag(3), -45));
    bench.wait(5_000);
    let reports = |bench: &Bench| -> Vec<u32> {
        let reports = bench.sent.iter().filter_map(|message| match message {
            Message::Fault(fault) => Some(fault.report.number),
            Message::PassReport(report) => Some(report.report.number),
            _ => None,
        });
        reports.collect()
    };
    let waiting = reports(&bench);
    assert!((5..=6).contains(&waiting.len()) && waiting.iter().all(|&report| report == 1), "{waiting:?}");
    bench.hear(Message::Ack(Ack { of: Reference::Report(ReportId { boot: BootEpoch(1), number: 9 }) }));
    bench.wait(2_000);
    assert_eq!(reports(&bench).last(), Some(&1), "the acknowledgement was for another report");
    bench.hear(Message::Ack(Ack { of: Reference::Report(ReportId { boot: BootEpoch(1), number: 1 }) }));
    bench.wait(1_500);
    assert_eq!(reports(&bench).last(), Some(&2));
    assert_eq!(bench.passes_of(tag(3)), 2, "the one pass, repeated once because nobody acknowledged it");
}

#[test]
fn a_charged_robot_that_a_silent_reader_does_not_see_still_occupies_the_pile() {
    let mut bench = charging();
    let lease = bench.pile.leases().current().unwrap().name;
    let head = bench.head();
    bench.hear(Message::Revoke(Revoke { head, lease }));
    bench.reader = Reader::Silent;
    bench.wait(4_000);
    assert_eq!(bench.pile.availability(), Availability::Done);
    let grant = bench.grant(1, 8, 4, 1_000.0);
    assert_eq!(bench.send(grant), nack(&grant, NackReason::Occupied));
}

/// What a sample, and the robot's tag after it, give to store.
fn sampled(bench: &mut Bench) -> Vec<Record> {
    let sample = bench.sample();
    let read = bench.step(Input::Tag(TagRead { tag: tag(3), rssi_dbm: -45 }));
    sample.store.into_iter().chain(read.store).collect()
}

#[test]
fn a_store_that_fails_ends_the_charge_answers_nothing_and_is_asked_again_for_all_of_it() {
    let mut bench = charging();
    // Another coordinator extends the lease; its epoch must be kept before anybody is answered.
    let grant = bench.grant(2, 7, 3, 10_000.0);
    let kept = Record::Epoch(Epoch(2));
    assert!(bench.hear(Message::Grant(grant)).store.contains(&kept));
    let said = bench.step(Input::StoreFailed).messages;
    assert!(said.iter().all(|outgoing| outgoing.message != ack(&grant)), "{said:?}");
    let failed_at = bench.now;
    while bench.live() {
        bench.sample();
        assert!(bench.now.since(failed_at).0 <= 300, "the contacts are still live");
    }
    assert_eq!(reason(&bench), Some(EndReason::Fault));

    // It goes on failing: asked once a second, told once.
    let mut asked = 0;
    while bench.now.since(failed_at).0 < 5_500 {
        if !sampled(&mut bench).is_empty() {
            bench.step(Input::StoreFailed);
            asked += 1;
        }
    }
    assert_eq!(asked, 5);
    assert_eq!(bench.pile.availability(), Availability::Fault);
    assert_eq!(faults(&bench), [(FaultCode::StoreFailed, true)]);

    // It works again: what it was to keep is asked for once more, and the fault goes.
    let mut stored = Vec::new();
    while bench.now.since(failed_at).0 < 9_000 {
        stored.extend(sampled(&mut bench));
    }
    assert_eq!(stored.iter().filter(|record| **record == kept).count(), 1, "{stored:?}");
    assert_ne!(bench.pile.availability(), Availability::Fault);
    assert_eq!(faults(&bench), [(FaultCode::StoreFailed, true), (FaultCode::StoreFailed, false)]);
}
