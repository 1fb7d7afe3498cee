//! What robots work at: the kinds of tasks of Access's Table 1.

use protocol::DurationMs;

use super::random::Random;

/// A kind of task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// Looks after a place.
    Patrolling,
    /// Takes something to a person.
    Delivery,
    /// Cleans a place.
    Cleaning,
    /// Leads a person to a place.
    Escort,
    /// Anything else.
    Other,
}

impl Task {
    /// All kinds.
    pub const ALL: [Self; 5] = [Self::Patrolling, Self::Delivery, Self::Cleaning, Self::Escort, Self::Other];

    /// The next task, by chance.
    pub fn draw(random: &mut Random) -> Self {
        random.choose(&Self::ALL).copied().unwrap_or(Self::Other)
    }

    /// How much it matters, 1 to 10 (T_tp of Access eq. 4, from Table 1).
    #[must_use]
    pub const fn priority(self) -> u8 {
        match self {
            Self::Patrolling => 10,
            Self::Delivery => 8,
            Self::Cleaning => 3,
            Self::Escort => 9,
            Self::Other => 5,
        }
    }

    /// What it takes at its place on top of what a robot takes all the time, in watts.
    #[must_use]
    pub const fn power_w(self) -> f64 {
        match self {
            Self::Patrolling | Self::Escort => 10.0,
            Self::Delivery => 5.0,
            Self::Cleaning => 60.0,
            Self::Other => 20.0,
        }
    }

    /// How long it takes at its place.
    pub fn time_at_work(self, random: &mut Random) -> DurationMs {
        let (least_s, most_s) = match self {
            Self::Patrolling => (5.0, 15.0),
            Self::Delivery => (10.0, 40.0),
            Self::Cleaning => (30.0, 90.0),
            Self::Escort => (5.0, 20.0),
            Self::Other => (5.0, 60.0),
        };
        DurationMs::from_seconds(random.between(least_s, most_s) as f32)
    }
}
