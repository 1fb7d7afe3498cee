//! A pile on its board in QEMU, with its coordinator and its reader played here, and the test bench
//! of its image behind it. Whatever fails ends the test.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use protocol::{
    Ack, BootEpoch, ClearFault, CommandHead, CommandId, Deframer, DeviceId, DurationMs, EnergyJ, Epoch,
    FaultCode, FrameBytes, Grant, Hello, LeaseId, LeaseRef, Message, Nack, NackReason, PassCount, PileId,
    PileState, Recipient, Reference, RobotId, Sessions, SiteMillis, TagId, TimeSync, version,
};

use crate::board_line::{Awaited, TestBench};
use crate::emulator::{Emulator, Serial};
use crate::uhf_reader::UhfReader;

/// The number the emulated pile is built with.
pub const PILE: PileId = PileId(1);
/// The power it is built with.
pub const POWER_W: f32 = 500.0;
/// The reserve it plans with (eta of LMPP eq. 2).
pub const ETA: DurationMs = DurationMs(5_000);

/// The coordinator's epoch, unless a test says otherwise.
pub const EPOCH: Epoch = Epoch(7);
/// What the robots' batteries lack: one second of the pile's power.
pub const ENERGY_J: f32 = 500.0;
/// For everything that happens at once on an idle machine; a busy one needs more.
pub const SOON: Duration = Duration::from_secs(20);

/// The tag of the robot that is granted the pile.
pub const ROBOT: TagId = TagId(*b"robot no. 03");
/// The tag of another.
pub const STRANGER: TagId = TagId(*b"robot no. 99");

/// What is commanded to the pile's power stage and contactor, and what is true.
#[derive(Clone, Copy, Debug)]
pub struct Power {
    /// Whether the contactor is told to be closed.
    pub told_closed: bool,
    /// What the power stage may give, in amperes.
    pub limit_a: f32,
    /// Whether the contactor is closed.
    pub found_closed: bool,
    /// The voltage at the contacts.
    pub voltage_v: f32,
    /// The current into the robot, in amperes.
    pub current_a: f32,
    /// The contacts' temperature, in degrees Celsius.
    pub contact_c: f32,
}

/// How the contactor was told to open.
#[derive(Clone, Copy, Debug)]
pub struct Reaction {
    /// Samples after the first that showed why.
    pub ticks: u32,
    /// Instructions after the sample that decided it.
    pub instructions: u32,
    /// What flowed then, in amperes.
    pub current_a: f32,
}

/// A pile on its board, with a coordinator and a reader played for it.
pub struct PileBench {
    /// The board.
    pub board: Emulator,
    /// Its RFID reader.
    pub reader: UhfReader,
    /// What breaks its charger.
    pub test: TestBench,
    link: TcpStream,
    deframer: Deframer,
    sessions: Sessions,
    started: Instant,
    received: VecDeque<Message>,
    /// The passes it has reported.
    pub passes: Vec<PassCount>,
    /// The faults it has reported, as they came and went.
    pub faults: Vec<(FaultCode, bool)>,
    /// Whether it may have been reset, which cuts off a frame.
    pub resets: bool,
    commands: u32,
}

impl PileBench {
    /// Boots the pile and waits for its Hello; answers it.
    #[expect(clippy::new_without_default, reason = "it boots a board")]
    pub fn new() -> Self {
        let (link, test) = (Awaited::new().unwrap(), Awaited::new().unwrap());
        let reader = UhfReader::start().unwrap();
        let at_reader = Serial::Dial(reader.address());
        let board = Emulator::boot_pile(link.serial().unwrap(), at_reader, test.serial().unwrap())
            .unwrap_or_else(|error| panic!("{error}"));
        let mut bench = Self {
            board,
            reader,
            test: TestBench::new(test.accept().unwrap()).unwrap(),
            link: link.accept().unwrap(),
            deframer: Deframer::new(),
            sessions: Sessions::insecure(DeviceId::Coordinator, BootEpoch(1)),
            started: Instant::now(),
            received: VecDeque::new(),
            passes: Vec::new(),
            faults: Vec::new(),
            resets: false,
            commands: 0,
        };
        let hello = bench.expect("its Hello", |message| match message {
            Message::Hello(hello) => Some(*hello),
            _ => None,
        });
        assert_eq!((hello.min, hello.current), (version::MIN, version::CURRENT));
        bench.say(Message::Hello(Hello { epoch: EPOCH, ..hello }));
        bench
    }

    fn site_now(&self) -> SiteMillis {
        SiteMillis(1_000_000 + u64::try_from(self.started.elapsed().as_millis()).unwrap())
    }

