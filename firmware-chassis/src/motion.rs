//! Driving, stopping, braked: which of them, and why.
//!
//! ```text
//!            Drive                     time is up, Stop
//!  Braked ----------> Driving <------------------------> Stopping
//!    ^                   |             Drive                |
//!    +-------------------+----------------------------------+
//!      emergency, fault: at once           set-points are zero
//! ```
//! Some stops are held: only a release, with their cause gone, lets the robot drive again.

use protocol::{ChassisMode, Millis, StopReason};

use crate::kinematics::WheelSpeeds;

/// What a chassis does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// The motors brake.
    Braked {
        /// Why.
        reason: StopReason,
    },
    /// It follows a command.
    Driving {
        /// Where the wheels shall get, in m/s.
        target: WheelSpeeds,
        /// When the command has outlived its time.
        until: Millis,
    },
    /// It ramps to a stop.
    Stopping {
        /// Why.
        reason: StopReason,
    },
}

/// Whether a stop for this reason is held until it is released.
#[must_use]
pub const fn is_held(reason: StopReason) -> bool {
    match reason {
        StopReason::Started
        | StopReason::Watchdog
        | StopReason::Commanded
        | StopReason::LinkSilent
        | StopReason::LinkCorrupted => false,
        StopReason::Emergency
        | StopReason::DriverFault
        | StopReason::EncoderStuck
        | StopReason::WheelStalled => true,
    }
}

impl Motion {
    /// The mode by its name on the wire.
    #[must_use]
    pub const fn mode(&self) -> ChassisMode {
        match self {
            Self::Braked { .. } => ChassisMode::Braked,
            Self::Driving { .. } => ChassisMode::Driving,
            Self::Stopping { .. } => ChassisMode::Stopping,
        }
    }

    /// Why it does not drive.
    #[must_use]
    pub const fn stop(&self) -> Option<StopReason> {
        match *self {
            Self::Braked { reason } | Self::Stopping { reason } => Some(reason),
            Self::Driving { .. } => None,
        }
    }

    /// The stop that is held.
    #[must_use]
    pub fn held(&self) -> Option<StopReason> {
        self.stop().filter(|&reason| is_held(reason))
    }

    /// Where the wheels shall get, in m/s.
    #[must_use]
    pub fn target(&self) -> WheelSpeeds {
        match *self {
            Self::Driving { target, .. } => target,
            Self::Braked { .. } | Self::Stopping { .. } => WheelSpeeds::zeros(),
        }
    }

    /// Ramps to a stop, if it drives.
    pub fn stop_for(&mut self, reason: StopReason) {
        if let Self::Driving { .. } | Self::Stopping { .. } = self {
            *self = Self::Stopping { reason };
        } else if self.held().is_none() {
            *self = Self::Braked { reason };
        }
    }

    /// Brakes at once. The first reason to hold a stop stays.
    pub fn brake_for(&mut self, reason: StopReason) {
        if self.held().is_none() {
            *self = Self::Braked { reason };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRIVING: Motion =
        Motion::Driving { target: WheelSpeeds::new(1.0, 1.0, 1.0, 1.0), until: Millis(1) };

    #[test]
    fn a_stop_ramps_a_moving_robot_and_leaves_a_standing_one_braked() {
        let mut motion = DRIVING;
        motion.stop_for(StopReason::LinkSilent);
        assert_eq!(motion, Motion::Stopping { reason: StopReason::LinkSilent });
        assert_eq!(motion.target(), WheelSpeeds::zeros());
        let mut motion = Motion::Braked { reason: StopReason::Started };
        motion.stop_for(StopReason::Commanded);
        assert_eq!(motion, Motion::Braked { reason: StopReason::Commanded });
    }

    #[test]
    fn the_first_reason_to_hold_a_stop_stays() {
        let mut motion = DRIVING;
        motion.brake_for(StopReason::EncoderStuck);
        motion.brake_for(StopReason::Emergency);
        motion.stop_for(StopReason::Commanded);
        assert_eq!(motion, Motion::Braked { reason: StopReason::EncoderStuck });
        assert_eq!(motion.held(), Some(StopReason::EncoderStuck));
    }
}
