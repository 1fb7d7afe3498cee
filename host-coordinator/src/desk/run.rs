//! The shell around a [`Session`]: moves bytes and time between it and a pile's line, and seals and
//! opens them.

use std::io;

use protocol::{BootEpoch, Deframer, DeviceId, Message, Recipient, SealError, Sessions, Trust};

use super::{
    answers::Answers,
    error::DeskError,
    session::{Input, Outputs, Session},
};
use crate::line::{Event, Line, Wire};

/// Why a conversation ended before its goal.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// See there.
    #[error(transparent)]
    Desk(#[from] DeskError),
    /// The other side is gone.
    #[error("the line to the pile was lost ({0}); check it and try again")]
    Lost(#[from] io::Error),
    /// What was heard could not be printed.
    #[error(transparent)]
    Hearing(Box<dyn std::error::Error + Send + Sync>),
}

/// Who gets the answers, each time that all questions are answered.
pub type Hear<'a> = dyn FnMut(&Answers) -> Result<(), Box<dyn std::error::Error + Send + Sync>> + 'a;

/// Runs `session` to its end. `boot` tells this tool's start: it grows with time, a pile takes a
/// Hello only of a later start than that of the last it took, and so each Hello is said as of then.
/// `interrupt` ends when the person wants it to end.
///
/// # Errors
/// [`RunError`].
pub async fn run(
    line: &mut dyn Line,
    session: &mut Session,
    boot: impl Fn() -> BootEpoch,
    trust: Trust<Vec<protocol::Session>>,
    interrupt: impl Future<Output = ()>,
    hear: &mut Hear<'_>,
) -> Result<(), RunError> {
    let mut begun = boot();
    let mut sessions = Sessions::new(DeviceId::Service, begun, trust.clone());
    let mut deframer = Deframer::new();
    let mut wire = Wire::new(line, interrupt);
    let mut inputs = Vec::new();

    while !session.is_done() {
        match wire.next().await? {
            Event::Tick => inputs.push(Input::Tick),
            Event::Interrupt => inputs.push(Input::Interrupt),
            Event::Bytes(bytes) => deframer.feed(bytes, |found| {
                let found = found.and_then(|packet| sessions.open(packet));
                inputs.push(found.map_or_else(Input::Discarded, Input::Frame));
            }),
        }
        for input in inputs.drain(..) {
            if session.is_done() {
                break;
            }
            let Outputs { send, answered } = session.step(wire.now(), input)?;
            if let Some(answers) = &answered {
                hear(answers).map_err(RunError::Hearing)?;
            }
            for (pile, message) in send {
                if matches!(message, Message::Hello(_)) && boot() != begun {
                    begun = boot();
                    sessions = Sessions::new(DeviceId::Service, begun, trust.clone());
                }
                match sessions.seal(Recipient::Device(DeviceId::Pile(pile)), &message) {
                    Ok(bytes) => wire.write(&bytes).await?,
                    // It is asked again when it has said Hello.
                    Err(SealError::Unheard { .. }) => {}
                    Err(error) => return Err(io::Error::other(error).into()),
                }
            }
        }
    }
    Ok(())
}