    /// The bytes of a message in its frame, to be damaged.
    pub fn frame(&mut self, message: Message) -> FrameBytes {
        self.sessions.seal(Recipient::Device(DeviceId::Pile(PILE)), &message).unwrap()
    }

    /// Sends a message.
    pub fn say(&mut self, message: Message) {
        let frame = self.frame(message);
        self.transmit(&frame);
    }

    /// Sends bytes, whatever they are.
    pub fn transmit(&mut self, bytes: &[u8]) {
        self.link.write_all(bytes).unwrap();
    }

    /// A grant that is new, of a lease with the command's number.
    pub fn grant(&self, command: u32, epoch: Epoch) -> Grant {
        let hour = DurationMs(3_600_000);
        Grant {
            head: CommandHead { id: CommandId(command), valid_until: self.site_now().after(hour) },
            lease: LeaseRef { epoch, lease: LeaseId(command), robot: RobotId(3) },
            tag: ROBOT,
            expiry: self.site_now().after(hour),
            energy: EnergyJ::new(ENERGY_J).unwrap(),
        }
    }

    /// Grants the pile to the robot and waits until it is acknowledged. The pile refuses for as
    /// long as it does not know the time.
    pub fn granted(&mut self) -> LeaseRef {
        self.granted_for(EnergyJ::new(ENERGY_J).unwrap())
    }

    /// The same for a robot whose battery lacks so much.
    pub fn granted_for(&mut self, energy: EnergyJ) -> LeaseRef {
        loop {
            let command = self.next_command();
            let grant = Grant { energy, ..self.grant(command, EPOCH) };
            self.say(Message::Grant(grant));
            match self.answer(command) {
                Ok(()) => return grant.lease,
                Err(NackReason::ClockUnknown) => {}
                Err(reason) => panic!("the grant was refused: {reason:?}"),
            }
        }
    }

    /// A command's number, from 1.
    pub fn next_command(&mut self) -> u32 {
        self.commands += 1;
        self.commands
    }

    /// A robot is granted the pile for a long charge, comes, and gets the current it can get.
    pub fn charge(&mut self) -> LeaseRef {
        let lease = self.granted_for(EnergyJ::new(100_000.0).unwrap());
        self.reader.dock(ROBOT);
        self.until("a current of more than 18 A", |power| power.current_a > 18.0);
        lease
    }

    /// What is commanded, and what is true.
    pub fn power(&mut self) -> Power {
        let [told, limit_a, found, voltage_v, current_a, contact_c] = self.test.numbers("power").unwrap();
        let (told_closed, found_closed) = (told == 1.0, found == 1.0);
        Power { told_closed, limit_a, found_closed, voltage_v, current_a, contact_c }
    }

    /// Waits until the power is as `wanted`.
    pub fn until(&mut self, what: &str, wanted: impl Fn(&Power) -> bool) -> Power {
        let deadline = Instant::now() + SOON;
        loop {
            let power = self.power();
            if wanted(&power) {
                return power;
            }
            let log = self.board.log();
            assert!(Instant::now() < deadline, "not within {SOON:?}: {what}; {power:?}, its log: {log:#?}");
            self.receive();
        }
    }

    /// How the contactor was opened since the last order; none if it was not.
    pub fn reaction(&mut self) -> Option<Reaction> {
        let line = self.test.ask("reaction").unwrap();
        let mut words = line.split(' ').skip(1);
        let mut word = || words.next();
        let ticks = word()?.parse().ok()?;
        let instructions = word()?.parse().ok()?;
        let current_a = word()?.parse().ok()?;
        Some(Reaction { ticks, instructions, current_a })
    }

    /// Waits until it has reported that `code` `stands`, or does no more.
    pub fn reports(&mut self, code: FaultCode, stands: bool) {
        let deadline = Instant::now() + SOON;
        while !self.faults.contains(&(code, stands)) {
            let (told, log) = (&self.faults, self.board.log());
            assert!(
                Instant::now() < deadline,
                "no report of {code:?} within {SOON:?}, only {told:?}; its log: {log:#?}"
            );
            self.receive();
        }
    }

    /// Has a latched fault cleared; the pile's answer.
    pub fn clear(&mut self, code: FaultCode) -> Result<(), NackReason> {
        let command = self.next_command();
        self.say(Message::ClearFault(ClearFault { command: CommandId(command), code }));
        self.answer(command)
    }

