use proptest::prelude::*;
use protocol::{
    Availability, BootEpoch, Fraction, Header, NackReason, PendingPasses, PileFaults, PileState, Sequence,
};

use super::*;

const PILE: PileId = PileId(3);

fn frame_of(sender: DeviceId, message: Message) -> Input {
    Input::Frame(Frame { header: Header::new(sender, BootEpoch(1), Sequence(0)), message })
}

fn frame(message: Message) -> Input {
    frame_of(DeviceId::Pile(PILE), message)
}

fn hello() -> Input {
    frame(Message::Hello(Hello::new(Epoch(0))))
}

fn session(goal: Goal) -> Session {
    Session::new(goal, CommandId(9), vec![PileId(1), PILE])
}

/// A session whose pile has said Hello at 0 and is asked.
fn asking(goal: Goal) -> Session {
    let mut session = session(goal);
    let outputs = session.step(Millis(0), hello()).unwrap();
    assert_eq!(outputs.send.len(), 1);
    session
}

fn no_faults() -> Message {
    Message::PileFaults(PileFaults { faults: heapless::Vec::new() })
}

/// What ends the session in ten seconds of silence after `input`.
fn end(mut session: Session, input: Input) -> DeskError {
    let mut end = session.step(Millis(10), input).err();
    for ms in (20..10_000).step_by(10) {
        end = end.or_else(|| session.step(Millis(ms), Input::Tick).err());
    }
    end.expect("it never gave up")
}

#[test]
fn all_piles_with_keys_are_called_until_one_is_heard_and_then_that_one_is() {
    let mut session = session(Goal::Faults);
    for ms in [0, 500, 1_000] {
        let said = session.step(Millis(ms), Input::Tick).unwrap().send;
        assert_eq!(said.iter().map(|(pile, _)| *pile).collect::<Vec<_>>(), [PileId(1), PILE]);
        assert!(said.iter().all(|(_, message)| matches!(message, Message::Hello(_))));
        assert!(session.step(Millis(ms + 1), Input::Tick).unwrap().send.is_empty());
    }
    // Whom that was meant for cannot be read, but who has said it.
    let unauthentic = FrameError::Unauthentic { sender: DeviceId::Pile(PILE) };
    let said = session.step(Millis(1_010), Input::Discarded(unauthentic)).unwrap().send;
    assert!(matches!(said[..], [(PILE, Message::Hello(_))]));
    let said = session.step(Millis(1_020), hello()).unwrap().send;
    assert_eq!(said, [(PILE, Message::Query(Query { topic: Topic::Faults }))]);
}

#[test]
fn a_question_is_repeated_with_a_hello_until_it_is_answered() {
    let mut session = asking(Goal::Faults);
    let query = Message::Query(Query { topic: Topic::Faults });
    for ms in [500, 1_000, 1_500] {
        let said = session.step(Millis(ms), Input::Tick).unwrap().send;
        assert!(
            matches!(&said[..], [(PILE, asked), (PILE, Message::Hello(_))] if *asked == query),
            "{said:?}"
        );
    }
    let answered = session.step(Millis(1_600), frame(no_faults())).unwrap().answered.unwrap();
    assert_eq!((answered.pile, answered.faults), (Some(PILE), Some(Vec::new())));
    assert!(session.is_done());
}

#[test]
fn all_of_a_status_is_asked_and_a_state_needs_its_readings() {
    let mut session = session(Goal::Status);
    let mut asked = Vec::new();
    let mut step = |session: &mut Session, input| {
        let outputs = session.step(Millis(0), input).unwrap();
        asked.extend(outputs.send.iter().filter_map(|(_, message)| match message {
            Message::Query(query) => Some(query.topic),
            _ => None,
        }));
        outputs.answered
    };
    step(&mut session, hello());
    assert!(step(&mut session, frame(Message::PileState(state()))).is_none());
    assert!(step(&mut session, frame(no_faults())).is_none(), "that was not asked yet");
    assert!(step(&mut session, frame(Message::PileReadings(readings()))).is_none());
    assert!(step(&mut session, frame(no_faults())).is_none());
    let answered = step(&mut session, frame(Message::PileParameters(parameters()))).unwrap();
    assert_eq!(answered.state, Some(state()));
    assert_eq!((answered.readings, answered.parameters), (Some(readings()), Some(parameters())));
    assert_eq!(asked, [Topic::State, Topic::Faults, Topic::Parameters]);
}

#[test]
fn a_pile_that_is_watched_is_asked_again_and_again_until_interrupted() {
    let mut session = asking(Goal::Watch);
    for round in 1..10 {
        let at = |ms: u64| Millis(round * 1_000 + ms);
        session.step(at(0), frame(Message::PileState(state()))).unwrap();
        session.step(at(1), frame(Message::PileReadings(readings()))).unwrap();
        let answered = session.step(at(2), frame(no_faults())).unwrap().answered.unwrap();
        assert!(answered.state.is_some() && answered.readings.is_some() && answered.faults.is_some());
        assert!(session.step(at(500), Input::Tick).unwrap().send.is_empty());
        assert!(!session.step(at(502), Input::Tick).unwrap().send.is_empty());
    }
    session.step(Millis(10_000), Input::Interrupt).unwrap();
    assert!(session.is_done());
}

