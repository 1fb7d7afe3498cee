//! Which commands the pile obeys.

use firmware_pile::{ChargingPile, Input, Parameters, store::Record};
use protocol::*;

use crate::bench::{Bench, ack, nack, tag};

fn revoke(bench: &mut Bench, lease: LeaseRef) -> Message {
    let head = bench.head();
    bench.hear(Message::Revoke(Revoke { head, lease })).messages[0].message.clone()
}

#[test]
fn a_lower_epoch_is_refused_with_the_highest() {
    let mut bench = Bench::with(Parameters { highest_epoch: Epoch(5), ..Parameters::new(PileId(1), 100.0) });
    let old = bench.grant(4, 1, 3, 1_000.0);
    assert_eq!(bench.send(old), nack(&old, NackReason::StaleEpoch { highest: Epoch(5) }));
}

#[test]
fn a_higher_epoch_is_handed_out_for_storage_once() {
    let mut bench = Bench::new();
    let grant = bench.grant(2, 1, 3, 1_000.0);
    assert_eq!(bench.hear(Message::Grant(grant)).store.as_slice(), [Record::Epoch(Epoch(2))]);
    assert!(bench.step(Input::Tick).store.is_empty());
}

#[test]
fn a_late_grant_is_refused() {
    let mut bench = Bench::new();
    let grant = bench.grant(1, 1, 3, 1_000.0);
    bench.wait(5_100);
    assert_eq!(bench.send(grant), nack(&grant, NackReason::TooLate));

    let mut run_out = bench.grant(1, 2, 3, 1_000.0);
    run_out.expiry = bench.site_now();
    assert_eq!(bench.send(run_out), nack(&run_out, NackReason::TooLate));
}

#[test]
fn without_a_clock_nothing_is_granted() {
    let mut bench = Bench::new();
    bench.pile = ChargingPile::new(Parameters::new(PileId(1), 100.0));
    let grant = bench.grant(1, 1, 3, 1_000.0);
    assert_eq!(bench.pile.leases().current().map(|lease| lease.name), None);
    bench.coordinator = false;
    let answers = bench.hear(Message::Grant(grant)).messages;
    assert!(answers.iter().any(|sent| sent.message == nack(&grant, NackReason::ClockUnknown)));
}

#[test]
fn a_held_pile_names_its_holder() {
    let mut bench = Bench::new();
    let first = bench.grant(1, 1, 3, 1_000.0);
    bench.send(first);
    let second = bench.grant(1, 2, 4, 1_000.0);
    assert_eq!(bench.send(second), nack(&second, NackReason::Held { by: first.lease }));
}

#[test]
fn a_stranger_at_the_contacts_occupies_the_pile() {
    let mut bench = Bench::new();
    bench.standing = Some((tag(9), -45));
    bench.wait(100);
    let grant = bench.grant(1, 1, 3, 1_000.0);
    assert_eq!(bench.send(grant), nack(&grant, NackReason::Occupied));
    assert_eq!(bench.pile.availability(), Availability::Done, "others see that the pile is no use");
    let told = bench.sent.iter().rev().find_map(|message| match message {
        Message::PileState(state) => Some(*state),
        _ => None,
    });
    assert_eq!(told.unwrap().standing, Some(tag(9)));
    bench.standing = Some((tag(9), -80));
    bench.wait(3_000);
    let again = bench.grant(1, 1, 3, 1_000.0);
    assert_eq!(bench.send(again), ack(&again));
}

#[test]
fn a_repeat_is_answered_again_and_not_done_again() {
    let mut bench = Bench::new();
    let grant = bench.grant(1, 1, 3, 1_000.0);
    assert_eq!(bench.send(grant), ack(&grant));
    assert_eq!(revoke(&mut bench, grant.lease), Message::Ack(Ack { of: Reference::Command(CommandId(2)) }));
    assert_eq!(bench.send(grant), ack(&grant));
    assert!(bench.pile.leases().current().is_none());
}

/// Two coordinators on two copies of one log share an epoch and count their commands alike.
#[test]
fn a_command_of_another_coordinator_with_the_same_number_is_no_repeat() {
    let mut bench = Bench::new();
    let first = bench.grant(1, 1, 3, 1_000.0);
    assert_eq!(bench.send(first), ack(&first));
    for (lease, robot) in [(2, 4), (1, 4)] {
        let other = Grant { head: first.head, ..bench.grant(1, lease, robot, 1_000.0) };
        assert_eq!(bench.send(other), nack(&other, NackReason::Held { by: first.lease }));
    }
    bench.wait(100);
    let head = CommandHead { id: first.head.id, ..bench.head() };
    let revoked = bench.hear(Message::Revoke(Revoke { head, lease: first.lease }));
    let answer = Message::Ack(Ack { of: Reference::Command(head.id) });
    assert!(revoked.messages.iter().any(|sent| sent.message == answer));
    assert!(bench.pile.leases().current().is_none(), "it was answered as if it were the grant");
}

#[test]
fn an_ended_lease_is_never_granted_again() {
    let mut bench = Bench::new();
    let grant = bench.grant(1, 1, 3, 1_000.0);
    bench.send(grant);
    revoke(&mut bench, grant.lease);
    let again = Grant { head: bench.head(), ..grant };
    assert_eq!(bench.send(again), nack(&again, NackReason::Ended));
}

#[test]
fn a_revocation_that_overtakes_its_grant_wins() {
    let mut bench = Bench::new();
    let grant = bench.grant(1, 1, 3, 1_000.0);
    revoke(&mut bench, grant.lease);
    assert_eq!(bench.send(grant), nack(&grant, NackReason::Ended));
}

#[test]
fn an_extension_under_a_new_epoch_moves_only_expiry_and_epoch() {
    let mut bench = Bench::new();
    let grant = bench.grant(1, 1, 3, 1_000.0);
    bench.send(grant);
    bench.standing = Some((tag(3), -45));
    bench.wait(4_000);
    let planned = bench.pile.row().planned;
    let extension = bench.grant(2, 1, 3, 500_000.0);
    assert_eq!(bench.send(extension), ack(&extension));
    let lease = bench.pile.leases().current().unwrap();
    assert_eq!((lease.name, lease.expiry), (extension.lease, extension.expiry));
    assert_eq!(bench.pile.row().planned, planned);
}

#[test]
fn a_lease_cannot_be_extended_for_another_robot_or_tag() {
    let mut bench = Bench::new();
    let grant = bench.grant(1, 1, 3, 1_000.0);
    bench.send(grant);
    let held = NackReason::Held { by: grant.lease };
    let other_tag = Grant { head: bench.head(), tag: tag(4), ..grant };
    assert_eq!(bench.send(other_tag), nack(&other_tag, held));
    let lease = LeaseRef { robot: RobotId(4), ..grant.lease };
    let other_robot = Grant { head: bench.head(), lease, ..grant };
    assert_eq!(bench.send(other_robot), nack(&other_robot, held));
}