    /// What it says in so much time.
    pub fn hears_for(&mut self, time: Duration) -> Vec<Message> {
        let end = Instant::now() + time;
        self.received.clear();
        while Instant::now() < end {
            self.receive();
        }
        self.received.drain(..).collect()
    }

    /// Extends the lease; repeats it, as a coordinator does, because a frame next to noise may be
    /// lost with it.
    pub fn extended(&mut self, lease: LeaseRef, command: u32) {
        let extension = Grant { lease, ..self.grant(command, EPOCH) };
        let command = Reference::Command(extension.head.id);
        let deadline = Instant::now() + SOON;
        while Instant::now() < deadline {
            self.say(Message::Grant(extension));
            self.receive();
            if self.received.drain(..).any(|message| message == Message::Ack(Ack { of: command })) {
                return;
            }
        }
        panic!("the pile did not extend its lease within {SOON:?}; its log: {:#?}", self.board.log());
    }

    /// The pile's answer to a command.
    pub fn answer(&mut self, command: u32) -> Result<(), NackReason> {
        let command = Reference::Command(CommandId(command));
        self.expect("its answer", |message| match message {
            Message::Ack(Ack { of }) if *of == command => Some(Ok(())),
            Message::Nack(Nack { of, reason }) if *of == command => Some(Err(*reason)),
            _ => None,
        })
    }

    /// The next state it tells.
    pub fn state(&mut self) -> PileState {
        self.expect("its state", |message| match message {
            Message::PileState(state) => Some(*state),
            _ => None,
        })
    }

    /// The next state it tells that is `wanted`.
    pub fn state_where(&mut self, what: &str, wanted: impl Fn(&PileState) -> bool) -> PileState {
        self.expect(what, |message| match message {
            Message::PileState(state) if wanted(state) => Some(*state),
            _ => None,
        })
    }

    /// The next message that `pick` takes; others are passed over.
    pub fn expect<T>(&mut self, what: &str, pick: impl Fn(&Message) -> Option<T>) -> T {
        let deadline = Instant::now() + SOON;
        loop {
            while let Some(message) = self.received.pop_front() {
                if let Some(found) = pick(&message) {
                    return found;
                }
            }
            let log = self.board.log();
            assert!(
                Instant::now() < deadline,
                "the pile did not say {what} within {SOON:?}; its log: {log:#?}"
            );
            self.receive();
        }
    }

    /// Receives for a moment; answers what a coordinator answers whatever else it does.
    fn receive(&mut self) {
        let mut buffer = [0; 1024];
        self.link.set_read_timeout(Some(Duration::from_millis(100))).unwrap();
        let length = match self.link.read(&mut buffer) {
            Ok(length) => length,
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => 0,
            Err(error) => panic!("the link is gone: {error}; the board's log: {:#?}", self.board.log()),
        };
        let mut frames = Vec::new();
        self.deframer.feed(&buffer[..length], |found| {
            match found.and_then(|packet| self.sessions.open(packet)) {
                Ok(frame) => frames.push(frame),
                Err(error) => assert!(self.resets, "the pile sent a damaged frame: {error}"),
            }
        });
        for frame in frames {
            assert_eq!(frame.header.sender, DeviceId::Pile(PILE));
            match &frame.message {
                Message::TimeRequest(request) => {
                    let sync = TimeSync { asked_at: request.asked_at, site_now: self.site_now() };
                    self.say(Message::TimeSync(sync));
                }
                Message::PassReport(report) => {
                    self.passes.extend(report.passes.iter().copied());
                    self.say(Message::Ack(Ack { of: Reference::Report(report.report) }));
                }
                Message::ChargeReport(report) => {
                    self.say(Message::Ack(Ack { of: Reference::Report(report.report) }));
                }
                Message::Fault(fault) => {
                    self.faults.push((fault.code, fault.active));
                    self.say(Message::Ack(Ack { of: Reference::Report(fault.report) }));
                }
                _ => {}
            }
            self.received.push_back(frame.message);
        }
    }

    /// Watches the pile while it reports its state so many times: it must not charge.
    pub fn stays_dead_for(&mut self, reports: usize) -> PileState {
        let mut last = None;
        for _ in 0..reports {
            let state = self.state();
            assert!(!state.energised, "the contacts are live: {state:?}");
            last = Some(state);
        }
        assert_eq!(self.closings(), 0, "the contactor closed: {:#?}", self.board.log());
        assert_eq!(self.faults, []);
        last.expect("no reports were asked for")
    }

    /// How often its contactor was closed so far.
    pub fn closings(&mut self) -> usize {
        self.board.log().iter().filter(|line| line.contains("contactor closed")).count()
    }
}
