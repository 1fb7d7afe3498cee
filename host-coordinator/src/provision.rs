//! Makes a board a pile: its identity, its key and the site's, its parameters. Pure: time and one
//! input go in, a message comes out. [`run`] moves bytes between it and the board's line.
//!
//! The board is asked who it is, then told again and again what it is to be, under one number, until
//! it answers: a lost answer costs a repeat. The keys are in the site's file before they are sent, and
//! a pile that has a key there keeps it, so that an attempt that was cut short can be made again and
//! gives the board the same. What is said here is not sealed: it belongs on a cable, at a desk.

use std::{error::Error, io};

use protocol::{
    BootEpoch, CommandId, CurrentA, Deframer, DeviceId, Epoch, FrameError, Hello, Message, Millis,
    NackReason, PileId, PileParameters, PowerW, Provision, Recipient, Reference, Sessions, TemperatureC,
    VoltageV, limits,
};

use crate::line::{Event, Line, Wire};

/// What a pile's USART is set to.
pub const BAUD: u32 = 115_200;
/// A board that says nothing for this long is none, and one that does not answer for this long will not.
const PATIENCE_MS: u64 = 10_000;

/// What is heard of the board.
#[derive(Clone, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "an input lives for one step, and a box would be one more allocation"
)]
pub enum Heard {
    /// What it says, without a seal.
    Plain(DeviceId, Message),
    /// It has a key: it is this pile, or says so.
    Sealed(DeviceId),
    /// What cannot be read.
    Discarded(FrameError),
}

/// Why a board was not provisioned.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ProvisionError {
    /// Nothing is heard.
    #[error(
        "nothing is heard from the board; is it on, is this its link (USART1), and at {BAUD} baud if serial?"
    )]
    Silent,
    /// What is heard makes no sense.
    #[error("what arrives cannot be read ({error}); is this a pile's link, at {BAUD} baud if it is serial?")]
    Unreadable {
        /// What was wrong with it.
        error: FrameError,
    },
    /// It says who it is and does not answer.
    #[error("{board} does not answer; the key is kept: try again, and the board gets the same")]
    Unanswered {
        /// Who it says it is.
        board: DeviceId,
    },
    /// It is another kind of device.
    #[error("this is {device}: only a pile's board is provisioned")]
    WrongDevice {
        /// Who it says it is.
        device: DeviceId,
    },
    /// It has an identity.
    #[error(
        "the board is {board} already and keeps its key; to make it pile {wanted} with a new one, hold its \
         button while this runs"
    )]
    Refused {
        /// Who it is.
        board: DeviceId,
        /// Who it was to be.
        wanted: PileId,
    },
    /// It refuses for another reason.
    #[error("the board refuses: {reason:?}; what it is told is out of its range, or its store has failed")]
    Rejected {
        /// The reason.
        reason: NackReason,
    },
    /// The person has had enough.
    #[error("interrupted; the key is kept: try again, and the board gets the same")]
    Interrupted,
}

/// A conversation with a board that is to become a pile.
#[derive(Clone, Debug)]
pub struct Provisioning {
    provision: Provision,
    board: Option<DeviceId>,
    noise: Option<FrameError>,
    heard_at: Millis,
    said_at: Option<Millis>,
    done: bool,
}

impl Provisioning {
    /// A conversation that begins at `Millis(0)`.
    #[must_use]
    pub const fn new(provision: Provision) -> Self {
        Self { provision, board: None, noise: None, heard_at: Millis(0), said_at: None, done: false }
    }

    /// Takes what was heard, if anything; answers what is to be said.
    ///
    /// # Errors
    /// [`ProvisionError`] ends it.
    pub fn step(&mut self, now: Millis, heard: Option<Heard>) -> Result<Option<Message>, ProvisionError> {
        match heard {
            Some(Heard::Plain(sender, message)) => self.hear(now, sender, &message)?,
            Some(Heard::Sealed(sender)) => self.meet(now, sender)?,
            Some(Heard::Discarded(error)) => self.noise = Some(error),
            None => {}
        }
        if self.done {
            return Ok(None);
        }
        if now.0.saturating_sub(self.heard_at.0) > PATIENCE_MS {
            return Err(match (self.board, self.noise) {
                (Some(board), _) => ProvisionError::Unanswered { board },
                (None, Some(error)) => ProvisionError::Unreadable { error },
                (None, None) => ProvisionError::Silent,
            });
        }
        if self.said_at.is_some_and(|at| now.since(at) < limits::REPEAT_INTERVAL) {
            return Ok(None);
        }
        self.said_at = Some(now);
        Ok(Some(match self.board {
            Some(_) => Message::Provision(self.provision),
            None => Message::Hello(Hello::new(Epoch(0))),
        }))
    }

