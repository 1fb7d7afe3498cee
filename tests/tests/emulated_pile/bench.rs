//! A pile on its board, with its coordinator and its reader played by the test.

use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::thread;
use std::time::{Duration, Instant};

use protocol::{
    Ack, BootEpoch, CommandHead, CommandId, Deframer, DeviceId, DurationMs, EnergyJ, Epoch, FrameBytes,
    Grant, Hello, LeaseId, LeaseRef, Message, Nack, NackReason, PassCount, PileId, PileState, Recipient,
    Reference, RobotId, Sessions, SiteMillis, TagId, TimeSync, version,
};
use tests::emulator::{Emulator, Serial};
use tests::uhf_reader::UhfReader;

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

/// A pile on its board, with a coordinator and a reader played for it.
pub struct Bench {
    pub board: Emulator,
    pub reader: UhfReader,
    link: TcpStream,
    deframer: Deframer,
    sessions: Sessions,
    started: Instant,
    received: VecDeque<Message>,
    pub passes: Vec<PassCount>,
}

impl Bench {
    /// Boots the pile and waits for its Hello; answers it.
    pub fn new() -> Self {
        let coordinator = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let reader = UhfReader::start().unwrap();
        let link = Serial::Dial(coordinator.local_addr().unwrap());
        let board =
            Emulator::boot(link, Serial::Dial(reader.address())).unwrap_or_else(|error| panic!("{error}"));
        let link = accept(&coordinator);
        let mut bench = Self {
            board,
            reader,
            link,
            deframer: Deframer::new(),
            sessions: Sessions::insecure(DeviceId::Coordinator, BootEpoch(1)),
            started: Instant::now(),
            received: VecDeque::new(),
            passes: Vec::new(),
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

    pub fn frame(&mut self, message: Message) -> FrameBytes {
        self.sessions.seal(Recipient::Device(DeviceId::Pile(PILE)), &message).unwrap()
    }

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
        for command in 1.. {
            let grant = self.grant(command, EPOCH);
            self.say(Message::Grant(grant));
            match self.answer(command) {
                Ok(()) => return grant.lease,
                Err(NackReason::ClockUnknown) => {}
                Err(reason) => panic!("the grant was refused: {reason:?}"),
            }
        }
        unreachable!("the loop has no end")
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

    pub fn state(&mut self) -> PileState {
        self.expect("its state", |message| match message {
            Message::PileState(state) => Some(*state),
            _ => None,
        })
    }

    pub fn state_where(&mut self, what: &str, wanted: impl Fn(&PileState) -> bool) -> PileState {
        self.expect(what, |message| match message {
            Message::PileState(state) if wanted(state) => Some(*state),
            _ => None,
        })
    }

    /// The next message that `pick` takes; others are passed over.
    fn expect<T>(&mut self, what: &str, pick: impl Fn(&Message) -> Option<T>) -> T {
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
            let opened = found.and_then(|packet| self.sessions.open(packet));
            frames.push(opened.expect("the pile sent a damaged frame"));
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
                Message::Fault(fault) => panic!("the pile reports {fault:?}"),
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
        let log = self.board.log();
        assert!(!log.iter().any(|line| line.contains("contactor closed")), "the contactor closed: {log:#?}");
        last.expect("no reports were asked for")
    }
}

/// The pile's connection; it calls as soon as QEMU runs.
fn accept(listener: &TcpListener) -> TcpStream {
    listener.set_nonblocking(true).unwrap();
    let deadline = Instant::now() + SOON;
    loop {
        match listener.accept() {
            Ok((pile, _)) => {
                pile.set_nonblocking(false).unwrap();
                return pile;
            }
            Err(error) if error.kind() == ErrorKind::WouldBlock && Instant::now() < deadline => {
                thread::sleep(Duration::from_millis(10));
            }
            Err(error) => panic!("QEMU does not connect the pile's link: {error}; its messages say why"),
        }
    }
}
