//! A board from the factory becomes a pile, and remembers over every restart who it is and what it has
//! not told.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use protocol::*;
use tests::board_line::{Awaited, TestBench};
use tests::emulator::{Emulator, FLASH};
use tests::pile_bench::{ROBOT, SOON};
use tests::uhf_reader::UhfReader;

const KEY: Key = Key::new([7; 32]);
const PILE: PileId = PileId(40);
const EPOCH: Epoch = Epoch(9);

/// A board, and whoever is at the other end of its link.
struct Desk {
    flash: PathBuf,
    reader: UhfReader,
    board: Emulator,
    test: TestBench,
    link: TcpStream,
    deframer: Deframer,
    sessions: Sessions<[Session; 1]>,
    to: DeviceId,
    starts: u32,
}

impl Desk {
    fn new(flash: PathBuf) -> Self {
        let reader = UhfReader::start().unwrap();
        let (board, link, test) = boot(&flash, &reader, false);
        let sessions = Sessions::new(DeviceId::Service, BootEpoch(1), Trust::Insecure);
        let deframer = Deframer::new();
        Self { flash, reader, board, test, link, deframer, sessions, to: DeviceId::Factory, starts: 0 }
    }

    /// The power goes and comes back.
    fn restart(&mut self, button_held: bool) {
        // The file is the emulator's until it has ended.
        let (board, link, test) = boot(&self.flash, &self.reader, button_held);
        (self.board, self.link, self.test, self.deframer) = (board, link, test, Deframer::new());
    }

    /// From now on this is the coordinator, in another start.
    fn coordinate(&mut self, pile: PileId) {
        self.starts += 1;
        self.to = DeviceId::Pile(pile);
        let trust = Trust::Keys { site: None, peers: [Session::new(self.to, KEY)] };
        self.sessions = Sessions::new(DeviceId::Coordinator, BootEpoch(self.starts), trust);
    }

    fn say(&mut self, message: &Message) {
        let frame = self.sessions.seal(Recipient::Device(self.to), message).unwrap();
        self.link.write_all(&frame).unwrap();
    }

    /// What `pick` finds in what the board says, which is said soon.
    fn expect<T>(&mut self, what: &str, pick: impl Fn(&Frame) -> Option<T>) -> T {
        self.listen(3 * SOON, pick)
            .unwrap_or_else(|| panic!("the board does not say {what}; its log: {:#?}", self.board.log()))
    }

    /// What `pick` finds in what the board says within `time`. A Hello is answered, and a question for
    /// the time.
    fn listen<T>(&mut self, time: Duration, pick: impl Fn(&Frame) -> Option<T>) -> Option<T> {
        let deadline = Instant::now() + time;
        self.link.set_read_timeout(Some(Duration::from_millis(100))).unwrap();
        while Instant::now() < deadline {
            let mut buffer = [0; 1024];
            let length = match self.link.read(&mut buffer) {
                Ok(length) => length,
                Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => 0,
                Err(error) => panic!("the link is gone: {error}; the board's log: {:#?}", self.board.log()),
            };
            let mut frames = Vec::new();
            // What is sealed for somebody else, or cut off by a restart, is not for this desk.
            let sessions = &mut self.sessions;
            self.deframer.feed(&buffer[..length], |found| {
                frames.extend(found.and_then(|packet| sessions.open(packet)));
            });
            for frame in frames {
                match &frame.message {
                    Message::Hello(hello) => self.say(&Message::Hello(Hello { epoch: EPOCH, ..*hello })),
                    Message::TimeRequest(TimeRequest { asked_at }) => {
                        let (asked_at, site_now) = (*asked_at, SiteMillis(1_000_000 + asked_at.0));
                        self.say(&Message::TimeSync(TimeSync { asked_at, site_now }));
                    }
                    _ => {}
                }
                if let Some(found) = pick(&frame) {
                    return Some(found);
                }
            }
        }
        None
    }

    /// The board's Hello: in which start, and the highest epoch it has seen.
    fn hello(&mut self) -> (BootEpoch, Epoch) {
        let from = self.to;
        self.expect("Hello", |frame| match frame.message {
            Message::Hello(hello) if frame.header.sender == from => Some((frame.header.boot, hello.epoch)),
            _ => None,
        })
    }

    fn answer(&mut self, command: u32) -> Result<(), NackReason> {
        self.expect("its answer", |frame| answer_to(command, frame))
    }

    /// Says so until it is answered: a frame on a line that has just been opened may be lost.
    fn provision(&mut self, command: u32, pile: PileId) -> Result<(), NackReason> {
        (self.to, self.sessions) =
            (DeviceId::Factory, Sessions::new(DeviceId::Service, BootEpoch(100 + command), Trust::Insecure));
        let parameters = PileParameters {
            power: PowerW::new(500.0).unwrap(),
            eta: DurationMs(1_000),
            voltage_max: VoltageV::new(30.0).unwrap(),
            current_max: CurrentA::new(25.0).unwrap(),
            derate_from: TemperatureC::new(60.0).unwrap(),
            stop_at: TemperatureC::new(80.0).unwrap(),
            dock_enter_dbm: -60,
            dock_leave_dbm: -66,
        };
        let boot_floor = BootEpoch(30);
        let command_id = CommandId(command);
        let provision =
            Provision { command: command_id, pile, device_key: KEY, site_key: KEY, boot_floor, parameters };
        for _ in 0..60 {
            self.say(&Message::Provision(provision));
            if let Some(answer) = self.listen(Duration::from_secs(1), |frame| answer_to(command, frame)) {
                return answer;
            }
        }
        panic!("the board does not answer; its log: {:#?}", self.board.log());
    }