    /// Whether the board has taken it.
    #[must_use]
    pub const fn is_done(&self) -> bool {
        self.done
    }

    fn hear(&mut self, now: Millis, sender: DeviceId, message: &Message) -> Result<(), ProvisionError> {
        self.meet(now, sender)?;
        let ours = Reference::Command(self.provision.command);
        match message {
            Message::Ack(ack) if ack.of == ours => self.done = true,
            Message::Nack(nack) if nack.of == ours => {
                let wanted = self.provision.pile;
                return Err(match (nack.reason, self.board) {
                    (NackReason::Provisioned, Some(board)) => ProvisionError::Refused { board, wanted },
                    (reason, _) => ProvisionError::Rejected { reason },
                });
            }
            _ => {}
        }
        Ok(())
    }

    /// The board says who it is. It is given its time to answer from then on.
    fn meet(&mut self, now: Millis, sender: DeviceId) -> Result<(), ProvisionError> {
        match sender {
            // Ours, on a line that echoes.
            DeviceId::Service => return Ok(()),
            DeviceId::Factory | DeviceId::Pile(_) => {}
            device => return Err(ProvisionError::WrongDevice { device }),
        }
        if self.board.is_none() {
            (self.heard_at, self.said_at) = (now, None);
        }
        // Once it has taken its identity it speaks as the pile that it is.
        self.board = Some(sender);
        Ok(())
    }
}

/// The parameters of a pile that gives `power_w`: those that every pile has from the start.
#[must_use]
pub fn parameters(power_w: f32) -> PileParameters {
    let usual = firmware_pile::Parameters::new(PileId(0), power_w);
    PileParameters {
        power: PowerW::clamped(power_w),
        eta: usual.eta,
        voltage_max: VoltageV::clamped(usual.limits.voltage_max_v),
        current_max: CurrentA::clamped(usual.limits.current_max_a),
        derate_from: TemperatureC::clamped(usual.limits.derate_from_c),
        stop_at: TemperatureC::clamped(usual.limits.stop_at_c),
        dock_enter_dbm: usual.docked.enter_dbm,
        dock_leave_dbm: usual.docked.leave_dbm,
    }
}

/// Provisions the board at the end of `line`. `boot` is the time in seconds since 1970; `interrupt` ends
/// when the person wants it to end.
///
/// # Errors
/// [`ProvisionError`], or the line is lost.
pub async fn run(
    line: &mut dyn Line,
    provision: Provision,
    boot: BootEpoch,
    interrupt: impl Future<Output = ()>,
) -> Result<(), Box<dyn Error>> {
    let mut sessions = Sessions::insecure(DeviceId::Service, boot);
    let mut provisioning = Provisioning::new(provision);
    let mut deframer = Deframer::new();
    let mut wire = Wire::new(line, interrupt);
    while !provisioning.is_done() {
        let now = wire.now();
        let mut heard = Vec::new();
        match wire.next().await.map_err(lost)? {
            Event::Tick => {}
            Event::Interrupt => return Err(ProvisionError::Interrupted.into()),
            Event::Bytes(bytes) => deframer.feed(bytes, |found| {
                heard.push(match found.and_then(|packet| sessions.open(packet)) {
                    Ok(frame) => Heard::Plain(frame.header.sender, frame.message),
                    Err(FrameError::Sealed { sender }) => Heard::Sealed(sender),
                    Err(error) => Heard::Discarded(error),
                });
            }),
        }
        for heard in heard.into_iter().map(Some).chain([None]) {
            if let Some(message) = provisioning.step(now, heard)? {
                // A factory-fresh board has no name yet; without a seal the name is not in the frame.
                let bytes = sessions.seal(Recipient::Device(DeviceId::Factory), &message)?;
                wire.write(&bytes).await.map_err(lost)?;
            }
        }
    }
    Ok(())
}

fn lost(error: io::Error) -> String {
    format!(
        "the line to the board was lost ({error}); the key is kept: try again, and the board gets the same"
    )
}

/// A number for one run's command: no two runs within a few seconds have the same.
#[must_use]
pub const fn command_of(boot: BootEpoch) -> CommandId {
    CommandId(boot.0)
}

