//! How a session with a chassis ends: its report, or why it failed.

use protocol::{
    ChassisMode, DeviceId, FrameError, NackReason, Odometry, RobotId, StopReason, Twist, version,
};
use serde::Serialize;

use super::words;

/// Why a session has failed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SessionError {
    /// No byte, or no more.
    #[error("nothing was heard of a chassis for 2 s; is it on, and is this its line?")]
    Silent,
    /// Bytes, but no frame.
    #[error(
        "what arrives cannot be read ({error}); is this a chassis' line, at 921600 baud if it is serial?"
    )]
    Unreadable {
        /// What was wrong last.
        error: FrameError,
    },
    /// Another device.
    #[error("this is the line of {sender}, not of a chassis; connect to the chassis' own")]
    WrongDevice {
        /// Whose.
        sender: DeviceId,
    },
    /// It speaks another protocol.
    #[error("{0}")]
    Version(#[from] version::NoCommonVersion),
    /// It reports, but does not answer.
    #[error(
        "the chassis of robot {robot} reports its motion but answers no command; \
         is the line from this computer to the chassis broken?"
    )]
    Unanswered {
        /// Whose.
        robot: RobotId,
    },
    /// It refused.
    #[error("the chassis of robot {robot} refuses to {what}: {}", words::refusal(*.reason))]
    Refused {
        /// Whose.
        robot: RobotId,
        /// What it was asked for.
        what: &'static str,
        /// Its reason.
        reason: NackReason,
    },
    /// It was told to stop, said that it does, and still moves.
    #[error(
        "the chassis of robot {robot} has taken the stop but is not braked after 5 s; \
         cut its power if it moves"
    )]
    NotStopping {
        /// Whose.
        robot: RobotId,
    },
}

/// How a session went.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Whose chassis it was.
    pub robot: Option<RobotId>,
    /// Commands that it did.
    pub done: u32,
    /// How it moved when the drive ended, in m/s and rad/s.
    pub reached: Twist,
    /// How far it is from where it stood at first, in that place's axes.
    pub moved: Moved,
    /// What it does now.
    pub mode: Option<ChassisMode>,
    /// Why it does not drive.
    pub stop: Option<StopReason>,
}

/// A way in the plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Moved {
    /// Forward, in metres.
    pub x_m: f32,
    /// To the left, in metres.
    pub y_m: f32,
    /// Counter-clockwise, in radians from -pi to pi.
    pub yaw_rad: f32,
}

impl Moved {
    /// From where the chassis was first to where it is last.
    pub(super) fn between(first: &Odometry, last: &Odometry) -> Self {
        let (from, to) = (first.pose, last.pose);
        let (x, y) = (to.x.get() - from.x.get(), to.y.get() - from.y.get());
        let (sin, cos) = from.yaw.get().sin_cos();
        let (turned_sin, turned_cos) = (to.yaw.get() - from.yaw.get()).sin_cos();
        Self { x_m: x * cos + y * sin, y_m: y * cos - x * sin, yaw_rad: turned_sin.atan2(turned_cos) }
    }
}
