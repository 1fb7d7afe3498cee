//! What a person's tool says to a pile, and when. Pure: time and one input go in, messages come
//! out.
//!
//! The tool calls all piles whose keys it has until one is heard, then that one until it answers, and
//! asks one thing after the other, each again until it is answered in full. With each repeat it says
//! Hello too: a pile that has restarted understands nothing else.

use std::{collections::VecDeque, mem};

use protocol::{
    Ack, ClearFault, CommandId, DeviceId, DurationMs, Epoch, FaultCode, Frame, FrameError, Hello, Message,
    Millis, Nack, PileId, PileRow, Query, Reference, Topic, limits, version,
};

use super::{answers::Answers, error::DeskError};

/// What has no answer is said again after this time.
const REPEAT: DurationMs = DurationMs(500);
/// A pile is not silent for longer, whoever it speaks with; and no question stays unanswered.
pub const PATIENCE: DurationMs = DurationMs(5_000);
/// A pile that is watched is asked this often.
const WATCH_INTERVAL: DurationMs = DurationMs(500);

/// What a session is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Goal {
    /// What the pile does and measures, what is wrong with it, how it charges.
    Status,
    /// What is wrong with it.
    Faults,
    /// What it has counted and not handed on.
    Passes,
    /// What it knows of all piles.
    Table,
    /// What it does and measures and what is wrong with it, until interrupted.
    Watch,
    /// Clear a fault, and see what is wrong then.
    Clear(FaultCode),
}

impl Goal {
    fn asks(self) -> VecDeque<Ask> {
        let query = |topics: &[Topic]| topics.iter().copied().map(Ask::Query).collect();
        match self {
            Self::Status => query(&[Topic::State, Topic::Faults, Topic::Parameters]),
            Self::Faults => query(&[Topic::Faults]),
            Self::Passes => query(&[Topic::Passes]),
            Self::Table => query(&[Topic::Table]),
            Self::Watch => query(&[Topic::State, Topic::Faults]),
            Self::Clear(code) => [Ask::Clear(code), Ask::Query(Topic::Faults)].into(),
        }
    }
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
    /// A frame that is to be believed.
    Frame(Frame),
    /// Something arrived that is none.
    Discarded(FrameError),
    /// The person wants it to end.
    Interrupt,
}

/// What a step asks of the shell.
#[derive(Clone, Debug, Default)]
pub struct Outputs {
    /// What to send, and to which pile.
    pub send: Vec<(PileId, Message)>,
    /// All that was asked has been answered.
    pub answered: Option<Answers>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// Nothing of a pile was heard.
    Seeking,
    /// Hello was not answered.
    Greeting,
    Asking,
    /// Until the next look.
    Resting {
        until: Millis,
    },
    Done,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ask {
    Query(Topic),
    Clear(FaultCode),
}

/// A conversation with a pile.
#[derive(Clone, Debug)]
pub struct Session {
    goal: Goal,
    command: CommandId,
    called: Vec<PileId>,
    phase: Phase,
    pile: Option<PileId>,
    /// Since when the pile owes an answer.
    waiting_since: Millis,
    said_at: Option<Millis>,
    /// The last that could not be read.
    noise: Option<FrameError>,
    /// It speaks, but not so that it can be believed.
    unauthentic: bool,
    asks: VecDeque<Ask>,
    answers: Answers,
    rows: Rows,
}

impl Session {
    /// A session that starts at `Millis(0)` and calls these piles. Its commands are numbered
    /// `command`, which differs from session to session.
    #[must_use]
    pub fn new(goal: Goal, command: CommandId, called: Vec<PileId>) -> Self {
        Self {
            goal,
            command,
            called,
            phase: Phase::Seeking,
            pile: None,
            waiting_since: Millis(0),
            said_at: None,
            noise: None,
            unauthentic: false,
            asks: goal.asks(),
            answers: Answers::default(),
            rows: Rows::default(),
        }
    }

