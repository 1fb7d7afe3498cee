//! Robots that ask a pile for itself while no coordinator is heard.

use firmware_pile::{Input, Parameters, store::Record};
use protocol::*;

use crate::bench::{Bench, tag};

const ROBOT: RobotId = RobotId(3);

impl Bench {
    /// A pile that may serve claims and has not heard the coordinator for this long.
    fn alone_for(ms: u64) -> Self {
        let mut bench = Self::new();
        bench.hear(Message::ClaimRule(ClaimRule { allowed: true }));
        bench.coordinator = false;
        bench.wait(ms);
        bench
    }

    fn claim(&mut self, robot: RobotId) -> ClaimPile {
        let row = self.pile.row();
        ClaimPile {
            request: RequestId(9),
            pile: row.pile,
            boot: row.boot,
            version: row.version,
            tag: tag(robot.0),
            energy: EnergyJ::new(1_000.0).unwrap(),
            within: DurationMs(120_000),
        }
    }

    /// The pile's answer to a claim: none if it does not answer.
    fn claimed(&mut self, robot: RobotId, claim: ClaimPile) -> Option<Result<(), NackReason>> {
        let header = Header::new(DeviceId::Robot(robot), BootEpoch(1), Sequence(0));
        let outputs = self.step(Input::Frame(&Frame { header, message: Message::ClaimPile(claim) }));
        let expected = Reference::Claim(ClaimRef { robot, request: claim.request });
        outputs.messages.iter().find_map(|sent| match sent.message {
            Message::Ack(Ack { of }) if of == expected => Some(Ok(())),
            Message::Nack(Nack { of, reason }) if of == expected => Some(Err(reason)),
            _ => None,
        })
    }

    fn claims(&mut self, robot: RobotId) -> Option<Result<(), NackReason>> {
        let claim = self.claim(robot);
        self.claimed(robot, claim)
    }
}

#[test]
fn a_pile_that_hears_no_coordinator_gives_itself_to_one_robot_and_charges_it() {
    let mut bench = Bench::alone_for(31_000);
    assert_eq!(bench.claims(ROBOT), Some(Ok(())));
    let lease = bench.pile.leases().current().unwrap().name;
    assert!(lease.lease.is_local() && lease.robot == ROBOT);
    assert_eq!(bench.claims(ROBOT), Some(Ok(())), "a repeat is acknowledged again");
    assert_eq!(bench.pile.leases().current().unwrap().name, lease);
    assert_eq!(bench.claims(RobotId(4)), Some(Err(NackReason::Held { by: lease })));
    bench.standing = Some((tag(3), -45));
    bench.wait(2_000);
    assert!(bench.live());
    bench.wait(12_000);
    let ended = bench.pile.leases().ended().unwrap();
    assert_eq!((ended.lease, ended.reason), (lease, EndReason::Completed));
    assert_eq!(bench.claims(ROBOT), Some(Err(NackReason::Ended)), "a late repeat charges nobody again");
    let next = ClaimPile { request: RequestId(10), ..bench.claim(ROBOT) };
    assert_eq!(bench.claimed(ROBOT, next), Some(Ok(())));
}

#[test]
fn a_pile_that_hears_the_coordinator_or_may_not_is_not_claimed() {
    assert_eq!(Bench::alone_for(29_000).claims(ROBOT), Some(Err(NackReason::NotClaimable)));
    let mut heard = Bench::alone_for(31_000);
    heard.hear(Message::Hello(Hello::new(Epoch(0))));
    assert_eq!(heard.claims(ROBOT), Some(Err(NackReason::NotClaimable)));
    let mut forbidden = Bench::alone_for(0);
    forbidden.hear(Message::ClaimRule(ClaimRule { allowed: false }));
    forbidden.wait(31_000);
    assert_eq!(forbidden.claims(ROBOT), Some(Err(NackReason::NotClaimable)));
    let mut restarted = Bench::new();
    restarted.coordinator = false;
    restarted.wait(31_000);
    assert_eq!(restarted.claims(ROBOT), Some(Err(NackReason::NotClaimable)), "nobody has told it");
}

