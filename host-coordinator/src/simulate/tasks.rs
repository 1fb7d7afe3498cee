//! What robots work at: the kinds of tasks of Access's Table 1.

use std::collections::BTreeMap;

use protocol::{DurationMs, EnergyJ, TaskEnergy, TaskId, TaskPriority};

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

    /// Its number in messages.
    #[must_use]
    pub const fn id(self) -> TaskId {
        TaskId(match self {
            Self::Patrolling => 1,
            Self::Delivery => 2,
            Self::Cleaning => 3,
            Self::Escort => 4,
            Self::Other => 5,
        })
    }

    /// How much it matters (T_tp of Access eq. 4, from Table 1).
    #[must_use]
    pub fn priority(self) -> TaskPriority {
        let priority = match self {
            Self::Patrolling => 10,
            Self::Delivery => 8,
            Self::Cleaning => 3,
            Self::Escort => 9,
            Self::Other => return TaskPriority::USUAL,
        };
        TaskPriority::new(priority).unwrap_or_default()
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

/// What a robot's runs of its tasks took from its battery, as it keeps account of them (Access eqs. 1, 2).
#[derive(Clone, Debug, Default)]
pub struct Runs {
    /// How many, and what they took together, in joules.
    done: BTreeMap<TaskId, (u32, f64)>,
}

impl Runs {
    /// A run is over that took so much; what is to be told of it.
    pub fn add(&mut self, task: Task, taken_j: f64) -> TaskEnergy {
        let (runs, sum_j) = self.done.entry(task.id()).or_default();
        *runs = runs.saturating_add(1);
        *sum_j += taken_j;
        let energy = |joules: f64| EnergyJ::clamped(joules as f32);
        TaskEnergy {
            task: task.id(),
            runs: *runs,
            last: energy(taken_j),
            mean: energy(*sum_j / f64::from(*runs)),
        }
    }
}
