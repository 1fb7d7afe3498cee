//! A chassis on its board in QEMU, driven by a robot's computer that is played here, with a reader in
//! front of it and the test bench of its image behind it.
//!
//! All times are the chassis' own, by the stamps of its odometry: a busy machine makes a run slower
//! and changes nothing else.

use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use protocol::{
    Ack, BootEpoch, ChassisState, CommandId, Deframer, DeviceId, Drive, DurationMs, FrameBytes, Hello,
    Message, Nack, NackReason, Odometry, PassCount, Recipient, Reference, Release, RobotId, Sessions,
    SiteMillis, SpeedMps, Stop, TimeSync, TurnRateRadps, Twist,
};

use crate::board_line::{Awaited, PATIENCE, TestBench};
use crate::emulator::{Emulator, Pace, Serial};
use crate::uhf_reader::UhfReader;

/// The robot the image is built for.
pub const ROBOT: RobotId = RobotId(1);
/// How often the computer repeats a drive command, by the chassis' clock.
const DRIVE_INTERVAL: DurationMs = DurationMs(50);
/// The longest time to live that the chassis accepts.
const TTL: DurationMs = DurationMs(1_000);

/// A chassis with everything that is wired to it.
pub struct ChassisBench {
    /// The board.
    pub board: Emulator,
    /// Its RFID reader.
    pub reader: UhfReader,
    /// The passes it has reported.
    pub passes: Vec<PassCount>,
    /// The states it has reported.
    pub states: Vec<ChassisState>,
    link: TcpStream,
    bench: TestBench,
    deframer: Deframer,
    sessions: Sessions,
    command: u32,
    answers: Vec<(CommandId, Result<(), NackReason>)>,
    odometry: Vec<Odometry>,
}

/// Where the robot really is and how it really moves: m, m, rad, m/s, m/s, rad/s.
#[derive(Clone, Copy, Debug)]
pub struct Truth {
    /// x, y and yaw, in the frame in which it started.
    pub pose: [f32; 3],
    /// x, y and yaw, in its own frame.
    pub velocity: [f32; 3],
}

/// What control ticks have cost.
#[derive(Clone, Copy, Debug)]
pub struct Costs {
    /// How many were counted.
    pub ticks: u32,
    /// Instructions of the median one, rounded up to 32.
    pub median: u32,
    /// Instructions of the worst.
    pub worst: u32,
    /// Bytes the stack has needed so far, the model's own need included.
    pub stack: u32,
}

/// A velocity in m/s and rad/s.
///
/// # Errors
/// If it is none that the wire knows.
pub fn twist(vx: f32, vy: f32, wz: f32) -> io::Result<Twist> {
    let speed = |value| SpeedMps::new(value).map_err(io::Error::other);
    Ok(Twist { vx: speed(vx)?, vy: speed(vy)?, wz: TurnRateRadps::new(wz).map_err(io::Error::other)? })
}

impl ChassisBench {
    /// Boots the image, answers its Hello and lets it learn its gyroscope's bias for a second.
    ///
    /// # Errors
    /// What is missing, and how to get it.
    pub fn boot() -> io::Result<Self> {
        Self::boot_at(Pace::RealTime)
    }

    /// The same at a pace.
    ///
    /// # Errors
    /// What is missing, and how to get it.
    pub fn boot_at(pace: Pace) -> io::Result<Self> {
        let (link, bench) = (Awaited::new()?, Awaited::new()?);
        let reader = UhfReader::start()?;
        let at_reader = Serial::Dial(reader.address());
        let board = Emulator::boot_chassis(link.serial()?, at_reader, bench.serial()?, pace)
            .map_err(io::Error::other)?;
        let (link, bench) = (link.accept()?, TestBench::new(bench.accept()?)?);
        link.set_read_timeout(Some(Duration::from_millis(100)))?;
        let mut this = Self {
            board,
            reader,
            passes: Vec::new(),
            states: Vec::new(),
            link,
            bench,
            deframer: Deframer::new(),
            sessions: Sessions::insecure(DeviceId::Robot(ROBOT), BootEpoch(1)),
            command: 0,
            answers: Vec::new(),
            odometry: Vec::new(),
        };
        this.watch_for(DurationMs(1_000))?;
        Ok(this)
    }

