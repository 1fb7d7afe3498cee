//! How a board becomes a pile: at a desk, on a cable, by somebody with a tool.
//!
//! A board that is nobody yet takes the first identity it is given. One that is somebody refuses
//! another unless its button is held, so that nobody can make it another pile over its link alone. A
//! repeat of what it was given is acknowledged again. [`RESTART_DELAY`] after an identity is stored the
//! board restarts as the pile it has become; until then repeats find it.

use firmware_common::greeting::Greeting;
use heapless::Vec;
use protocol::{
    Ack, DeviceId, DurationMs, Epoch, Frame, Message, Millis, Nack, NackReason, Provision, Reference,
};

use crate::lease::Answer;
use crate::store::{Identity, Record};

/// From the storing of an identity to the restart.
pub const RESTART_DELAY: DurationMs = DurationMs(2_000);

/// Who a board is, and whether it is to become another.
#[derive(Clone, Debug)]
pub struct Provisioning {
    identity: Option<Identity>,
    button_held: bool,
    unsaved: bool,
    provisioned_at: Option<Millis>,
}

impl Provisioning {
    /// A board that was provisioned as `identity` before its start.
    #[must_use]
    pub const fn new(identity: Option<Identity>) -> Self {
        Self { identity, button_held: false, unsaved: false, provisioned_at: None }
    }

    /// The button was pressed, or let go.
    pub const fn button(&mut self, held: bool) {
        self.button_held = held;
    }

    /// Takes an identity, or says why not. What is taken must be stored before the answer goes out.
    ///
    /// # Errors
    /// [`NackReason::Provisioned`]: the board is somebody else, and its button is not held.
    pub fn provision(&mut self, now: Millis, provision: &Provision) -> Answer {
        let identity = Identity::from(provision);
        // A tool that was not heard, or not at once, comes again with another count of starts.
        if self.identity.is_some_and(|ours| ours.is_same_device(&identity)) {
            return Ok(());
        }
        if self.identity.is_some() && !self.button_held {
            return Err(NackReason::Provisioned);
        }
        self.identity = Some(identity);
        self.unsaved = true;
        self.provisioned_at = Some(now);
        Ok(())
    }

    /// The identity to store now.
    pub const fn unsaved(&mut self) -> Option<Identity> {
        if core::mem::replace(&mut self.unsaved, false) { self.identity } else { None }
    }

    /// What was to be stored is not, or not all of it.
    pub const fn store_failed(&mut self) {
        self.unsaved = self.provisioned_at.is_some();
    }

    /// Whether the board has been given an identity in this start, and so is nobody for a moment.
    #[must_use]
    pub const fn is_over(&self) -> bool {
        self.provisioned_at.is_some()
    }

    /// Whether the board is to restart.
    #[must_use]
    pub fn restart_is_due(&self, now: Millis) -> bool {
        !self.unsaved && self.provisioned_at.is_some_and(|at| now.since(at) >= RESTART_DELAY)
    }
}

/// What a step of a [`Fresh`] board asks of the shell: the store first, then the messages.
#[derive(Clone, Debug, PartialEq)]
pub struct FreshOutputs {
    /// What must be in non-volatile memory before the messages go out.
    pub store: Option<Record>,
    /// What to send, in order: to whoever is on the link.
    pub messages: Vec<Message, 2>,
    /// Whether the board is to restart after that.
    pub restart: bool,
}

/// A board that is nobody yet. It has no contactor to close: it says who it is not, and waits to be
/// provisioned.
#[derive(Clone, Debug)]
pub struct Fresh {
    greeting: Greeting,
    provisioning: Provisioning,
}

#[expect(clippy::new_without_default, reason = "a board that is nobody is no usual board")]
impl Fresh {
    /// A board that has just started.
    #[must_use]
    pub const fn new() -> Self {
        Self { greeting: Greeting::new(), provisioning: Provisioning::new(None) }
    }

    /// Time has come to `now`, and a frame has arrived or none. At least every 100 ms.
    pub fn step(&mut self, now: Millis, frame: Option<&Frame>) -> FreshOutputs {
        let mut messages = Vec::new();
        if let Some(frame) = frame.filter(|frame| frame.header.sender == DeviceId::Service) {
            match &frame.message {
                Message::Hello(_) if self.greeting.greeted(now) => self.hello(now, &mut messages),
                Message::Provision(provision) => {
                    let answer = self.provisioning.provision(now, provision);
                    let of = Reference::Command(provision.command);
                    say(
                        &mut messages,
                        answer.map_or_else(
                            |reason| Message::Nack(Nack { of, reason }),
                            |()| Message::Ack(Ack { of }),
                        ),
                    );
                }
                _ => {}
            }
        }
        if self.greeting.is_due(now) {
            self.hello(now, &mut messages);
        }
        FreshOutputs {
            store: self.provisioning.unsaved().map(Record::Identity),
            messages,
            restart: self.provisioning.restart_is_due(now),
        }
    }

