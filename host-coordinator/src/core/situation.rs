//! What is known of all robots that wait, as the policies take it.

use std::sync::Arc;

use firmware_pile::charge;
use planning::grid::Cell;
use protocol::{Availability, DurationMs, EnergyJ, PileId, PileRow, Position, RobotId, SiteMillis};

use super::{
    PILE,
    coordinator::Coordinator,
    profile::{SPREADS, TaskProfile},
    routes::Ways,
    state::Request,
    turn::Turn,
};
use crate::{
    config::RobotConfig,
    selection::{Asker, Candidate, Holder, Offer, Situation, Times, activity, priority, reach},
    site::SitePile,
};

/// What a door costs a robot by its congestion: that share of this, in seconds.
pub(super) const DOOR_S: f64 = 30.0;
/// A charged robot has left its pile after this, in seconds.
pub(super) const LEAVE_S: f64 = 10.0;
/// What a robot should have left when it comes to a pile, as a share of a full battery.
pub(super) const RESERVE: f64 = 0.02;
/// No charge is cut short before it has lasted so long: nobody is sent to and fro.
const MIN_HOLD: DurationMs = DurationMs(120_000);
/// What a task takes of which nothing is known, as a share of a full battery.
const UNKNOWN_TASK: f64 = 0.3;

/// What a pile is to all robots alike.
pub(super) struct Seat {
    pub availability: Option<Availability>,
    /// The share of its charge still ahead.
    pub remaining: f64,
    /// When it is free, in seconds from now; none if nobody knows.
    pub free_in_s: Option<f64>,
    pub next_is_open: bool,
    pub holder: Option<Holder>,
}

/// A robot that waits, as it was heard last.
pub(super) struct Seen<'a> {
    pub config: &'a RobotConfig,
    pub energy: EnergyJ,
    /// What a metre takes, in joules.
    pub per_metre_j: f64,
    /// What a metre takes at most, almost surely.
    pub at_most_j: f64,
    /// What standing takes, in watts.
    pub standing_w: f64,
    pub ways: Arc<Ways>,
}

impl Coordinator {
    /// The situation of the robots in `waiting`.
    pub(super) fn situation(&mut self, turn: &mut Turn, waiting: &[(RobotId, Request)]) -> Situation {
        let left_w = self.power_left_w(turn.now);
        let seats: Vec<_> = self.site.piles.iter().map(|pile| self.seat(pile, left_w, turn.now)).collect();
        let mut askers = Vec::with_capacity(waiting.len());
        for (robot, request) in waiting {
            let Some(config) = self.robots.get(robot).copied() else { continue };
            let seen = self.observed.robots.get(robot).and_then(|seen| seen.last);
            let Some((position, energy)) = seen else { continue };
            let ways = self.ways(turn, *robot, position);
            askers.push(self.asker(turn.now, &config, request, (position, energy), ways, &seats));
        }
        Situation { askers }
    }

    fn asker(
        &self,
        now: SiteMillis,
        config: &RobotConfig,
        request: &Request,
        (position, energy): (Position, EnergyJ),
        ways: Arc<Ways>,
        seats: &[Seat],
    ) -> Asker {
        let consumption = self.observed.robots.get(&config.id).map(|seen| seen.consumption);
        let consumption = consumption.unwrap_or_default();
        let (per_metre_j, spread_j) = consumption.estimate(config.energy_per_metre_j);
        let at_most_j = per_metre_j + SPREADS * spread_j;
        let standing_w = consumption.standing_w(config.energy_per_metre_j, config.speed_mps);
        let full_j = f64::from(config.full.get());
        let spare = EnergyJ::clamped((f64::from(energy.get()) - RESERVE * full_j) as f32);
        let cells = |energy, per_metre_j| reach::reach_cells(energy, per_metre_j, self.site.resolution_m);
        let waited_s = now.since(request.asked_at).0 as f64 / 1000.0;
        let share = f64::from(energy.get()) / full_j;
        let seen = Seen { config, energy, per_metre_j, at_most_j, standing_w, ways };
        let piles = self.site.piles.iter().zip(seats);
        Asker {
            robot: config.id,
            position,
            energy,
            asked_at: request.asked_at,
            waited_s,
            urgency: priority::urgency(share, request.priority, waited_s),
            is_critical: priority::score(share, request.priority).is_none(),
            reach: cells(energy, per_metre_j),
            sure_reach: cells(spare, at_most_j),
            standing_w,
            offers: piles.map(|(pile, seat)| self.offer(now, &seen, pile, seat)).collect(),
        }
    }