#[test]
fn a_cleared_fault_is_told_with_what_is_wrong_then() {
    let mut session = asking(Goal::Clear(FaultCode::OverCurrent));
    let of = |number| Reference::Command(CommandId(number));
    // The answer to another's command.
    session.step(Millis(1), frame(Message::Ack(Ack { of: of(8) }))).unwrap();
    let said = session.step(Millis(2), frame(Message::Ack(Ack { of: of(9) }))).unwrap().send;
    assert_eq!(said, [(PILE, Message::Query(Query { topic: Topic::Faults }))]);
    let answered = session.step(Millis(3), frame(no_faults())).unwrap().answered.unwrap();
    assert_eq!(answered.cleared, Some(FaultCode::OverCurrent));
}

#[test]
fn a_refusal_ends_the_session_with_its_reason() {
    let of = Reference::Command(CommandId(9));
    let nack = Message::Nack(Nack { of, reason: NackReason::NotCleared });
    let error = end(asking(Goal::Clear(FaultCode::ContactorWelded)), frame(nack));
    assert!(matches!(error, DeskError::Refused { pile: PILE, .. }), "{error:?}");
    let text = error.to_string();
    assert!(text.contains("contactor_welded") && text.contains("cut the mains first"), "{text}");
}

#[test]
fn who_cannot_be_asked_is_named() {
    let pile = DeviceId::Pile(PILE);
    let chassis = DeviceId::Chassis(protocol::RobotId(2));
    let other = |sender| frame_of(sender, Message::Hello(Hello::new(Epoch(0))));
    let discarded = Input::Discarded;
    let cases = [
        (Input::Tick, DeskError::Silent),
        (discarded(FrameError::Crc), DeskError::Unreadable { error: FrameError::Crc }),
        (other(DeviceId::Factory), DeskError::Factory),
        (other(chassis), DeskError::WrongDevice { sender: chassis }),
        (other(DeviceId::Service), DeskError::Silent),
        (discarded(FrameError::Unsealed { sender: pile }), DeskError::Insecure { pile: PILE }),
        (discarded(FrameError::Sealed { sender: pile }), DeskError::Sealed { pile: PILE }),
        (discarded(FrameError::Stranger { sender: pile }), DeskError::NoKey { pile: PILE }),
        (discarded(FrameError::Unauthentic { sender: pile }), DeskError::NotAuthentic { pile: PILE }),
        (frame(no_faults()), DeskError::Unanswered { pile: PILE }),
        (hello(), DeskError::Unanswered { pile: PILE }),
    ];
    for (input, expected) in cases {
        assert_eq!(end(session(Goal::Faults), input), expected);
    }
}

#[test]
fn a_pile_of_another_protocol_is_told_as_such() {
    let hello = Hello { min: 8, current: 9, ..Hello::new(Epoch(0)) };
    let error = end(session(Goal::Status), frame(Message::Hello(hello)));
    assert!(matches!(error, DeskError::Version(_)), "{error:?}");
}

#[test]
fn an_answer_that_was_not_asked_for_is_none() {
    let mut session = asking(Goal::Faults);
    let pending = Message::PendingPasses(PendingPasses { passes: heapless::Vec::new() });
    assert!(session.step(Millis(1), frame(pending)).unwrap().answered.is_none());
    assert!(!session.is_done());
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

fn state() -> PileState {
    PileState {
        row: row(PILE.0),
        elapsed: DurationMs(0),
        holder: None,
        energised: false,
        ended: None,
        standing: None,
        current: None,
    }
}

fn readings() -> protocol::PileReadings {
    protocol::PileReadings {
        voltage: None,
        current: None,
        temperature: None,
        current_limit: protocol::CurrentA::default(),
        contactor_closed: false,
        mated: false,
        emergency_stop: false,
        mains: true,
    }
}

fn parameters() -> protocol::PileParameters {
    protocol::PileParameters {
        power: protocol::PowerW::MIN,
        eta: DurationMs(0),
        voltage_max: protocol::VoltageV::MAX,
        current_max: protocol::CurrentA::MAX,
        derate_from: protocol::TemperatureC::MIN,
        stop_at: protocol::TemperatureC::MAX,
        dock_enter_dbm: -60,
        dock_leave_dbm: -66,
    }
}

proptest! {
    /// The parts of an answer, gossip between them as it may come, an answer that was cut short before.
    #[test]
    fn a_table_is_put_together_whatever_gossip_comes_between(
        others in 0_u16..64, cut in 0_usize..9, gossip in prop::collection::vec(0_u16..8, 10),
    ) {
        let all: Vec<PileRow> =
            [row(PILE.0)].into_iter().chain((100..100 + others).map(row)).collect();
        let mut parts: Vec<Vec<PileRow>> = all.chunks(limits::ROWS_PER_TABLE).map(<[_]>::to_vec).collect();
        if all.len().is_multiple_of(limits::ROWS_PER_TABLE) {
            parts.push(Vec::new());
        }
        // Not the whole of it.
        let lost: Vec<_> = parts.iter().take(cut.min(parts.len() - 1)).cloned().collect();
        let mut rows = Rows::default();
        let mut found = Vec::new();
        for (index, part) in lost.iter().chain(&parts).enumerate() {
            // Gossip tells of others, if there are others.
            let told = gossip[index % gossip.len()].clamp(others.min(1), others.min(7));
            let told: Vec<_> = (100..100 + told).map(row).chain([row(PILE.0)]).collect();
            if others > 0 {
                prop_assert_eq!(rows.take(PILE, &told), None);
            }
            found.extend(rows.take(PILE, part));
        }
        prop_assert_eq!(found, [all]);
    }
}