    /// What the last step asked to store is not stored; its messages did not go out. It will be asked
    /// for again with the next repeat of the command.
    pub const fn store_failed(&mut self) {
        self.provisioning = Provisioning::new(None);
    }

    fn hello(&mut self, now: Millis, messages: &mut Vec<Message, 2>) {
        say(messages, Message::Hello(self.greeting.hello(now, Epoch(0))));
    }
}

/// It fits: a step answers one frame, and says Hello once.
fn say(messages: &mut Vec<Message, 2>, message: Message) {
    let _ = messages.push(message);
}

#[cfg(test)]
mod tests {
    use protocol::{
        BootEpoch, CommandId, CurrentA, Header, Key, PileId, PileParameters, PowerW, RobotId, Sequence,
        TemperatureC, VoltageV,
    };

    use super::*;

    fn provision(command: u32, pile: u16) -> Provision {
        Provision {
            command: CommandId(command),
            pile: PileId(pile),
            device_key: Key::new([1; 32]),
            site_key: Key::new([2; 32]),
            boot_floor: BootEpoch(1),
            parameters: PileParameters {
                power: PowerW::new(500.0).unwrap(),
                eta: DurationMs(5_000),
                voltage_max: VoltageV::new(30.0).unwrap(),
                current_max: CurrentA::new(20.0).unwrap(),
                derate_from: TemperatureC::new(60.0).unwrap(),
                stop_at: TemperatureC::new(80.0).unwrap(),
                dock_enter_dbm: -60,
                dock_leave_dbm: -66,
            },
        }
    }

    fn tell(board: &mut Fresh, now: u64, sender: DeviceId, message: Message) -> FreshOutputs {
        let header = Header::new(sender, BootEpoch(1), Sequence(0));
        board.step(Millis(now), Some(&Frame { header, message }))
    }

    fn give(board: &mut Fresh, now: u64, provision: Provision) -> FreshOutputs {
        tell(board, now, DeviceId::Service, Message::Provision(provision))
    }

    fn ack(command: u32) -> Message {
        Message::Ack(Ack { of: Reference::Command(CommandId(command)) })
    }

    #[test]
    fn a_fresh_board_says_hello_until_it_is_answered() {
        let mut board = Fresh::new();
        let hellos = (0..30).map(|tick| board.step(Millis(tick * 100), None).messages.len());
        assert_eq!(hellos.sum::<usize>(), 3);
    }

    #[test]
    fn a_fresh_board_stores_its_identity_acknowledges_every_repeat_and_restarts() {
        let mut board = Fresh::new();
        board.step(Millis(0), None);
        let outputs = give(&mut board, 100, provision(1, 7));
        assert_eq!(outputs.store, Some(Record::Identity(Identity::from(&provision(1, 7)))));
        assert_eq!(outputs.messages.as_slice(), [ack(1)]);
        let outputs = give(&mut board, 900, provision(2, 7));
        assert_eq!(
            (outputs.store, outputs.messages.as_slice(), outputs.restart),
            (None, &[ack(2)][..], false)
        );
        assert!(!board.step(Millis(2_099), None).restart);
        assert!(board.step(Millis(2_100), None).restart);
    }

    #[test]
    fn an_identity_that_was_not_stored_was_not_taken() {
        let mut board = Fresh::new();
        board.step(Millis(0), None);
        give(&mut board, 100, provision(1, 7));
        board.store_failed();
        assert!(!board.step(Millis(9_000), None).restart);
        assert!(give(&mut board, 9_100, provision(1, 7)).store.is_some());
    }

    #[test]
    fn only_a_tool_provisions() {
        let mut board = Fresh::new();
        for sender in [DeviceId::Coordinator, DeviceId::Pile(PileId(1)), DeviceId::Robot(RobotId(1))] {
            let outputs = tell(&mut board, 0, sender, Message::Provision(provision(1, 7)));
            assert_eq!(outputs.store, None);
        }
    }

    #[test]
    fn a_board_that_is_somebody_becomes_another_only_while_its_button_is_held() {
        let mut board = Provisioning::new(Some(Identity::from(&provision(1, 7))));
        assert_eq!(board.provision(Millis(0), &provision(9, 7)), Ok(()), "it is that already");
        let later = Provision { boot_floor: BootEpoch(99), ..provision(10, 7) };
        assert_eq!(board.provision(Millis(0), &later), Ok(()), "and still is in another run of the tool");
        assert_eq!(board.unsaved(), None);
        assert_eq!(board.provision(Millis(0), &provision(2, 8)), Err(NackReason::Provisioned));
        board.button(true);
        assert_eq!(board.provision(Millis(0), &provision(2, 8)), Ok(()));
        assert_eq!(board.unsaved().map(|identity| identity.pile), Some(PileId(8)));
        board.button(false);
        assert_eq!(board.provision(Millis(0), &provision(3, 7)), Err(NackReason::Provisioned));
    }
}
