//! What the robot's computer says to its chassis, and when. Pure: time and one input go in,
//! messages come out.
//!
//! The chassis obeys only the computer of its own robot, so the session first listens, takes the
//! robot's number from the chassis' first frame and then speaks as that robot. It answers what a
//! chassis asks (Hello, the time, passes of piles), and drives with short-lived commands: whatever
//! happens to this side, the chassis stops by itself [`limits::DRIVE_TTL`] later. While nothing is
//! heard of the chassis it is not driven either.

use protocol::{
    Ack, ChassisMode, ChassisState, CommandId, DeviceId, Drive, DurationMs, Epoch, Frame, FrameError, Hello,
    Message, Millis, NackReason, Odometry, Reference, Release, RobotId, SiteMillis, Stop, TimeSync, Twist,
    limits, version,
};

use super::outcome::{Moved, Report, SessionError};

/// A drive command follows the last after this time: three may be lost before the chassis stops.
const DRIVE_INTERVAL: DurationMs = DurationMs(50);
/// A command without an answer is repeated after this time: a stop is urgent.
const REPEAT: DurationMs = DurationMs(100);
/// Longer than this no chassis is silent, and no command stays unanswered.
pub const SILENCE: DurationMs = DurationMs(2_000);
/// From its highest speed a chassis ramps down in less than this.
const HALT: DurationMs = DurationMs(5_000);

/// What a session is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// Drive like this, for so long or until interrupted, then stop.
    Drive {
        /// How.
        twist: Twist,
        /// For how long.
        duration: Option<DurationMs>,
    },
    /// Ramp to a stop, or brake at once and stay braked until a release.
    Stop {
        /// At once.
        emergency: bool,
    },
    /// End a held stop.
    Release,
    /// Listen until interrupted.
    Listen,
}

/// What can happen to a session.
#[derive(Clone, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "an input lives for one step, and a box would be one more allocation"
)]
pub enum Input {
    /// Time passes; every few milliseconds.
    Tick,
    /// A frame arrived.
    Frame(Frame),
    /// Something arrived that is no frame.
    Discarded(FrameError),
    /// The person wants it to end.
    Interrupt,
}

/// A report of the chassis.
#[derive(Clone, Debug, PartialEq)]
pub enum Heard {
    /// Of its motion.
    Odometry(Odometry),
    /// Of itself.
    State(ChassisState),
}

/// What a step asks of the shell.
#[derive(Clone, Debug, Default)]
pub struct Outputs {
    /// What to send to the chassis.
    pub send: Vec<Message>,
    /// What the chassis has reported.
    pub heard: Option<Heard>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    /// Nothing of a chassis was heard.
    Seeking,
    Listening,
    Driving {
        until: Option<Millis>,
    },
    /// A command is repeated until it is answered.
    Asking(Ask),
    /// The stop was taken; the ramp takes its time.
    Halting {
        since: Millis,
    },
    Done,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Ask {
    Stop { emergency: bool },
    Release,
}

/// A conversation with a chassis.
#[derive(Clone, Debug)]
pub struct Session {
    goal: Goal,
    wall_at_zero: SiteMillis,
    phase: Phase,
    robot: Option<RobotId>,
    heard_at: Millis,
    greeted_at: Option<Millis>,
    noise: Option<FrameError>,
    /// The newest command's number, or the one before the first.
    newest: u32,
    sent_at: Option<Millis>,
    /// Since when commands go unanswered.
    unanswered_since: Option<Millis>,
    done: u32,
    first: Option<Odometry>,
    last: Option<Odometry>,
    reached: Twist,
    state: Option<ChassisState>,
}

impl Session {
    /// A session that starts at `Millis(0)`, which is `wall_at_zero` of the site's time.
    #[must_use]
    pub fn new(goal: Goal, wall_at_zero: SiteMillis) -> Self {
        Self {
            goal,
            wall_at_zero,
            phase: Phase::Seeking,
            robot: None,
            heard_at: Millis(0),
            greeted_at: None,
            noise: None,
            newest: first_number(wall_at_zero),
            sent_at: None,
            unanswered_since: None,
            done: 0,
            first: None,
            last: None,
            reached: Twist::default(),
            state: None,
        }
    }