    pub(super) fn offer(&self, now: SiteMillis, seen: &Seen<'_>, pile: &SitePile, seat: &Seat) -> Offer {
        let config = seen.config;
        let lacking = EnergyJ::clamped(config.full.get() - seen.energy.get());
        let planned = charge::planned_time([lacking], pile.power_w, PILE.eta);
        let period = activity::period(now, planned, PILE.period, PILE.periods);
        let way = seen.ways.get(&pile.id).copied();
        let availability = match seat.availability {
            Some(Availability::Done) => self.availability_for(config.id, pile.id, now),
            other => other,
        };
        let stands_here = seat.availability != availability;
        let candidate = Candidate {
            pile: pile.id,
            availability,
            remaining: seat.remaining,
            distance: way.map(|way| way.length),
            probability: self.state.pass_frequency(config.id, period, pile.id),
        };
        let times = way.zip(seat.free_in_s).map(|(way, free_in_s)| {
            let drive_s = self.drive_s(config, way.length);
            let drive_j = way.length * self.site.resolution_m * seen.per_metre_j;
            let lacking = EnergyJ::clamped((f64::from(lacking.get()) + drive_j) as f32);
            let charge = charge::planned_time([lacking], pile.power_w, PILE.eta);
            let wanted = self.state.wanted_at(config.id, period);
            let doors_s = way.congestion * DOOR_S;
            let left_j = f64::from(seen.energy.get()) - way.length * self.site.resolution_m * seen.at_most_j;
            let back = self.routes.expected_from(pile.id, wanted).unwrap_or(way.length);
            Times {
                drive_s,
                doors_s,
                free_in_s,
                charge_s: charge.as_seconds().into(),
                back_s: self.drive_s(config, back),
                lasts_s: drive_s + left_j / seen.standing_w,
            }
        });
        let Seat { free_in_s, next_is_open, holder, .. } = *seat;
        Offer { candidate, stands_here, free_in_s, next_is_open, holder, times }
    }

    fn seat(&self, pile: &SitePile, left_w: f64, now: SiteMillis) -> Seat {
        let availability = self.availability(pile.id, now).map(|availability| match availability {
            Availability::Free if !self.has_power_for(pile, left_w, now) => Availability::Reserved,
            availability => availability,
        });
        let report = self.observed.report(pile.id, now);
        Seat {
            availability,
            remaining: report.map_or(0.0, |report| report.row.remaining.get().into()),
            free_in_s: self.free_in_s(pile, now),
            next_is_open: self.next_is_open(pile.id, now),
            holder: self.holder(pile, now),
        }
    }

    /// The robot that a pile charges, if its charge can be cut short for another.
    fn holder(&self, pile: &SitePile, now: SiteMillis) -> Option<Holder> {
        let report = self.observed.report(pile.id, now)?;
        let lease = self.state.lease(pile.id).filter(|lease| self.is_charging(pile.id, lease))?;
        if report.elapsed < MIN_HOLD || !lease.is_wanted() || self.state.next(pile.id).is_some() {
            return None;
        }
        let config = self.robots.get(&lease.name.robot)?;
        let request = self.state.requests.get(&config.id)?;
        let seen = self.observed.robots.get(&config.id)?;
        let (_, energy) = seen.last?;
        let full_j = f64::from(config.full.get());
        let profiles = self.state.profiles.get(&config.id);
        let profile = request.task.and_then(|task| profiles?.get(&task));
        let task_j = profile.map_or(UNKNOWN_TASK * full_j, TaskProfile::at_most_j);
        let (per_metre_j, spread_j) = seen.consumption.estimate(config.energy_per_metre_j);
        let way_m = self.routes.farthest_from(pile.id) * self.site.resolution_m;
        let needed_j = task_j + way_m * (per_metre_j + SPREADS * spread_j) + RESERVE * full_j;
        let energy_j = f64::from(energy.get());
        (energy_j >= needed_j).then(|| Holder {
            robot: config.id,
            priority: request.priority,
            share: energy_j / full_j,
        })
    }

    /// How long a robot drives for so many cells, in seconds.
    pub(super) fn drive_s(&self, robot: &RobotConfig, cells: f64) -> f64 {
        cells * self.site.resolution_m / f64::from(robot.speed_mps)
    }