    fn report(&mut self) -> Message {
        self.expect("its report", |frame| match &frame.message {
            report @ (Message::PassReport(_) | Message::ChargeReport(_) | Message::Fault(_)) => {
                Some(report.clone())
            }
            _ => None,
        })
    }

    fn acknowledge(&mut self, report: ReportId) {
        self.say(&Message::Ack(Ack { of: Reference::Report(report) }));
    }
}

fn answer_to(command: u32, frame: &Frame) -> Option<Result<(), NackReason>> {
    let command = Reference::Command(CommandId(command));
    match frame.message {
        Message::Ack(Ack { of }) if of == command => Some(Ok(())),
        Message::Nack(Nack { of, reason }) if of == command => Some(Err(reason)),
        _ => None,
    }
}

fn boot(flash: &Path, reader: &UhfReader, button_held: bool) -> (Emulator, TcpStream, TestBench) {
    let (link, test) = (Awaited::new().unwrap(), Awaited::new().unwrap());
    let reader = tests::emulator::Serial::Dial(reader.address());
    let serials = [link.serial().unwrap(), reader, test.serial().unwrap()];
    let board = Emulator::boot_board(serials, flash, button_held).unwrap_or_else(|error| panic!("{error}"));
    (board, link.accept().unwrap(), TestBench::new(test.accept().unwrap()).unwrap())
}

#[test]
fn a_board_becomes_a_pile_and_remembers_over_restarts_who_it_is_and_what_it_has_not_told() {
    let directory = tempfile::tempdir().unwrap();
    let flash = directory.path().join("flash");
    std::fs::write(&flash, vec![0xFF; FLASH]).unwrap();
    let mut desk = Desk::new(flash);

    // Nobody yet; its first start.
    assert_eq!(desk.hello(), (BootEpoch(1), Epoch(0)));
    assert_eq!(desk.provision(1, PILE), Ok(()));
    assert_eq!(desk.provision(2, PILE), Ok(()), "a repeat");

    // It restarts by itself as the pile, in a start from the floor on, and believes who has its key.
    desk.coordinate(PILE);
    assert_eq!(desk.hello(), (BootEpoch(30), Epoch(0)));

    // A robot passes; nobody acknowledges it. A contactor welds.
    desk.reader.dock(ROBOT);
    let Message::PassReport(passed) = desk.report() else { panic!("no passes") };
    assert_eq!((passed.report.boot, passed.passes[0].tag), (BootEpoch(30), ROBOT));
    desk.test.order("welded 1").unwrap();
    let welded = |message: &Message| {
        matches!(message, Message::Fault(Fault { code: FaultCode::ContactorWelded, active: true, .. }))
    };
    while !welded(&desk.report()) {}

    // The power goes: identity, epoch, fault and passes are still there.
    desk.reader.clear();
    desk.restart(false);
    desk.coordinate(PILE);
    assert_eq!(desk.hello(), (BootEpoch(31), EPOCH));
    let Message::Fault(fault) = desk.report() else { panic!("no fault") };
    assert_eq!((fault.code, fault.active), (FaultCode::ContactorWelded, true));
    desk.acknowledge(fault.report);
    let again = loop {
        if let Message::PassReport(report) = desk.report() {
            break report;
        }
    };
    assert_eq!(again, passed, "under the name it had");
    desk.acknowledge(again.report);
    let clear = ClearFault { command: CommandId(50), code: FaultCode::ContactorWelded };
    desk.say(&Message::ClearFault(clear));
    assert_eq!(desk.answer(50), Ok(()));
    let Message::Fault(cleared) = desk.report() else { panic!("it is not told as gone") };
    assert!(!cleared.active);
    desk.acknowledge(cleared.report);

    // The power goes again: nothing is left to tell, until something happens.
    desk.restart(false);
    desk.coordinate(PILE);
    assert_eq!(desk.hello(), (BootEpoch(32), EPOCH));
    desk.reader.dock(ROBOT);
    let Message::PassReport(next) = desk.report() else { panic!("something old is told again") };
    assert_eq!(next.report.boot, BootEpoch(32));

    // Who it is can only be changed by who holds its button.
    assert_eq!(desk.provision(3, PileId(41)), Err(NackReason::Provisioned));
    desk.restart(true);
    assert_eq!(desk.provision(4, PileId(41)), Ok(()));
    desk.coordinate(PileId(41));
    assert_eq!(desk.hello().0, BootEpoch(34));
}