    /// Takes one input.
    ///
    /// # Errors
    /// [`SessionError`] ends the session: nothing is to be sent any more.
    pub fn step(&mut self, now: Millis, input: Input) -> Result<Outputs, SessionError> {
        let mut outputs = Outputs::default();
        match input {
            Input::Tick => {}
            Input::Discarded(error) => self.noise = Some(error),
            Input::Interrupt => self.interrupt(),
            Input::Frame(frame) => self.hear(now, frame, &mut outputs)?,
        }
        self.check_patience(now)?;
        self.speak(now, &mut outputs.send);
        Ok(outputs)
    }

    /// Whether the goal is reached.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.phase == Phase::Done
    }

    /// Whether the chassis may be in motion on this session's behalf.
    #[must_use]
    pub const fn is_moving(&self) -> bool {
        matches!(self.phase, Phase::Driving { .. } | Phase::Asking(Ask::Stop { .. }) | Phase::Halting { .. })
    }

    /// Whose chassis it is, once that is known.
    #[must_use]
    pub const fn robot(&self) -> Option<RobotId> {
        self.robot
    }

    /// What the chassis said of itself last.
    #[must_use]
    pub const fn state(&self) -> Option<&ChassisState> {
        self.state.as_ref()
    }

    /// How it went so far.
    #[must_use]
    pub fn report(&self) -> Report {
        let moved = self.first.zip(self.last).map(|(first, last)| Moved::between(&first, &last));
        Report {
            robot: self.robot,
            done: self.done,
            reached: self.reached,
            moved: moved.unwrap_or_default(),
            mode: self.state.as_ref().map(|state| state.mode),
            stop: self.state.as_ref().and_then(|state| state.stop),
        }
    }

    fn interrupt(&mut self) {
        match self.phase {
            Phase::Seeking | Phase::Listening => self.phase = Phase::Done,
            Phase::Driving { .. } => self.ask(Ask::Stop { emergency: false }),
            // They end by themselves, and soon.
            Phase::Asking(_) | Phase::Halting { .. } | Phase::Done => {}
        }
    }

    fn hear(&mut self, now: Millis, frame: Frame, outputs: &mut Outputs) -> Result<(), SessionError> {
        let sender = frame.header.sender;
        let robot = match (self.robot, sender) {
            (None, DeviceId::Chassis(robot)) => robot,
            (None, sender) => return Err(SessionError::WrongDevice { sender }),
            (Some(robot), sender) if sender == DeviceId::Chassis(robot) => robot,
            // An echo of ours, or noise that happens to be a frame.
            _ => return Ok(()),
        };
        (self.heard_at, self.noise) = (now, None);
        if let Message::Hello(hello) = frame.message {
            let theirs = version::Range { min: hello.min, current: hello.current };
            version::negotiate(version::OURS, theirs)?;
        }
        if self.robot.is_none() {
            self.robot = Some(robot);
            self.begin(now);
        }
        match frame.message {
            Message::Hello(_) => self.greet(now, &mut outputs.send),
            Message::TimeRequest(request) => outputs.send.push(Message::TimeSync(TimeSync {
                asked_at: request.asked_at,
                site_now: SiteMillis(self.wall_at_zero.0.saturating_add(now.0)),
            })),
            Message::PassReport(report) => {
                outputs.send.push(Message::Ack(Ack { of: Reference::Report(report.report) }));
            }
            Message::Ack(Ack { of: Reference::Command(command) }) => self.acknowledged(now, command),
            Message::Nack(nack) => self.refused(robot, nack.of, nack.reason)?,
            Message::Odometry(odometry) => {
                self.first.get_or_insert(odometry);
                self.last = Some(odometry);
                outputs.heard = Some(Heard::Odometry(odometry));
            }
            Message::ChassisState(state) => {
                if matches!(self.phase, Phase::Halting { .. }) && state.mode == ChassisMode::Braked {
                    self.phase = Phase::Done;
                }
                self.state = Some(state.clone());
                outputs.heard = Some(Heard::State(state));
            }
            _ => {}
        }
        Ok(())
    }

    fn begin(&mut self, now: Millis) {
        match self.goal {
            Goal::Drive { duration, .. } => {
                self.phase = Phase::Driving { until: duration.map(|duration| now.after(duration)) };
            }
            Goal::Stop { emergency } => self.ask(Ask::Stop { emergency }),
            Goal::Release => self.ask(Ask::Release),
            Goal::Listen => self.phase = Phase::Listening,
        }
    }

