//! What is known when piles are chosen: the robots that wait and what every pile is to each of them.

use std::collections::BTreeMap;

use protocol::{Availability, EnergyJ, PileId, Position, RobotId, SiteMillis, TaskPriority};
use serde::{Deserialize, Serialize};

use super::multistage::Candidate;

/// All that wait at one instant; they are given piles together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Situation {
    /// The robots. Each has the same piles in the same order as its offers.
    pub askers: Vec<Asker>,
}

/// A robot that waits for a pile.
#[derive(Clone, Debug, PartialEq)]
pub struct Asker {
    /// Which robot.
    pub robot: RobotId,
    /// Where it is.
    pub position: Position,
    /// What its battery holds.
    pub energy: EnergyJ,
    /// When it asked first.
    pub asked_at: SiteMillis,
    /// For how long it has waited, in seconds.
    pub waited_s: f64,
    /// How urgent its need is ([`priority`](super::priority)); more is more urgent.
    pub urgency: f64,
    /// Whether its battery is about to be empty (Access eq. 5): then another robot's charge may be cut short.
    pub is_critical: bool,
    /// How far it gets, in cells (d_l, eq. 6), by its mean consumption.
    pub reach: f64,
    /// How far it gets almost surely, in cells: by the upper end of what it was seen to consume, with a
    /// reserve. Never more than `reach`.
    pub sure_reach: f64,
    /// What it takes while it stands, in watts.
    pub standing_w: f64,
    /// What every pile is to it.
    pub offers: Vec<Offer>,
}

/// What one pile is to one robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offer {
    /// What LMPP's choice knows of it.
    pub candidate: Candidate,
    /// Whether it is free to this robot alone, which stands there without a lease.
    pub stands_here: bool,
    /// When it is free, in seconds from now; none if nobody knows.
    pub free_in_s: Option<f64>,
    /// Whether it is occupied and promised to nobody, so that it could be this robot's next.
    pub next_is_open: bool,
    /// Who is charged there, if that can be cut short.
    pub holder: Option<Holder>,
    /// What it would cost the robot in time; none if no way leads there, or nobody knows when it is free.
    pub times: Option<Times>,
}

/// A robot whose charge can be cut short: it has been charged for a while, and has enough to do its next
/// task and to reach a pile after that.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Holder {
    /// Which robot.
    pub robot: RobotId,
    /// How important its next task is.
    pub priority: TaskPriority,
    /// What its battery holds, as a share of a full one.
    pub share: f64,
}

/// The parts of the time that a charge keeps a robot from its work, in seconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Times {
    /// The drive to the pile, undisturbed.
    pub drive_s: f64,
    /// What congested doors on the way add (eqs. 10, 11).
    pub doors_s: f64,
    /// Until the pile is free: what is left of the planned times of the robot on it (eqs. 1, 2).
    pub free_in_s: f64,
    /// The charge itself (eq. 2).
    pub charge_s: f64,
    /// The drive to where the robot is wanted afterwards: by its pass counts (K, eq. 5), else back.
    pub back_s: f64,
    /// No part of it: for how long its battery lasts almost surely, if the robot drives to the pile and
    /// stands there.
    #[serde(default)]
    pub lasts_s: f64,
}

impl Times {
    /// Until the robot is at the pile.
    #[must_use]
    pub const fn way_s(&self) -> f64 {
        self.drive_s + self.doors_s
    }

    /// For how long the robot stands before its charge begins.
    #[must_use]
    pub const fn wait_s(&self) -> f64 {
        (self.free_in_s - self.way_s()).max(0.0)
    }

    /// For how long the robot would stand at the pile with an empty battery, if all takes `prudence_s` longer
    /// than it should; 0 if it would not.
    #[must_use]
    pub const fn empty_s(&self, prudence_s: f64) -> f64 {
        (self.way_s() + self.wait_s() + prudence_s - self.lasts_s).max(0.0)
    }

    /// All of it: from now until the robot works again.
    #[must_use]
    pub const fn away_s(&self) -> f64 {
        self.way_s() + self.wait_s() + self.charge_s + self.back_s
    }
}

impl Asker {
    /// How far the robot may be sent, in cells: as far as it surely gets. Where no pile there can serve it in
    /// time, as far as it gets on average: standing still is no better.
    #[must_use]
    pub fn range(&self) -> f64 {
        let saves = |offer: &Offer| {
            let in_reach = offer.candidate.distance.is_some_and(|distance| distance <= self.sure_reach);
            in_reach && offer.times.is_some_and(|times| times.empty_s(0.0) == 0.0)
        };
        if self.offers.iter().any(saves) { self.sure_reach } else { self.reach }
    }

    /// What LMPP's choice knows of the piles, without those that are `given` to others of the same
    /// instant.
    #[must_use]
    pub fn candidates(&self, given: &BTreeMap<PileId, RobotId>) -> Vec<Candidate> {
        let candidate = |offer: &Offer| {
            let is_given = given.contains_key(&offer.candidate.pile);
            let availability = offer.candidate.availability;
            let availability = if is_given { Some(Availability::Reserved) } else { availability };
            Candidate { availability, ..offer.candidate }
        };
        self.offers.iter().map(candidate).collect()
    }
}
