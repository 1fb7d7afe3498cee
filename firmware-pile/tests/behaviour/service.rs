//! What a person's tool at a desk asks and is answered.

use firmware_pile::Input;
use proptest::prelude::*;
use protocol::*;

use crate::bench::Bench;

/// What the tool is told in the second after it has said this.
fn told(bench: &mut Bench, message: Message) -> Vec<Message> {
    bench.serviced.clear();
    let header = Header::new(DeviceId::Service, BootEpoch(1), Sequence(0));
    bench.step(Input::Frame(&Frame { header, message }));
    bench.wait(1_000);
    std::mem::take(&mut bench.serviced)
}

fn asked(bench: &mut Bench, topic: Topic) -> Vec<Message> {
    told(bench, Message::Query(Query { topic }))
}

#[test]
fn each_topic_has_its_answer_and_only_once() {
    let mut bench = Bench::new();
    bench.coordinator = false;
    bench.standing = Some((TagId([7; 12]), -50));
    bench.wait(3_000);
    assert!(bench.serviced.is_empty(), "unasked");

    let answers = asked(&mut bench, Topic::State);
    let [Message::PileState(state), Message::PileReadings(readings)] = &answers[..] else {
        panic!("{answers:?}")
    };
    assert_eq!((state.row.availability, state.energised), (Availability::Done, false));
    assert!(readings.mains && readings.mated && !readings.contactor_closed && !readings.emergency_stop);
    assert!(readings.voltage.is_some_and(|voltage| (20.0..30.0).contains(&voltage.get())), "{readings:?}");
    assert_eq!(readings.current_limit.get(), 0.0);

    assert_eq!(
        asked(&mut bench, Topic::Faults),
        [Message::PileFaults(PileFaults { faults: heapless::Vec::new() })]
    );
    let answers = asked(&mut bench, Topic::Passes);
    let [Message::PendingPasses(pending)] = &answers[..] else { panic!("{answers:?}") };
    assert!(
        pending.passes.iter().any(|count| count.tag == TagId([7; 12]) && count.passes == 1),
        "{pending:?}"
    );
    let answers = asked(&mut bench, Topic::Parameters);
    let [Message::PileParameters(parameters)] = &answers[..] else { panic!("{answers:?}") };
    assert_eq!(parameters.power.get(), 100.0);
    assert_eq!(told(&mut bench, Message::Hello(Hello::new(Epoch(0)))).len(), 1);
}

#[test]
fn a_tool_can_neither_grant_nor_revoke() {
    let mut bench = Bench::new();
    let far = SiteMillis(1_000_000_000);
    let head = CommandHead { id: CommandId(1), valid_until: far };
    let lease = LeaseRef { epoch: Epoch(9), lease: LeaseId(1), robot: RobotId(1) };
    let energy = EnergyJ::new(10.0).unwrap();
    let grant = Grant { head, lease, tag: TagId([7; 12]), expiry: far, energy };
    assert_eq!(told(&mut bench, Message::Grant(grant)), []);
    assert_eq!(bench.pile.availability(), Availability::Free);
    assert_eq!(told(&mut bench, Message::Revoke(Revoke { head, lease })), []);
}

#[test]
fn a_pile_without_mains_still_answers_a_tool() {
    let mut bench = Bench::new();
    bench.plant.mains = false;
    bench.wait(2_000);
    let answers = asked(&mut bench, Topic::Faults);
    let [Message::PileFaults(faults)] = &answers[..] else { panic!("{answers:?}") };
    assert!(faults.faults.iter().any(|fault| fault.code == FaultCode::MainsLost), "{faults:?}");
}

fn row(pile: u16) -> PileRow {
    PileRow {
        pile: PileId(pile),
        boot: BootEpoch(1),
        version: 1,
        stamp: None,
        availability: Availability::Free,
        remaining: Fraction::MIN,
        planned: DurationMs(0),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]
    #[test]
    fn all_of_the_table_is_told_in_parts_of_which_only_the_last_is_not_full(
        others in prop::collection::btree_set(0_u16..100, 0..63),
    ) {
        let mut bench = Bench::new();
        let own = bench.pile.row().pile;
        let others: Vec<_> = others.into_iter().filter(|&pile| PileId(pile) != own).map(row).collect();
        for part in others.chunks(limits::ROWS_PER_TABLE) {
            let table = Message::PileTable(PileTable { rows: part.iter().copied().collect() });
            bench.hear(table);
        }
        let parts: Vec<_> = asked(&mut bench, Topic::Table)
            .into_iter()
            .map(|message| match message {
                Message::PileTable(table) => table.rows,
                other => panic!("{other:?}"),
            })
            .collect();
        let (last, full) = parts.split_last().unwrap();
        prop_assert!(!last.is_full() && full.iter().all(|part| part.is_full()));
        let told: Vec<_> = parts.iter().flatten().copied().collect();
        prop_assert_eq!(told[0].pile, own);
        prop_assert_eq!(&told[1..], &others[..]);
    }
}
