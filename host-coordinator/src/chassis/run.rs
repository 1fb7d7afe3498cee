//! The shell around a [`Session`]: moves bytes and time between it and a chassis' line.

use std::io;

use protocol::{BootEpoch, Deframer, DeviceId, DurationMs, Recipient, Sessions, limits};

use super::{
    outcome::SessionError,
    session::{Heard, Input, Outputs, Session},
};
use crate::line::{Event, Line, Wire};

/// Why a conversation ended before its goal.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// See there.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// The other side is gone.
    #[error("the line to the chassis was lost ({error}){}", aftermath(*.moving))]
    Lost {
        /// Why.
        error: io::Error,
        /// Whether the chassis was in motion.
        moving: bool,
    },
    /// What was heard could not be printed or recorded.
    #[error(transparent)]
    Hearing(Box<dyn std::error::Error + Send + Sync>),
}

/// Who listens to the reports of a chassis: it gets the session and the report.
pub type Hear<'a> = dyn FnMut(&Session, &Heard) -> Result<(), Box<dyn std::error::Error + Send + Sync>> + 'a;

/// Runs `session` to its end. `boot` tells this run from the last; `interrupt` ends when the person
/// wants it to end.
///
/// # Errors
/// [`RunError`]; a chassis in motion then stops by itself.
pub async fn run(
    line: &mut dyn Line,
    session: &mut Session,
    boot: BootEpoch,
    interrupt: impl Future<Output = ()>,
    hear: &mut Hear<'_>,
) -> Result<(), RunError> {
    // The line to a chassis is one inside the robot: it has no keys. Who this side speaks as turns out
    // when the chassis is heard.
    let mut hearing = Sessions::insecure(DeviceId::Coordinator, boot);
    let mut speaking = None;
    let mut deframer = Deframer::new();
    let mut wire = Wire::new(line, interrupt);
    let mut inputs = Vec::new();

    while !session.is_done() {
        match wire.next().await.map_err(|error| lost(session, error))? {
            Event::Tick => inputs.push(Input::Tick),
            Event::Interrupt => inputs.push(Input::Interrupt),
            Event::Bytes(bytes) => deframer.feed(bytes, |found| {
                let found = found.and_then(|packet| hearing.open(packet));
                inputs.push(found.map_or_else(Input::Discarded, Input::Frame));
            }),
        }
        for input in inputs.drain(..) {
            let Outputs { send, heard } = session.step(wire.now(), input)?;
            if let Some(heard) = &heard {
                hear(session, heard).map_err(RunError::Hearing)?;
            }
            let Some(robot) = session.robot() else { continue };
            let speaking = speaking.get_or_insert_with(|| Sessions::insecure(DeviceId::Robot(robot), boot));
            for message in send {
                let chassis = Recipient::Device(DeviceId::Chassis(robot));
                let bytes = speaking
                    .seal(chassis, &message)
                    .map_err(|error| lost(session, io::Error::other(error)))?;
                wire.write(&bytes).await.map_err(|error| lost(session, error))?;
            }
        }
    }
    Ok(())
}

fn lost(session: &Session, error: io::Error) -> RunError {
    RunError::Lost { error, moving: session.is_moving() }
}

fn aftermath(moving: bool) -> String {
    const TTL: DurationMs = limits::DRIVE_TTL;
    if moving {
        format!(
            " while it was driving: it ramps to a stop by itself within {TTL} ms; check the line, then `watch` it"
        )
    } else {
        "; check it and try again".into()
    }
}