    /// Takes one input.
    ///
    /// # Errors
    /// [`DeskError`] ends the session.
    pub fn step(&mut self, now: Millis, input: Input) -> Result<Outputs, DeskError> {
        let answered = match input {
            Input::Tick => None,
            Input::Interrupt => {
                self.phase = Phase::Done;
                None
            }
            Input::Discarded(error) => {
                self.discard(now, error)?;
                None
            }
            Input::Frame(frame) => self.hear(now, frame)?,
        };
        self.check_patience(now)?;
        Ok(Outputs { send: self.speak(now), answered })
    }

    /// Whether the goal is reached, or the person has ended it.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.phase == Phase::Done
    }

    fn discard(&mut self, now: Millis, error: FrameError) -> Result<(), DeskError> {
        match error {
            FrameError::Unauthentic { sender }
            | FrameError::Unsealed { sender }
            | FrameError::Sealed { sender }
            | FrameError::Stranger { sender } => {
                let Some(pile) = self.meet(now, sender)? else { return Ok(()) };
                // Also what is meant for another, such as the coordinator, does not authenticate here.
                self.unauthentic = true;
                DeskError::of_keys(pile, error).map_or(Ok(()), Err)?;
            }
            FrameError::Replayed { .. } | FrameError::NotGossip { .. } => {}
            // One part of an answer may be lost.
            _ => {
                self.noise = Some(error);
                self.rows = Rows::default();
            }
        }
        Ok(())
    }

    /// Somebody was heard: the pile of this session, if this is the number.
    fn meet(&mut self, now: Millis, sender: DeviceId) -> Result<Option<PileId>, DeskError> {
        match (self.pile, sender) {
            (None, DeviceId::Pile(pile)) => {
                self.pile = Some(pile);
                self.enter(now, Phase::Greeting);
                Ok(Some(pile))
            }
            // Ours, from a line that echoes.
            (None, DeviceId::Service) => Ok(None),
            (None, sender) => Err(DeskError::of_stranger(sender)),
            (Some(pile), sender) => Ok((sender == DeviceId::Pile(pile)).then_some(pile)),
        }
    }

    fn hear(&mut self, now: Millis, frame: Frame) -> Result<Option<Answers>, DeskError> {
        let Some(pile) = self.meet(now, frame.header.sender)? else { return Ok(None) };
        if let Message::Hello(hello) = &frame.message {
            let theirs = version::Range { min: hello.min, current: hello.current };
            version::negotiate(version::OURS, theirs)?;
            if self.phase == Phase::Greeting {
                self.enter(now, Phase::Asking);
            }
        }
        if self.phase != Phase::Asking || !self.take(pile, frame.message)? {
            return Ok(None);
        }
        self.asks.pop_front();
        self.enter(now, Phase::Asking);
        if !self.asks.is_empty() {
            return Ok(None);
        }
        if self.goal == Goal::Watch {
            self.asks = self.goal.asks();
            self.enter(now, Phase::Resting { until: now.after(WATCH_INTERVAL) });
        } else {
            self.phase = Phase::Done;
        }
        Ok(Some(Answers { pile: Some(pile), ..mem::take(&mut self.answers) }))
    }

