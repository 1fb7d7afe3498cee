//! The pile's image in QEMU, its link and its RFID reader played by the test: real frames, real
//! reader frames, the real binary.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::time::{Duration, Instant};

use protocol::{
    Ack, Availability, BootEpoch, CommandHead, CommandId, Deframer, DeviceId, DurationMs, EndReason, EnergyJ,
    Epoch, FrameBytes, FrameWriter, Grant, Hello, LeaseId, LeaseRef, Message, Nack, NackReason, PassCount,
    PileId, PileState, Reference, Revoke, RobotId, SiteMillis, TagId, TimeSync, version,
};
use tests::emulator::{Emulator, Serial};
use tests::uhf_reader::UhfReader;

/// What the emulated pile is built with: its number, power and planning reserve (eta of eq. 2).
const PILE: PileId = PileId(1);
const POWER_W: f32 = 1000.0;
const ETA: DurationMs = DurationMs(5_000);

/// The coordinator's epoch, unless a test says otherwise.
const EPOCH: Epoch = Epoch(7);
/// What the robots' batteries lack: one second of the pile's power.
const ENERGY_J: f32 = 1000.0;
/// For everything that happens at once on an idle machine; a busy one needs more.
const SOON: Duration = Duration::from_secs(20);

const ROBOT: TagId = TagId(*b"robot no. 03");
const STRANGER: TagId = TagId(*b"robot no. 99");

/// A pile on its board, with a coordinator and a reader played for it.
struct Bench {
    board: Emulator,
    reader: UhfReader,
    link: TcpStream,
    deframer: Deframer,
    writer: FrameWriter,
    started: Instant,
    received: VecDeque<Message>,
    passes: Vec<PassCount>,
}

