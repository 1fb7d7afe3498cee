//! Who and what a message speaks of.
//!
//! Every identifier is its own type, so that a lease is never taken for a pile.

use core::{fmt, str::FromStr};

use serde::{Deserialize, Serialize};

use crate::max_size::MaxSize;

macro_rules! ids {
    ($($(#[$doc:meta])* $name:ident($inner:ty);)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        #[serde(transparent)]
        pub struct $name(pub $inner);

        impl MaxSize for $name {
            const MAX_SIZE: usize = <$inner>::MAX_SIZE;
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.0.fmt(f)
            }
        }
    )*};
}

ids! {
    /// A charging pile of the site (the papers' s_i).
    PileId(u16);
    /// A robot of the fleet.
    RobotId(u16);
    /// A lease; the coordinator never gives the same number twice. One that a pile has made for itself
    /// [`is_local`](LeaseId::is_local).
    LeaseId(u32);
    /// The reign of one coordinator. It grows with every take-over; a pile refuses lower ones
    /// than the highest it has seen.
    Epoch(u32);
    /// Counts the starts of a device, so that its old frames are known as old.
    BootEpoch(u32);
    /// Counts the frames of a device since its start.
    Sequence(u32);
    /// A command; a repeat carries the same number, is answered again and not done again.
    CommandId(u32);
    /// A request for a robot's charge; a repeat carries the same number. Robots number theirs from 0 on,
    /// the coordinator those that it opens itself from [`RequestId::FIRST_CALL`] on.
    RequestId(u32);
    /// A kind of work a robot does, such as patrolling (Access Table 1's T_i).
    TaskId(u16);
}

impl LeaseId {
    /// What a lease's number has that a pile made for itself. A coordinator gives only lower numbers.
    const LOCAL: u32 = 1 << 31;

    /// The number of the lease that a pile makes for itself as its `count`-th.
    #[must_use]
    pub const fn local(count: u32) -> Self {
        Self(Self::LOCAL | count)
    }

    /// Whether a pile made the lease for itself, while it heard no coordinator.
    #[must_use]
    pub const fn is_local(self) -> bool {
        self.0 & Self::LOCAL != 0
    }

    /// The next number that a coordinator gives after this one.
    #[must_use]
    pub const fn next(self) -> Self {
        if self.is_local() { Self(0) } else { Self(self.0.saturating_add(1)) }
    }
}

impl RequestId {
    /// The first number that no robot gives.
    pub const FIRST_CALL: Self = Self(1 << 31);

    /// Whether the coordinator opened the request: the robot is called to a pile and has not asked.
    #[must_use]
    pub const fn is_call(self) -> bool {
        self.0 >= Self::FIRST_CALL.0
    }
}

/// A report that its sender repeats until it is acknowledged, also after a restart. A device's
/// later reports are greater.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ReportId {
    /// The start in which the report was made.
    pub boot: BootEpoch,
    /// Grows by one with every new report since that start.
    pub number: u32,
}

impl MaxSize for ReportId {
    const MAX_SIZE: usize = BootEpoch::MAX_SIZE + u32::MAX_SIZE;
}

impl fmt::Display for ReportId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.boot, self.number)
    }
}

/// What an RFID reader sees of a robot: a 96-bit EPC.
#[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(transparent)]
pub struct TagId(pub [u8; 12]);

impl MaxSize for TagId {
    const MAX_SIZE: usize = <[u8; 12]>::MAX_SIZE;
}

impl fmt::Display for TagId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02X}"))
    }
}

impl fmt::Debug for TagId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "TagId({self})")
    }
}

/// The text is no tag: a tag is written as 24 hexadecimal digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a tag is 24 hexadecimal digits, such as 30751FEB705C5904E3D50D70")]
pub struct NotATag;

impl FromStr for TagId {
    type Err = NotATag;

    fn from_str(text: &str) -> Result<Self, NotATag> {
        let digit = |byte: u8| char::from(byte).to_digit(16).and_then(|digit| u8::try_from(digit).ok());
        let mut tag = [0; 12];
        if text.len() != 2 * tag.len() {
            return Err(NotATag);
        }
        for (byte, pair) in tag.iter_mut().zip(text.as_bytes().chunks_exact(2)) {
            *byte = match pair {
                &[high, low] => digit(high).zip(digit(low)).map(|(high, low)| high << 4 | low),
                _ => None,
            }
            .ok_or(NotATag)?;
        }
        Ok(Self(tag))
    }
}

/// Who sent a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum DeviceId {
    /// The site's coordinator, whichever computer it runs on.
    Coordinator,
    /// A charging pile.
    Pile(PileId),
    /// A robot: its computer, which drives the chassis and asks for charges.
    Robot(RobotId),
    /// The control board in a robot's chassis.
    Chassis(RobotId),
    /// A person's tool, at a desk.
    Service,
    /// A board that has no identity yet.
    Factory,
}

impl fmt::Display for DeviceId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Coordinator => f.write_str("the coordinator"),
            Self::Pile(pile) => write!(f, "pile {pile}"),
            Self::Robot(robot) => write!(f, "robot {robot}"),
            Self::Chassis(robot) => write!(f, "the chassis of robot {robot}"),
            Self::Service => f.write_str("the service tool"),
            Self::Factory => f.write_str("a board without identity"),
        }
    }
}
