//! A person's tool at the line of the board: what `chargehand pile` does there, by the same code.

use std::future;
use std::net::TcpStream;
use std::time::{Duration, Instant};

use host_coordinator::desk::answers::Answers;
use host_coordinator::desk::error::DeskError;
use host_coordinator::desk::run::{RunError, run};
use host_coordinator::desk::session::{Goal, Session};
use protocol::{BootEpoch, CommandId, FaultCode, Trust};
use tests::board_line::{Awaited, TestBench};
use tests::emulator::{Emulator, Serial};
use tests::pile_bench::{PILE, SOON};
use tests::uhf_reader::UhfReader;

fn ask(link: &TcpStream, goal: Goal, command: u32) -> Result<Answers, RunError> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let link = link.try_clone().unwrap();
        link.set_nonblocking(true).unwrap();
        let mut line = tokio::net::TcpStream::from_std(link).unwrap();
        let mut session = Session::new(goal, CommandId(command), vec![PILE]);
        let mut answers = None;
        let mut hear = |heard: &Answers| {
            answers = Some(heard.clone());
            Ok(())
        };
        let interrupt = future::pending();
        run(&mut line, &mut session, || BootEpoch(1), Trust::Insecure, interrupt, &mut hear).await?;
        Ok(answers.expect("a session that is done has its answers"))
    })
}

#[test]
fn a_tool_asks_the_board_and_clears_a_fault_once_its_cause_is_gone() {
    let (link, test) = (Awaited::new().unwrap(), Awaited::new().unwrap());
    let reader = UhfReader::start().unwrap();
    let at_reader = Serial::Dial(reader.address());
    let _board = Emulator::boot_pile(link.serial().unwrap(), at_reader, test.serial().unwrap()).unwrap();
    let mut test = TestBench::new(test.accept().unwrap()).unwrap();
    let link = link.accept().unwrap();

    let deadline = Instant::now() + SOON;
    // Until its sensors were read it says that nothing is measured.
    let document = loop {
        let status = ask(&link, Goal::Status, 1).unwrap();
        let document = serde_json::to_value(status.document()).unwrap();
        if document["readings"]["temperature_c"].is_number() {
            break document;
        }
        assert!(Instant::now() < deadline, "nothing is measured: {document}");
    };
    assert_eq!((&document["pile"], &document["parameters"]["power_w"]), (&PILE.0.into(), &500.0.into()));
    assert_eq!(document["faults"], serde_json::json!([]));
    assert_eq!(ask(&link, Goal::Table, 2).unwrap().table.map(|rows| rows.len()), Some(1));

    let code = FaultCode::ContactorWelded;
    test.order("welded 1").unwrap();
    let deadline = Instant::now() + SOON;
    let is_welded = |answers: &Answers| answers.faults.iter().flatten().any(|fault| fault.code == code);
    while !is_welded(&ask(&link, Goal::Faults, 3).unwrap()) {
        assert!(Instant::now() < deadline, "the fault is not found");
    }
    let refused = ask(&link, Goal::Clear(code), 4);
    assert!(matches!(refused, Err(RunError::Desk(DeskError::Refused { .. }))), "{refused:?}");
    test.order("welded 0").unwrap();
    let cleared = (5..).find_map(|command| {
        assert!(Instant::now() < deadline + Duration::from_secs(20), "the fault is not cleared");
        ask(&link, Goal::Clear(code), command).ok()
    });
    assert_eq!(cleared.unwrap().faults, Some(Vec::new()));
}
