//! What was known for sure at an instant, for a person and for programs.

use protocol::{PileId, RobotId};
use serde::Serialize;

use crate::core::{
    state::{Place, State},
    view::{LeaseView, fault_name},
};

/// What a log tells of an instant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Standing {
    /// The coordinator's epoch.
    pub epoch: u32,
    /// The piles that were ever spoken of, by number.
    pub piles: Vec<PileStanding>,
    /// The open requests, by robot.
    pub requests: Vec<RequestStanding>,
    /// Robots that wait for help.
    pub stranded: Vec<RobotId>,
    /// Requests so far.
    pub asked: u64,
    /// Charges so far that were given in full.
    pub charges_completed: u64,
    /// Charges so far that were cut short for a critical robot.
    pub preempted: u64,
    /// What all charges gave so far, in joules.
    pub energy_j: f64,
    /// The mean time from first asking to a pile's acceptance, in seconds.
    pub mean_wait_s: f64,
    /// The longest of those.
    pub worst_wait_s: f64,
}

/// What was known of a pile.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PileStanding {
    /// Which pile.
    pub pile: PileId,
    /// The lease that was or might have been alive on it.
    pub lease: Option<LeaseView>,
    /// Who was promised it next.
    pub next: Option<RobotId>,
    /// The faults it had.
    pub faults: Vec<&'static str>,
}

/// What was known of a request.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RequestStanding {
    /// Whose.
    pub robot: RobotId,
    /// When it asked first.
    pub asked_at_ms: u64,
    /// What its battery held when it asked, in joules.
    pub energy_j: f32,
    /// `waiting`, `next` at an occupied pile, or `granted`.
    pub place: &'static str,
    /// The pile, unless it waits.
    pub pile: Option<PileId>,
}

impl Standing {
    /// What `state` tells.
    #[must_use]
    pub fn of(state: &State) -> Self {
        let totals = &state.totals;
        let piles = state.piles.iter().map(|(pile, record)| PileStanding {
            pile: *pile,
            lease: record.lease.as_ref().map(LeaseView::new),
            next: record.next,
            faults: record.faults.iter().map(|fault| fault_name(*fault)).collect(),
        });
        let requests = state.requests.iter().map(|(robot, request)| {
            let (place, pile) = match request.place {
                Place::Waiting => ("waiting", None),
                Place::Next(pile) => ("next", Some(pile)),
                Place::Granted(pile) => ("granted", Some(pile)),
            };
            let (asked_at_ms, energy_j) = (request.asked_at.0, request.energy.get());
            RequestStanding { robot: *robot, asked_at_ms, energy_j, place, pile }
        });
        Self {
            epoch: state.epoch.0,
            piles: piles.collect(),
            requests: requests.collect(),
            stranded: state.stranded.iter().copied().collect(),
            asked: totals.requests,
            charges_completed: totals.charges_completed,
            preempted: totals.preempted,
            energy_j: totals.energy_j,
            mean_wait_s: totals.mean_wait_s(),
            worst_wait_s: totals.worst_wait_s(),
        }
    }
}
