//! Robots are called to charge without having asked: while they can still reach a pile with a reserve.
//!
//! Every few seconds it is reckoned for every robot at work when its charge has to begin
//! ([`margin`](crate::selection::margin)): by what its battery holds, by what it was seen to take, with the
//! spread of that, and by who else needs a pile about then. When that time has come the coordinator opens a
//! request for it. It goes through the queue like any other, but the robot hears nothing of it until a pile
//! is there for it, and works on. One that does not heed the call is not called again before it has left its
//! work. A robot asks by itself only when it comes to its own alert (LMPP eq. 3)
//! without having been called in time: because it hears no coordinator, or all piles are taken.

use std::collections::BTreeMap;

use protocol::{
    Activity, BootEpoch, DurationMs, PileId, RequestId, RobotId, SiteMillis, TaskId, TaskPriority,
};

use super::{
    coordinator::Coordinator,
    event::{Fact, Opener},
    profile::SPREADS,
    routes::Way,
    situation::{DOOR_S, LEAVE_S, RESERVE},
    state::Place,
    turn::Turn,
};
use crate::{
    config::RobotConfig,
    selection::margin::{Need, latest_starts},
};

/// How often it is looked who needs a charge.
const INTERVAL: DurationMs = DurationMs(5_000);
/// A network that is cut, a pile or a coordinator that starts anew may keep a robot so much longer from its
/// charge than it should, in seconds.
const TROUBLE_S: f64 = 120.0;
/// Nobody is called who has more than this share of a full battery.
const MOST: f64 = 0.5;

/// A robot that needs a charge some time.
struct Candidate {
    robot: RobotId,
    /// Whether it may be called now.
    at_work: bool,
    /// How long its way to a pile takes, in seconds.
    way_s: f64,
    need: Need,
}

impl Coordinator {
    /// Opens requests for the robots whose charge has to begin soon.
    pub(super) fn call_robots(&mut self, turn: &mut Turn) {
        if turn.now.since(self.observed.called_at) < INTERVAL {
            return;
        }
        self.observed.called_at = turn.now;
        // Rooms that no way joins have nothing to do with one another: each is named by its first pile.
        let mut islands: BTreeMap<PileId, Vec<Candidate>> = BTreeMap::new();
        let robots: Vec<_> = self.robots.values().copied().collect();
        for config in &robots {
            if let Some((island, candidate)) = self.candidate(turn.now, config) {
                islands.entry(island).or_default().push(candidate);
            }
        }
        for (island, candidates) in islands {
            let frees = self.frees_s(turn.now, island);
            // The charges that run already are spread over all piles.
            let busy_s = frees.iter().sum::<f64>() / frees.len().max(1) as f64;
            let needs: Vec<_> = candidates.iter().map(|candidate| candidate.need).collect();
            let starts = latest_starts(&needs, frees.len());
            let due = candidates
                .iter()
                .zip(starts)
                .filter(|(candidate, start_s)| candidate.at_work && *start_s <= candidate.way_s + busy_s);
            for (candidate, _) in due {
                self.open_request(turn, candidate.robot, Opener::Coordinator, None, TaskPriority::USUAL);
            }
        }
    }

    /// When each pile is free, in seconds from now, that ways lead to from `island` and that somebody knows
    /// this of.
    fn frees_s(&self, now: SiteMillis, island: PileId) -> Vec<f64> {
        let piles = self.site.piles.iter();
        let joined = piles.filter(|pile| pile.id == island || self.routes.joins(island, pile.id));
        joined.filter_map(|pile| self.free_in_s(pile, now)).collect()
    }

    /// What a robot needs, and the first pile of those that it has ways to. None of one that is charged
    /// already, or of which nothing is known.
    fn candidate(&mut self, now: SiteMillis, config: &RobotConfig) -> Option<(PileId, Candidate)> {
        let seen = self.observed.robots.get(&config.id)?;
        let (position, energy) = seen.last?;
        let request = self.state.requests.get(&config.id);
        let granted = request.and_then(|request| match request.place {
            Place::Granted(pile) => Some(pile),
            Place::Waiting | Place::Next(_) => None,
        });
        let charged = granted
            .is_some_and(|pile| self.state.lease(pile).is_some_and(|lease| self.is_charging(pile, lease)));
        if charged || self.state.stranded.contains(&config.id) || self.observed.robot_is_lost(config.id, now)
        {
            return None;
        }
        let at_work = request.is_none()
            // A mobile charger asks by itself.
            && config.gives_w.is_none()
            && seen.report.is_some_and(|report| report.activity == Activity::Working)
            && !self.observed.robot_is_silent(config.id, now)
            // It may know of no calls.
            && !seen.called
            && f64::from(energy.get()) <= MOST * f64::from(config.full.get());
        let (per_metre_j, spread_j) = seen.consumption.estimate(config.energy_per_metre_j);
        let standing_w = seen.consumption.standing_w(config.energy_per_metre_j, config.speed_mps);
        let working_w = seen.consumption.working_w(config.energy_per_metre_j, config.speed_mps);
        let cell = self.site.cell_of(position).filter(|cell| self.site.grid.is_free(*cell))?;
        let ways = self.ways_from(config.id, cell);
        let (&island, _) = ways.first_key_value()?;
        let usable = ways.iter().filter(|(pile, _)| {
            self.site.pile(**pile).is_some_and(|pile| self.free_in_s(pile, now).is_some())
        });
        let nearest = usable.map(|(_, way)| *way).min_by(|one, other| one.length.total_cmp(&other.length));
        let Way { length, congestion } = nearest?;
        let at_most_j = per_metre_j + SPREADS * spread_j;
        let full_j = f64::from(config.full.get());
        let way_j = length * self.site.resolution_m * at_most_j;
        let kept_j = way_j + (congestion * DOOR_S + TROUBLE_S) * standing_w + RESERVE * full_j;
        let way_s = self.drive_s(config, length) + congestion * DOOR_S;
        let works_s = (f64::from(energy.get()) - kept_j) / working_w;
        let power_w = f64::from(self.site.pile(island)?.power_w);
        let need = Need { deadline_s: works_s + way_s, charge_s: full_j / power_w + LEAVE_S };
        Some((island, Candidate { robot: config.id, at_work, way_s, need }))
    }

    /// Opens a request for a robot that has not asked; `None` if nobody knows where it is.
    pub(super) fn open_request(
        &mut self,
        turn: &mut Turn,
        robot: RobotId,
        opener: Opener,
        task: Option<TaskId>,
        priority: TaskPriority,
    ) -> Option<RequestId> {
        let request = self.state.next_call();
        let seen = self.observed.robots.get_mut(&robot)?;
        let (position, energy) = seen.last?;
        let boot = seen.contact.boot().unwrap_or(BootEpoch(0));
        seen.left_work = false;
        seen.working_since = seen.working_since.map(|_| turn.now);
        (seen.told, seen.route, seen.called) = (None, None, true);
        self.record(turn, Fact::Asked { robot, boot, request, position, energy, task, priority, opener });
        self.observed.queue_is_due = true;
        Some(request)
    }
}