    fn ask(&mut self, ask: Ask) {
        self.reached = self.last.map_or(self.reached, |last| last.measured);
        self.newest = self.newest.saturating_add(1);
        self.sent_at = None;
        self.phase = Phase::Asking(ask);
    }

    /// Our Hello is held back while the last is fresh, so that two answers never chase each other.
    fn greet(&mut self, now: Millis, send: &mut Vec<Message>) {
        if is_due(now, self.greeted_at, limits::REPEAT_INTERVAL) {
            self.greeted_at = Some(now);
            send.push(Message::Hello(Hello::new(Epoch(0))));
        }
    }

    fn acknowledged(&mut self, now: Millis, command: CommandId) {
        self.unanswered_since = None;
        if command != CommandId(self.newest) {
            return;
        }
        self.done = self.done.saturating_add(1);
        match self.phase {
            Phase::Asking(Ask::Stop { .. }) => self.phase = Phase::Halting { since: now },
            Phase::Asking(Ask::Release) => self.phase = Phase::Done,
            _ => {}
        }
    }

    fn refused(&mut self, robot: RobotId, of: Reference, reason: NackReason) -> Result<(), SessionError> {
        let what = match self.phase {
            Phase::Driving { .. } => "drive like this",
            // Of a drive that crossed the stop on the way there is nothing to say.
            Phase::Asking(_) if of != Reference::Command(CommandId(self.newest)) => return Ok(()),
            Phase::Asking(Ask::Stop { .. }) => "stop",
            Phase::Asking(Ask::Release) => "release its stop",
            Phase::Seeking | Phase::Listening | Phase::Halting { .. } | Phase::Done => return Ok(()),
        };
        Err(SessionError::Refused { robot, what, reason })
    }

    fn check_patience(&self, now: Millis) -> Result<(), SessionError> {
        if self.phase == Phase::Done {
            return Ok(());
        }
        if now.since(self.heard_at) > SILENCE {
            return Err(self.noise.map_or(SessionError::Silent, |error| SessionError::Unreadable { error }));
        }
        let Some(robot) = self.robot else { return Ok(()) };
        if self.unanswered_since.is_some_and(|since| now.since(since) > SILENCE) {
            return Err(SessionError::Unanswered { robot });
        }
        match self.phase {
            Phase::Halting { since } if now.since(since) > HALT => Err(SessionError::NotStopping { robot }),
            _ => Ok(()),
        }
    }

    fn speak(&mut self, now: Millis, send: &mut Vec<Message>) {
        if self.robot.is_some() && self.greeted_at.is_none() {
            self.greet(now, send);
        }
        if let Phase::Driving { until: Some(until) } = self.phase
            && now >= until
        {
            self.ask(Ask::Stop { emergency: false });
        }
        let message = match (self.phase, self.goal) {
            (Phase::Driving { .. }, Goal::Drive { twist, .. }) => {
                let deaf = now.since(self.heard_at) > limits::DRIVE_TTL;
                if deaf || !is_due(now, self.sent_at, DRIVE_INTERVAL) {
                    return;
                }
                self.newest = self.newest.saturating_add(1);
                Message::Drive(Drive { command: CommandId(self.newest), ttl: limits::DRIVE_TTL, twist })
            }
            (Phase::Asking(ask), _) if is_due(now, self.sent_at, REPEAT) => {
                let command = CommandId(self.newest);
                match ask {
                    Ask::Stop { emergency } => Message::Stop(Stop { command, emergency }),
                    Ask::Release => Message::Release(Release { command }),
                }
            }
            _ => return,
        };
        self.sent_at = Some(now);
        self.unanswered_since.get_or_insert(now);
        send.push(message);
    }
}

fn is_due(now: Millis, last: Option<Millis>, interval: DurationMs) -> bool {
    last.is_none_or(|last| now.since(last) >= interval)
}

/// What a session's commands are counted from. A chassis tells sessions apart by the second of their
/// start and takes no lower number than the last: one that begins later in the same second, as a
/// stop after a drive, has to count on. None sends 1000 commands in a millisecond.
fn first_number(wall_at_zero: SiteMillis) -> u32 {
    (wall_at_zero.0 % 1_000) as u32 * 1_000
}

#[cfg(test)]
#[path = "session_tests.rs"]
mod tests;