    /// When a pile is free, in seconds from now: what is left of the planned time of the robot on it (LMPP
    /// eqs. 1, 2), which may still be on its way. None if nobody knows. Of a pile that is silent but not lost
    /// the last report counts.
    pub(super) fn free_in_s(&self, pile: &SitePile, now: SiteMillis) -> Option<f64> {
        if self.observed.pile_is_lost(pile.id, now) {
            return None;
        }
        let report = self.observed.piles.get(&pile.id).and_then(|seen| seen.report);
        match (report.map(|report| report.row), self.state.lease(pile.id)) {
            (Some(PileRow { availability: Availability::Fault, .. }), _) => None,
            (Some(row), _) if row.availability == Availability::Charging => {
                Some(f64::from(row.planned.as_seconds()) * f64::from(row.remaining.get()) + LEAVE_S)
            }
            (Some(PileRow { availability: Availability::Done, .. }), _) => Some(LEAVE_S),
            // It waits until no copy of a command can arrive any more.
            (_, Some(lease)) if !lease.is_wanted() => {
                Some(f64::from(lease.expiry.since(now).as_seconds()) + LEAVE_S)
            }
            (_, Some(lease)) => {
                let robot = self.robots.get(&lease.name.robot)?;
                let seen = self.observed.robots.get(&robot.id)?;
                let way = seen.ways.as_ref().and_then(|(_, ways)| ways.get(&pile.id));
                let drive_s = way.map_or(0.0, |way| self.drive_s(robot, way.length));
                let planned = charge::planned_time([lease.energy], pile.power_w, PILE.eta);
                Some(drive_s + f64::from(planned.as_seconds()) + LEAVE_S)
            }
            (_, None) => Some(0.0),
        }
    }

    /// What a pile can be used for: what it reports, and what was promised since.
    pub(super) fn availability(&self, pile: PileId, now: SiteMillis) -> Option<Availability> {
        let reported = self.observed.report(pile, now)?.row.availability;
        let promised = self.state.next(pile).is_some();
        let lease = self.state.lease(pile);
        Some(match reported {
            // By the word of a robot that its reader does not see.
            Availability::Free if self.contradicted(pile).is_some() => Availability::Done,
            Availability::Free if lease.is_some() || promised => Availability::Reserved,
            Availability::Charging if promised || lease.is_some_and(|lease| !lease.is_wanted()) => {
                Availability::Reserved
            }
            reported => reported,
        })
    }

    /// What a pile can be used for by one robot: it may stand there without a lease, where nobody else can be.
    pub(super) fn availability_for(
        &self,
        robot: RobotId,
        pile: PileId,
        now: SiteMillis,
    ) -> Option<Availability> {
        let unpromised = self.state.lease(pile).is_none() && self.state.next(pile).is_none();
        if unpromised && self.stands_at(robot, pile, now) {
            return Some(Availability::Free);
        }
        self.availability(pile, now)
    }

    /// Whether an occupied pile can be promised to a robot. One whose robot is charged is free soon, or
    /// nobody knows when: it is not.
    fn next_is_open(&self, pile: PileId, now: SiteMillis) -> bool {
        let occupied =
            matches!(self.availability(pile, now), Some(Availability::Charging | Availability::Reserved));
        let wanted = self.state.lease(pile).is_none_or(|lease| lease.is_wanted());
        occupied && wanted && self.state.next(pile).is_none() && self.contradicted(pile).is_none()
    }

    /// A robot's ways to all piles; none from a place where no robot can be.
    fn ways(&mut self, turn: &mut Turn, robot: RobotId, position: Position) -> Arc<Ways> {
        let Some(cell) = self.site.cell_of(position).filter(|cell| self.site.grid.is_free(*cell)) else {
            turn.warn(format!(
                "robot {robot} says that it stands in a wall or outside the map, where no way begins: \
                 is its localisation lost?"
            ));
            return Arc::default();
        };
        self.ways_from(robot, cell)
    }

    /// A robot's ways from the free cell where it is.
    pub(super) fn ways_from(&mut self, robot: RobotId, cell: Cell) -> Arc<Ways> {
        let known = self.observed.robots.get(&robot).and_then(|seen| seen.ways.clone());
        if let Some((_, ways)) = known.filter(|(of, _)| *of == cell) {
            return ways;
        }
        let ways = Arc::new(self.routes.ways(cell));
        self.observed.robots.entry(robot).or_default().ways = Some((cell, Arc::clone(&ways)));
        ways
    }
}