    /// Watches for so long, by the chassis' clock. Answers its odometry, tick by tick.
    ///
    /// # Errors
    /// If it falls silent.
    pub fn watch_for(&mut self, time: DurationMs) -> io::Result<Vec<Odometry>> {
        self.keep(time, |_| Ok(()))
    }

    /// Drives for so long, as a computer does: the command again and again. Answers the odometry.
    ///
    /// # Errors
    /// If the chassis falls silent.
    pub fn drive_for(&mut self, twist: Twist, time: DurationMs) -> io::Result<Vec<Odometry>> {
        self.keep(time, |bench| bench.drive(twist, TTL).map(drop))
    }

    /// Has `act` done every 50 ms.
    ///
    /// # Errors
    /// If the chassis falls silent, and those of `act`.
    pub fn keep(
        &mut self,
        time: DurationMs,
        mut act: impl FnMut(&mut Self) -> io::Result<()>,
    ) -> io::Result<Vec<Odometry>> {
        self.odometry.clear();
        act(self)?;
        let mut seen = Vec::new();
        let (mut started, mut acted) = (None, None);
        loop {
            self.receive_until("its odometry", |bench| !bench.odometry.is_empty())?;
            for odometry in std::mem::take(&mut self.odometry) {
                let stamp = odometry.stamp;
                seen.push(odometry);
                if stamp.since(*started.get_or_insert(stamp)) >= time {
                    return Ok(seen);
                }
                if stamp.since(*acted.get_or_insert(stamp)) >= DRIVE_INTERVAL {
                    acted = Some(stamp);
                    act(self)?;
                }
            }
        }
    }

    /// Waits for a state that is `wanted`.
    ///
    /// # Errors
    /// If there is none in time.
    pub fn state_where(&mut self, wanted: impl Fn(&ChassisState) -> bool) -> io::Result<ChassisState> {
        self.states.clear();
        self.receive_until("the state that was waited for", |bench| bench.states.iter().any(&wanted))?;
        self.states.iter().find(|state| wanted(state)).cloned().ok_or_else(|| ErrorKind::NotFound.into())
    }

    /// Sends one drive command.
    ///
    /// # Errors
    /// If the link is gone.
    pub fn drive(&mut self, twist: Twist, ttl: DurationMs) -> io::Result<CommandId> {
        let command = self.next_command();
        self.say(Message::Drive(Drive { command, ttl, twist }))?;
        Ok(command)
    }

    /// Sends a stop.
    ///
    /// # Errors
    /// If the link is gone.
    pub fn stop(&mut self, emergency: bool) -> io::Result<CommandId> {
        let command = self.next_command();
        self.say(Message::Stop(Stop { command, emergency }))?;
        Ok(command)
    }

    /// Releases a stop that is held.
    ///
    /// # Errors
    /// If the link is gone.
    pub fn release(&mut self) -> io::Result<CommandId> {
        let command = self.next_command();
        self.say(Message::Release(Release { command }))?;
        Ok(command)
    }

    /// The chassis' answer to a command.
    ///
    /// # Errors
    /// If there is none in time.
    pub fn answer(&mut self, command: CommandId) -> io::Result<Result<(), NackReason>> {
        let of =
            move |bench: &Self| bench.answers.iter().find(|(id, _)| *id == command).map(|(_, said)| *said);
        self.receive_until("its answer", |bench| of(bench).is_some())?;
        of(self).ok_or_else(|| ErrorKind::NotFound.into())
    }