#[cfg(test)]
mod tests {
    use protocol::{Ack, Key, Nack, RobotId};

    use super::*;

    const COMMAND: CommandId = CommandId(5);

    fn new() -> Provisioning {
        Provisioning::new(Provision {
            command: COMMAND,
            pile: PileId(7),
            device_key: Key::new([1; 32]),
            site_key: Key::new([2; 32]),
            boot_floor: BootEpoch(9),
            parameters: parameters(500.0),
        })
    }

    fn hello(sender: DeviceId) -> Option<Heard> {
        Some(Heard::Plain(sender, Message::Hello(Hello::new(Epoch(0)))))
    }

    /// Steps every 100 ms until something else than a message comes out.
    fn ends(provisioning: &mut Provisioning, from: u64) -> (u64, ProvisionError) {
        (from..)
            .step_by(100)
            .find_map(|ms| provisioning.step(Millis(ms), None).err().map(|error| (ms, error)))
            .expect("it goes on for ever")
    }

    #[test]
    fn nothing_but_hello_is_said_before_a_board_was_heard() {
        let mut provisioning = new();
        for ms in (0..PATIENCE_MS).step_by(50) {
            let said = provisioning.step(Millis(ms), None).unwrap();
            assert!(matches!(said, None | Some(Message::Hello(_))), "a key was sent to nobody: {said:?}");
        }
        assert_eq!(ends(&mut provisioning, PATIENCE_MS).1, ProvisionError::Silent);
    }

    #[test]
    fn noise_alone_is_told_as_noise() {
        let mut provisioning = new();
        provisioning.step(Millis(1), Some(Heard::Discarded(FrameError::Crc))).unwrap();
        assert_eq!(ends(&mut provisioning, 2).1, ProvisionError::Unreadable { error: FrameError::Crc });
    }

    #[test]
    fn it_is_said_at_once_when_the_board_is_heard_and_once_in_an_interval_then() {
        let mut provisioning = new();
        provisioning.step(Millis(0), None).unwrap();
        let said: Vec<u64> = (100..4_100)
            .step_by(100)
            .filter(|&ms| {
                let said = provisioning.step(Millis(ms), hello(DeviceId::Factory)).unwrap();
                matches!(said, Some(Message::Provision(_)))
            })
            .collect();
        assert_eq!(said, [100, 1_100, 2_100, 3_100]);
        let (at, error) = ends(&mut provisioning, 4_100);
        assert_eq!(error, ProvisionError::Unanswered { board: DeviceId::Factory });
        assert!(
            at <= 100 + PATIENCE_MS + 100,
            "a board that says Hello for ever is waited for until {at} ms"
        );
    }

    #[test]
    fn only_the_answer_to_this_command_counts() {
        let mut provisioning = new();
        provisioning.step(Millis(0), hello(DeviceId::Factory)).unwrap();
        let answer = |command| Message::Ack(Ack { of: Reference::Command(command) });
        provisioning.step(Millis(1), Some(Heard::Plain(DeviceId::Factory, answer(CommandId(4))))).unwrap();
        assert!(!provisioning.is_done());
        provisioning.step(Millis(2), Some(Heard::Plain(DeviceId::Pile(PileId(7)), answer(COMMAND)))).unwrap();
        assert!(provisioning.is_done());
        assert_eq!(provisioning.step(Millis(60_000), None), Ok(None));
    }

    #[test]
    fn a_board_that_is_a_pile_is_asked_too_as_its_button_may_be_held() {
        let mut provisioning = new();
        let pile = DeviceId::Pile(PileId(3));
        let said = provisioning.step(Millis(0), Some(Heard::Sealed(pile))).unwrap();
        assert!(matches!(said, Some(Message::Provision(_))), "{said:?}");
        let of = Reference::Command(COMMAND);
        let refusal = Message::Nack(Nack { of, reason: NackReason::Provisioned });
        let error = provisioning.step(Millis(1), Some(Heard::Plain(pile, refusal))).unwrap_err();
        assert_eq!(error, ProvisionError::Refused { board: pile, wanted: PileId(7) });
    }

    #[test]
    fn no_key_is_sent_to_another_kind_of_device() {
        let device = DeviceId::Chassis(RobotId(1));
        for heard in [hello(device), Some(Heard::Sealed(device))] {
            let error = new().step(Millis(0), heard).unwrap_err();
            assert_eq!(error, ProvisionError::WrongDevice { device });
        }
    }
}