#[test]
fn a_recorded_claim_and_one_for_another_pile_are_not_believed() {
    let mut bench = Bench::alone_for(31_000);
    let old = bench.claim(ROBOT);
    bench.wait(62_000);
    assert_eq!(bench.claimed(ROBOT, old), Some(Err(NackReason::TooLate)));
    let fresh = bench.claim(ROBOT);
    let earlier_start = ClaimPile { boot: BootEpoch(0), ..fresh };
    assert_eq!(bench.claimed(ROBOT, earlier_start), Some(Err(NackReason::TooLate)));
    assert_eq!(bench.claimed(ROBOT, ClaimPile { pile: PileId(77), ..fresh }), None);
    assert_eq!(bench.claimed(ROBOT, fresh), Some(Ok(())));
}

#[test]
fn a_robot_that_does_not_come_in_time_or_finds_another_there_has_no_lease() {
    let mut bench = Bench::alone_for(31_000);
    assert_eq!(bench.claims(ROBOT), Some(Ok(())));
    bench.wait(121_000);
    assert_eq!(bench.pile.leases().ended().unwrap().reason, EndReason::Expired);
    bench.standing = Some((tag(8), -45));
    bench.wait(200);
    let again = ClaimPile { request: RequestId(10), ..bench.claim(ROBOT) };
    assert_eq!(bench.claimed(ROBOT, again), Some(Err(NackReason::Occupied)));
    let endless = ClaimPile { within: DurationMs::MAX, tag: tag(8), ..bench.claim(RobotId(8)) };
    assert_eq!(bench.claimed(RobotId(8), endless), Some(Ok(())));
    let expiry = bench.pile.leases().current().unwrap().expiry;
    assert_eq!(expiry, bench.site_now().after(limits::LONGEST_CLAIM));
}

#[test]
fn no_two_leases_that_a_pile_makes_for_itself_have_one_number_over_restarts() {
    let mut bench = Bench::alone_for(31_000);
    let claim = bench.claim(ROBOT);
    let header = Header::new(DeviceId::Robot(ROBOT), BootEpoch(1), Sequence(0));
    let outputs = bench.step(Input::Frame(&Frame { header, message: Message::ClaimPile(claim) }));
    let Some(Record::Counters(counters)) =
        outputs.store.iter().find(|record| matches!(record, Record::Counters(_)))
    else {
        panic!("its number is not stored before the answer goes out: {:?}", outputs.store)
    };
    let first = bench.pile.leases().current().unwrap().name.lease;
    let mut again = Bench::with(Parameters {
        counters: *counters,
        boot: BootEpoch(2),
        ..Parameters::new(PileId(1), 100.0)
    });
    again.hear(Message::ClaimRule(ClaimRule { allowed: true }));
    again.coordinator = false;
    again.wait(31_000);
    assert_eq!(again.claims(ROBOT), Some(Ok(())));
    assert_ne!(again.pile.leases().current().unwrap().name.lease, first);
}

#[test]
fn a_coordinator_that_is_back_extends_or_revokes_what_the_pile_gave_itself_and_gives_it_to_nobody_else() {
    let mut bench = Bench::alone_for(31_000);
    assert_eq!(bench.claims(ROBOT), Some(Ok(())));
    bench.coordinator = true;
    let lease = bench.pile.leases().current().unwrap().name;
    let answer_to = |bench: &mut Bench, grant: Grant| {
        let sent = bench.hear(Message::Grant(grant)).messages;
        let of = Reference::Command(grant.head.id);
        sent.iter().find_map(|sent| match sent.message {
            Message::Ack(ack) if ack.of == of => Some(Ok(())),
            Message::Nack(nack) if nack.of == of => Some(Err(nack.reason)),
            _ => None,
        })
    };
    let other = bench.grant(5, 17, 4, 1_000.0);
    assert_eq!(answer_to(&mut bench, other), Some(Err(NackReason::Held { by: lease })));
    let name = LeaseRef { epoch: Epoch(5), ..lease };
    let extended = Grant { lease: name, ..bench.grant(5, 0, 3, 1_000.0) };
    assert_eq!(answer_to(&mut bench, extended), Some(Ok(())));
    assert_eq!(bench.pile.leases().current().unwrap().name, name);
    let head = bench.head();
    bench.hear(Message::Revoke(Revoke { head, lease: name }));
    assert_eq!(bench.pile.leases().current().map(|lease| lease.name), None);
}