impl Bench {
    /// Boots the pile and waits for its Hello; answers it.
    fn new() -> Self {
        let coordinator = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let reader = UhfReader::start().unwrap();
        let link = Serial::Dial(coordinator.local_addr().unwrap());
        let board =
            Emulator::boot(link, Serial::Dial(reader.address())).unwrap_or_else(|error| panic!("{error}"));
        let (link, _) = coordinator.accept().unwrap();
        let mut bench = Self {
            board,
            reader,
            link,
            deframer: Deframer::new(),
            writer: FrameWriter::new(DeviceId::Coordinator, BootEpoch(1)),
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

    fn frame(&mut self, message: Message) -> FrameBytes {
        self.writer.write(message).unwrap()
    }

    fn say(&mut self, message: Message) {
        let frame = self.frame(message);
        self.link.write_all(&frame).unwrap();
    }

    /// A grant that is new, of a lease with the command's number.
    fn grant(&self, command: u32, epoch: Epoch) -> Grant {
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
    fn granted(&mut self) -> LeaseRef {
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
    fn extended(&mut self, lease: LeaseRef, command: u32) {
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
    fn answer(&mut self, command: u32) -> Result<(), NackReason> {
        let command = Reference::Command(CommandId(command));
        self.expect("its answer", |message| match message {
            Message::Ack(Ack { of }) if *of == command => Some(Ok(())),
            Message::Nack(Nack { of, reason }) if *of == command => Some(Err(*reason)),
            _ => None,
        })
    }

    fn state(&mut self) -> PileState {
        self.expect("its state", |message| match message {
            Message::PileState(state) => Some(*state),
            _ => None,
        })
    }

    fn state_where(&mut self, what: &str, wanted: impl Fn(&PileState) -> bool) -> PileState {
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
        self.deframer
            .feed(&buffer[..length], |frame| frames.push(frame.expect("the pile sent a damaged frame")));
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
    fn stays_dead_for(&mut self, reports: usize) -> PileState {
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

#[test]
fn a_granted_robot_is_charged_as_eq_1_says_and_counted_once() {
    let mut bench = Bench::new();
    let lease = bench.granted();
    let reserved = bench.state_where("that it is reserved", |state| state.holder == Some(lease));
    assert_eq!((reserved.row.availability, reserved.energised), (Availability::Reserved, false));

    bench.reader.dock(ROBOT);
    bench.board.wait_for("contactor closed", SOON).unwrap_or_else(|error| panic!("{error}"));
    let begun = Instant::now();
    let mut charging = vec![bench.state_where("that it charges", |state| state.energised)];
    let ended = loop {
        let state = bench.state();
        if state.holder.is_none() {
            break state;
        }
        charging.push(state);
    };
    let took = begun.elapsed();

    // Eq. 2: what the battery lacks by the pile's power, and the reserve.
    let planned = DurationMs(DurationMs::from_seconds(ENERGY_J / POWER_W).0 + ETA.0);
    for state in &charging {
        assert_eq!((state.row.availability, state.row.planned), (Availability::Charging, planned));
        // Eq. 1.
        let expected = 1.0 - state.elapsed.as_seconds() / planned.as_seconds();
        let remaining = state.row.remaining.get();
        assert!((remaining - expected).abs() < 1e-3, "q is {remaining} instead of {expected}");
    }
    for pair in charging.windows(2) {
        assert!(pair[1].row.remaining <= pair[0].row.remaining, "q rose: {pair:?}");
    }
    assert!(charging.len() > 20, "q fell in {} steps only", charging.len());
    let (first, last) = (charging[0].row.remaining.get(), charging[charging.len() - 1].row.remaining.get());
    assert!(first > 0.9 && last < 0.1, "q fell from {first} to {last} only");

    let over = ended.ended.expect("no lease has ended");
    assert_eq!((over.lease, over.reason), (lease, EndReason::Completed));
    assert!((planned..DurationMs(planned.0 + 500)).contains(&over.charged), "charged for {:?}", over.charged);
    assert_eq!((ended.energised, ended.row.availability), (false, Availability::Done));
    assert_eq!(ended.row.remaining.get(), 0.0);
    // QEMU's clock is the host's; both log and link are read late on a busy one.
    let seconds = f64::from(planned.as_seconds());
    assert!((seconds - 1.0..seconds + 4.0).contains(&took.as_secs_f64()), "it took {took:?}");
    bench.board.wait_for("contactor open", SOON).unwrap_or_else(|error| panic!("{error}"));

    bench.reader.clear();
    bench.state_where("that it is free", |state| state.row.availability == Availability::Free);
    // All that time it was one pass (eq. 4, one for each approach).
    let passes: Vec<_> = bench.passes.iter().map(|count| (count.tag, count.passes)).collect();
    assert_eq!(passes, [(ROBOT, 1)]);
}

#[test]
fn a_wrong_tag_does_nothing_and_the_right_one_still_charges() {
    let mut bench = Bench::new();
    let lease = bench.granted();
    bench.reader.dock(STRANGER);
    assert_eq!(bench.stays_dead_for(4).holder, Some(lease));
    bench.reader.dock(ROBOT);
    bench.state_where("that it charges", |state| state.energised);
}

#[test]
fn a_stale_epoch_is_refused_and_its_robot_not_charged() {
    let mut bench = Bench::new();
    let stale = bench.grant(100, Epoch(EPOCH.0 - 1));
    bench.say(Message::Grant(stale));
    assert_eq!(bench.answer(100), Err(NackReason::StaleEpoch { highest: EPOCH }));
    bench.reader.dock(ROBOT);
    assert_eq!(bench.stays_dead_for(4).holder, None);
    let lease = bench.granted();
    assert_eq!(bench.state_where("that it charges", |state| state.energised).holder, Some(lease));
}

#[test]
fn corrupted_frames_do_nothing_and_cost_no_good_one() {
    let mut bench = Bench::new();
    // A first lease, taken back: the clock is known and only damage can keep a grant from working.
    let lease = bench.granted();
    let head = bench.grant(99, EPOCH).head;
    bench.say(Message::Revoke(Revoke { head, lease }));
    assert_eq!(bench.answer(99), Ok(()));

    bench.reader.dock(ROBOT);
    let grant = bench.grant(100, EPOCH);
    let good = bench.frame(Message::Grant(grant));
    let damaged: Vec<u8> = (1..good.len() - 1)
        .flat_map(|index| {
            let mut frame = good.clone();
            frame[index] ^= 1 << (index % 8);
            frame
        })
        .collect();
    bench.link.write_all(&damaged).unwrap();
    assert_eq!(bench.stays_dead_for(4).holder, None);

    bench.link.write_all(&[&damaged, &good[..]].concat()).unwrap();
    assert_eq!(bench.answer(100), Ok(()));
    assert_eq!(bench.state_where("that it charges", |state| state.energised).holder, Some(grant.lease));
}

#[test]
fn a_flood_of_noise_is_survived() {
    let mut bench = Bench::new();
    let lease = bench.granted();
    let mut noise: u32 = 0x9E37_79B9;
    let flood: Vec<u8> = (0..16 * 1024)
        .map(|_| {
            // Marsaglia's xorshift: the same noise in every run.
            noise ^= noise << 13;
            noise ^= noise >> 17;
            noise ^= noise << 5;
            noise as u8
        })
        .collect();
    bench.link.write_all(&flood).unwrap();
    bench.extended(lease, 200);
    bench.reader.dock(ROBOT);
    assert_eq!(bench.state_where("that it charges", |state| state.energised).holder, Some(lease));
}
