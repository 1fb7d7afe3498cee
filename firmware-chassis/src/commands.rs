//! Which commands are new, repeated or late.
//!
//! Numbers grow within a start of the sender. The newest number again is a repeat: it gets the same
//! answer and does nothing. A lower one comes too late. Another start of the sender begins anew.

use protocol::{BootEpoch, CommandId, NackReason};

/// What a command is answered with.
pub type Answer = Result<(), NackReason>;

/// The newest command and its answer.
#[derive(Clone, Debug, Default)]
pub struct Commands {
    newest: Option<(BootEpoch, CommandId, Answer)>,
}

impl Commands {
    /// No command came yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { newest: None }
    }

    /// The answer to a command that is not new.
    #[must_use]
    pub fn answered(&self, boot: BootEpoch, command: CommandId) -> Option<Answer> {
        let (_, newest, answer) = self.newest.filter(|(known, ..)| *known == boot)?;
        match command.cmp(&newest) {
            core::cmp::Ordering::Greater => None,
            core::cmp::Ordering::Equal => Some(answer),
            core::cmp::Ordering::Less => Some(Err(NackReason::TooLate)),
        }
    }

    /// Remembers the answer to a new command.
    pub fn remember(&mut self, boot: BootEpoch, command: CommandId, answer: Answer) {
        self.newest = Some((boot, command, answer));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_repeat_gets_its_answer_a_late_one_is_refused_and_a_new_start_begins_anew() {
        let mut commands = Commands::new();
        assert_eq!(commands.answered(BootEpoch(1), CommandId(5)), None);
        commands.remember(BootEpoch(1), CommandId(5), Ok(()));
        assert_eq!(commands.answered(BootEpoch(1), CommandId(5)), Some(Ok(())));
        assert_eq!(commands.answered(BootEpoch(1), CommandId(4)), Some(Err(NackReason::TooLate)));
        assert_eq!(commands.answered(BootEpoch(1), CommandId(6)), None);
        assert_eq!(commands.answered(BootEpoch(2), CommandId(1)), None);
    }
}