    /// Where the robot really is.
    ///
    /// # Errors
    /// If the test bench does not answer.
    pub fn truth(&mut self) -> io::Result<Truth> {
        let [x, y, yaw, vx, vy, wz] = self.bench.numbers("truth")?;
        Ok(Truth { pose: [x, y, yaw], velocity: [vx, vy, wz] })
    }

    /// What control ticks have cost since this was asked last.
    ///
    /// # Errors
    /// If the test bench does not answer.
    pub fn costs(&mut self) -> io::Result<Costs> {
        let [ticks, median, worst, stack] = self.bench.numbers("cost")?;
        Ok(Costs { ticks, median, worst, stack })
    }

    /// Breaks or mends something: see the image's test bench for the words.
    ///
    /// # Errors
    /// If it does not know them.
    pub fn order(&mut self, words: &str) -> io::Result<()> {
        self.bench.order(words)
    }

    /// Makes a task of the chassis hang.
    ///
    /// # Errors
    /// If the test bench is gone.
    pub fn hang(&mut self) -> io::Result<()> {
        self.bench.hang()
    }

    /// The bytes of a message in its frame, to be damaged.
    ///
    /// # Errors
    /// If it does not fit.
    pub fn frame(&mut self, message: Message) -> io::Result<FrameBytes> {
        self.sessions.seal(Recipient::Device(DeviceId::Chassis(ROBOT)), &message).map_err(io::Error::other)
    }

    /// Sends bytes.
    ///
    /// # Errors
    /// If the link is gone.
    pub fn transmit(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.link.write_all(bytes)
    }

    /// A command's number.
    pub fn next_command(&mut self) -> CommandId {
        self.command += 1;
        CommandId(self.command)
    }

    fn say(&mut self, message: Message) -> io::Result<()> {
        let frame = self.frame(message)?;
        self.transmit(&frame)
    }

    fn receive_until(&mut self, what: &str, done: impl Fn(&Self) -> bool) -> io::Result<()> {
        let deadline = Instant::now() + PATIENCE;
        while !done(self) {
            if Instant::now() >= deadline {
                let log = self.board.log();
                return Err(io::Error::other(format!("the chassis did not send {what}; its log: {log:#?}")));
            }
            self.receive()?;
        }
        Ok(())
    }

    /// Receives for a moment; answers what a computer answers whatever else it does.
    fn receive(&mut self) -> io::Result<()> {
        let mut buffer = [0; 4096];
        let length = match self.link.read(&mut buffer) {
            Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
            Ok(length) => length,
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => 0,
            Err(error) => return Err(error),
        };
        let mut messages = Vec::new();
        let mut damaged = None;
        self.deframer.feed(buffer.get(..length).unwrap_or_default(), |found| {
            match found.and_then(|packet| self.sessions.open(packet)) {
                Ok(frame) => messages.push(frame.message),
                Err(error) => damaged = Some(error),
            }
        });
        // A reset cuts the frame that was under way.
        if let Some(error) = damaged {
            self.board.log().iter().for_each(drop);
            eprintln!("from the chassis: {error}");
        }
        for message in messages {
            match message {
                Message::Odometry(odometry) => self.odometry.push(odometry),
                Message::ChassisState(state) => self.states.push(state),
                Message::Ack(Ack { of: Reference::Command(id) }) => self.answers.push((id, Ok(()))),
                Message::Nack(Nack { of: Reference::Command(id), reason }) => {
                    self.answers.push((id, Err(reason)));
                }
                Message::Hello(hello) => self.say(Message::Hello(Hello { ..hello }))?,
                Message::TimeRequest(request) => {
                    let site_now = SiteMillis(1_000_000 + request.asked_at.0);
                    self.say(Message::TimeSync(TimeSync { asked_at: request.asked_at, site_now }))?;
                }
                Message::PassReport(report) => {
                    self.passes.extend(report.passes.iter().copied());
                    self.say(Message::Ack(Ack { of: Reference::Report(report.report) }))?;
                }
                _ => {}
            }
        }
        Ok(())
    }
}