    /// Keeps what `message` answers. Whether the question is answered in full by it.
    fn take(&mut self, pile: PileId, message: Message) -> Result<bool, DeskError> {
        let Some(&ask) = self.asks.front() else { return Ok(false) };
        let answers = &mut self.answers;
        match (ask, message) {
            (Ask::Query(Topic::State), Message::PileState(state)) => answers.state = Some(state),
            (Ask::Query(Topic::State), Message::PileReadings(readings)) => answers.readings = Some(readings),
            (Ask::Query(Topic::Faults), Message::PileFaults(faults)) => {
                answers.faults = Some(faults.faults.to_vec());
            }
            (Ask::Query(Topic::Passes), Message::PendingPasses(pending)) => {
                answers.passes = Some(pending.passes.to_vec());
            }
            (Ask::Query(Topic::Table), Message::PileTable(part)) => {
                answers.table = self.rows.take(pile, &part.rows)
            }
            (Ask::Query(Topic::Parameters), Message::PileParameters(parameters)) => {
                answers.parameters = Some(parameters);
            }
            (Ask::Clear(code), Message::Ack(Ack { of })) if of == Reference::Command(self.command) => {
                answers.cleared = Some(code);
            }
            (Ask::Clear(code), Message::Nack(Nack { of, reason }))
                if of == Reference::Command(self.command) =>
            {
                return Err(DeskError::Refused { pile, code, reason });
            }
            _ => return Ok(false),
        }
        Ok(match ask {
            Ask::Query(Topic::State) => answers.state.is_some() && answers.readings.is_some(),
            Ask::Query(Topic::Table) => answers.table.is_some(),
            _ => true,
        })
    }

    fn enter(&mut self, now: Millis, phase: Phase) {
        (self.phase, self.waiting_since, self.said_at) = (phase, now, None);
    }

    fn check_patience(&self, now: Millis) -> Result<(), DeskError> {
        if now.since(self.waiting_since) <= PATIENCE {
            return Ok(());
        }
        match (self.phase, self.pile) {
            (Phase::Seeking, _) => {
                Err(self.noise.map_or(DeskError::Silent, |error| DeskError::Unreadable { error }))
            }
            (Phase::Greeting, Some(pile)) if self.unauthentic => Err(DeskError::NotAuthentic { pile }),
            (Phase::Greeting | Phase::Asking, Some(pile)) => Err(DeskError::Unanswered { pile }),
            _ => Ok(()),
        }
    }

    fn speak(&mut self, now: Millis) -> Vec<(PileId, Message)> {
        if let Phase::Resting { until } = self.phase
            && now >= until
        {
            self.enter(now, Phase::Asking);
        }
        if self.said_at.is_some_and(|said_at| now.since(said_at) < REPEAT) {
            return Vec::new();
        }
        let is_repeat = self.said_at.replace(now).is_some();
        let hello = |pile| (pile, Message::Hello(Hello::new(Epoch(0))));
        let Some(pile) = self.pile else { return self.called.iter().copied().map(hello).collect() };
        let ask = match (self.phase, self.asks.front()) {
            (Phase::Greeting, _) => return vec![hello(pile)],
            (Phase::Asking, Some(Ask::Query(topic))) => Message::Query(Query { topic: *topic }),
            (Phase::Asking, Some(Ask::Clear(code))) => {
                Message::ClearFault(ClearFault { command: self.command, code: *code })
            }
            _ => return Vec::new(),
        };
        [(pile, ask)].into_iter().chain(is_repeat.then(|| hello(pile))).collect()
    }
}

/// The rows of an answer in parts. Gossip comes on the same line: it is told apart by the pile's own
/// row, which an answer begins with and gossip ends with.
#[derive(Clone, Debug, Default)]
struct Rows(Option<Vec<PileRow>>);

impl Rows {
    /// Takes a part. The whole table, if this was the last part of it.
    fn take(&mut self, own: PileId, part: &[PileRow]) -> Option<Vec<PileRow>> {
        let is_own = |row: Option<&PileRow>| row.is_some_and(|row| row.pile == own);
        if is_own(part.first()) {
            self.0 = Some(Vec::new());
        } else if is_own(part.last()) {
            return None;
        }
        // A part whose first one was lost belongs to an answer that is asked for again.
        let rows = self.0.as_mut()?;
        rows.extend_from_slice(part);
        if part.len() < limits::ROWS_PER_TABLE { self.0.take() } else { None }
    }
}

#[cfg(test)]
#[path = "session_tests.rs"]
mod tests;
