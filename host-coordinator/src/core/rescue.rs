//! Help for robots that can't come to a pile (the papers' empty set): a mobile charger, else a tow.
//!
//! ```text
//!  stranded, or no pile in reach
//!        |
//!     Queued <--------------- the charger can't, strands, or is late
//!        | a charger is free             |
//!       Sent ----------------------------'
//!        | it has given enough      no charger ever can, three have failed, or ten minutes in the queue
//!        v                               |
//!      ended <--- a person says that it  v
//!                 was moved ----------- Tow
//! ```
//! Help that is wanted is never dropped: it is in the log, in one of these stages, until the robot was
//! charged, was moved by a person, or needs none any more because it moves or a pile came into its reach. The
//! robot's request for a charge stays where it was and is decided anew then. Every stage but a person's ends by
//! itself: chargers that don't come do so by a time, and the queue by another, after which a tow is wanted.
//!
//! Those who wait longest are served first, each by the free charger that is nearest by its way.

use planning::{
    grid::Cell,
    search::{AStar, Planner as _, Workspace},
};
use protocol::{
    CommandId, DeviceId, DurationMs, EnergyJ, Message, Nack, NackReason, Position, Reference, Rescue,
    RescuePhase, RescueState, RobotId, SiteMillis, limits,
};

use super::{
    ROBOT_PATIENCE,
    coordinator::Coordinator,
    event::{Fact, Freed, HelpEnd, Plight, TowReason},
    profile::SPREADS,
    routes::{Part, parts},
    situation::RESERVE,
    state::{Help, HelpStage, Sortie},
    turn::Turn,
};
use crate::config::RobotConfig;

/// A robot that no charger has set off for after this long is to be towed.
const QUEUE_PATIENCE: DurationMs = DurationMs(600_000);
/// So many chargers may fail before a robot is to be towed.
const TRIES: u8 = 3;
/// A robot is given so much more than it needs to the nearest pile, as a share of a full battery: that pile
/// may be taken.
const SPARE: f64 = 0.1;
/// A charger may take so much longer than planned, and this many times its drive.
const LATE: (DurationMs, f64) = (DurationMs(120_000), 2.0);

/// What was said to a mobile charger, and by it, since the start.
#[derive(Clone, Debug)]
pub struct Errand {
    /// Which rescue this is about.
    command: CommandId,
    /// The way it was sent.
    waypoints: Vec<Position>,
    /// When it was told last.
    told_at: Option<SiteMillis>,
    /// When it last said that it is about it.
    heard_at: Option<SiteMillis>,
}

/// A charger that can be sent to a robot.
struct Found {
    charger: RobotId,
    /// The length of its way, in cells.
    length: f64,
    /// What to give.
    energy: EnergyJ,
}

/// Whether a charger can be sent.
enum Readiness {
    /// Now, by a way of so many cells.
    Now(f64),
    /// Perhaps later: it is busy, has too little energy, or is silent.
    Later,
    /// Not at all, as things are.
    Never,
}

/// What a robot needs.
struct Need {
    cell: Cell,
    /// What it is to be given.
    energy: EnergyJ,
    /// How far it is from there to the nearest pile, in cells.
    to_pile: f64,
}

impl Coordinator {
    /// Notes that a robot needs help; once, however often it is found.
    pub(super) fn want_help(&mut self, turn: &mut Turn, robot: RobotId, plight: Plight) {
        let seen = self.observed.robots.get(&robot);
        let Some((position, _)) = seen.and_then(|seen| seen.last) else { return };
        // It may take a moment until it says that help has come.
        let just_helped = seen
            .and_then(|seen| seen.helped_at)
            .is_some_and(|helped| turn.now.since(helped) <= ROBOT_PATIENCE);
        if just_helped || self.state.helps.contains_key(&robot) {
            return;
        }
        self.record(turn, Fact::HelpWanted { robot, position, plight });
        self.observed.help_is_due = true;
    }

    /// A pile is in reach of a robot that asks: it needs no help, unless it gets some just now.
    pub(super) fn call_help_off(&mut self, turn: &mut Turn, robot: RobotId) {
        if self.state.helps.get(&robot).is_some_and(|help| !help.is_charging()) {
            // The queue is being served.
            self.record(turn, Fact::HelpEnded { robot, why: HelpEnd::NotNeeded });
            self.observed.help_is_due = true;
        }
    }

    /// A robot that was to be towed was moved.
    pub(super) fn end_tow(&mut self, turn: &mut Turn, robot: RobotId, to: Option<Position>) {
        if let Some((position, _)) = self.observed.robots.get_mut(&robot).and_then(|seen| seen.last.as_mut())
        {
            *position = to.unwrap_or(*position);
        }
        self.end_help(turn, robot, HelpEnd::Towed { to });
    }

    /// A mobile charger says how far it is.
    pub(super) fn hear_rescue(&mut self, turn: &mut Turn, charger: RobotId, report: RescueState) {
        let RescueState { rescue, phase, given } = report;
        let wanted = self.state.helps.iter().find_map(|(robot, help)| {
            let sortie =
                help.sortie().filter(|sortie| (sortie.charger, sortie.command) == (charger, rescue))?;
            Some((*robot, *sortie))
        });
        let let_go = |turn: &mut Turn| {
            let of = Reference::Command(rescue);
            turn.send(DeviceId::Robot(charger), Message::Nack(Nack { of, reason: NackReason::Ended }));
        };
        let Some((robot, sortie)) = wanted else {
            let_go(turn);
            return;
        };
        if let Some(errand) = self.errand(&sortie) {
            errand.heard_at = Some(turn.now);
        }
        match phase {
            RescuePhase::Driving => {}
            RescuePhase::Charging if sortie.charging => {}
            RescuePhase::Charging => self.record(turn, Fact::ChargerArrived { robot }),
            RescuePhase::Done => {
                self.end_help(turn, robot, HelpEnd::Charged { energy: given });
                let_go(turn);
            }
            RescuePhase::GaveUp => {
                self.free_charger(turn, robot, Freed::GaveUp);
                let_go(turn);
            }
        }
    }

    /// Does what is due for the robots that get help, and notes which others have stranded.
    pub(super) fn tend_help(&mut self, turn: &mut Turn) {
        let helpless: Vec<_> = self.state.stranded.iter().copied().collect();
        for robot in helpless {
            self.want_help(turn, robot, Plight::Stranded);
        }
        let helped: Vec<_> = self.state.helps.iter().map(|(robot, help)| (*robot, *help)).collect();
        for (robot, help) in helped {
            if self.is_over(robot, &help) {
                self.end_help(turn, robot, HelpEnd::NotNeeded);
            } else if let Some(sortie) = help.sortie() {
                match self.reason_to_free(sortie, turn.now) {
                    Some(why) => self.free_charger(turn, robot, why),
                    None => self.tell_charger(turn, robot, sortie),
                }
            }
        }
    }

    /// Whether a robot moves again without having been helped.
    fn is_over(&self, robot: RobotId, help: &Help) -> bool {
        let waits = self.state.requests.contains_key(&robot);
        let helpless = self.state.stranded.contains(&robot) || (help.plight == Plight::OutOfReach && waits);
        !self.robots.contains_key(&robot) || (!helpless && !help.is_charging())
    }

    fn reason_to_free(&self, sortie: &Sortie, now: SiteMillis) -> Option<Freed> {
        if self.state.stranded.contains(&sortie.charger) {
            Some(Freed::Stranded)
        } else if self.state.requests.contains_key(&sortie.charger) {
            Some(Freed::Asks)
        } else {
            (now > sortie.until).then_some(Freed::Late)
        }
    }

    fn free_charger(&mut self, turn: &mut Turn, robot: RobotId, why: Freed) {
        self.record(turn, Fact::ChargerFreed { robot, why });
        self.observed.help_is_due = true;
        if self.state.helps.get(&robot).is_some_and(|help| help.failures >= TRIES) {
            self.want_tow(turn, robot, TowReason::GaveUp);
        }
    }

    fn end_help(&mut self, turn: &mut Turn, robot: RobotId, why: HelpEnd) {
        self.record(turn, Fact::HelpEnded { robot, why });
        if !matches!(why, HelpEnd::NotNeeded) {
            self.observed.robots.entry(robot).or_default().helped_at = Some(turn.now);
        }
        self.observed.queue_is_due = true;
        self.observed.help_is_due = true;
    }

    fn want_tow(&mut self, turn: &mut Turn, robot: RobotId, why: TowReason) {
        self.record(turn, Fact::TowWanted { robot, why });
        turn.warn(format!("robot {robot} has to be towed: {why}; say so on the dashboard when it was moved"));
    }

    /// Finds a charger for every robot in the queue, those first who have waited longest, at every change and
    /// every second.
    pub(super) fn serve_helpless(&mut self, turn: &mut Turn) {
        let observed = &mut self.observed;
        if !observed.help_is_due && turn.now.since(observed.helped_at) < limits::REPEAT_INTERVAL {
            return;
        }
        (observed.help_is_due, observed.helped_at) = (false, turn.now);
        let queued = self.state.helps.iter().filter(|(_, help)| matches!(help.stage, HelpStage::Queued));
        let mut queued: Vec<_> = queued.map(|(robot, help)| (help.since, *robot, help.position)).collect();
        queued.sort_by_key(|(since, robot, _)| (*since, *robot));
        for (since, robot, position) in queued {
            // A clock that was set back makes nobody wait longer than since our start.
            let waited = turn.now.since(since.min(self.observed.started));
            match self.charger_for(robot, position, turn.now) {
                Ok(Some(found)) => self.send_charger(turn, robot, &found),
                Ok(None) if waited <= QUEUE_PATIENCE => {}
                Ok(None) => self.want_tow(turn, robot, TowReason::Waited),
                Err(why) => self.want_tow(turn, robot, why),
            }
        }
    }

    /// The free charger with the shortest way to a robot; none if one may come later.
    fn charger_for(
        &self,
        robot: RobotId,
        position: Position,
        now: SiteMillis,
    ) -> Result<Option<Found>, TowReason> {
        let need = self.need(robot, position).ok_or(TowReason::NoWay)?;
        let chargers = self.robots.values().filter(|one| one.gives_w.is_some() && one.id != robot);
        let readiness: Vec<_> =
            chargers.map(|charger| (charger.id, self.readiness(charger, &need, now))).collect();
        if readiness.is_empty() {
            return Err(TowReason::NoCharger);
        }
        if readiness.iter().all(|(_, readiness)| matches!(readiness, Readiness::Never)) {
            return Err(TowReason::OutOfChargersReach);
        }
        let ready = readiness.into_iter().filter_map(|(charger, readiness)| match readiness {
            Readiness::Now(length) => Some(Found { charger, length, energy: need.energy }),
            Readiness::Later | Readiness::Never => None,
        });
        Ok(ready.min_by(|one, other| one.length.total_cmp(&other.length)))
    }

    /// What a robot needs to get to a pile; none where no way leads to any.
    fn need(&self, robot: RobotId, position: Position) -> Option<Need> {
        let config = self.robots.get(&robot)?;
        let seen = self.observed.robots.get(&robot);
        let (position, held) = seen.and_then(|seen| seen.last).unwrap_or((position, EnergyJ::MIN));
        let cell = self.site.cell_of(position).filter(|cell| self.site.grid.is_free(*cell))?;
        let ways = self.routes.ways(cell);
        let to_pile = ways.values().map(|way| way.length).min_by(f64::total_cmp)?;
        let full_j = f64::from(config.full.get());
        let wanted_j = to_pile * self.cell_j(config) + (RESERVE + SPARE) * full_j;
        let energy_j = wanted_j.min(full_j) - f64::from(held.get());
        Some(Need { cell, energy: EnergyJ::clamped(energy_j as f32), to_pile })
    }

    /// What a robot takes for a cell of way at most, in joules.
    fn cell_j(&self, config: &RobotConfig) -> f64 {
        let consumption = self.observed.robots.get(&config.id).map(|seen| seen.consumption);
        let (per_metre_j, spread_j) = consumption.unwrap_or_default().estimate(config.energy_per_metre_j);
        self.site.resolution_m * (per_metre_j + SPREADS * spread_j)
    }

    fn readiness(&self, charger: &RobotConfig, need: &Need, now: SiteMillis) -> Readiness {
        if self.state.stranded.contains(&charger.id) {
            return Readiness::Never;
        }
        let Some((position, held)) = self.observed.robots.get(&charger.id).and_then(|seen| seen.last) else {
            return Readiness::Later;
        };
        let way = self.site.cell_of(position).and_then(|from| self.way(from, need.cell));
        let Some((length, _)) = way else { return Readiness::Never };
        let full_j = f64::from(charger.full.get());
        let driving_j = (length + need.to_pile) * self.cell_j(charger);
        let needed_j = driving_j + f64::from(need.energy.get()) + RESERVE * full_j;
        if needed_j > full_j {
            return Readiness::Never;
        }
        let is_free = !self.observed.robot_is_silent(charger.id, now)
            && !self.state.requests.contains_key(&charger.id)
            && !self.state.helps.contains_key(&charger.id)
            && !self
                .state
                .helps
                .values()
                .any(|help| help.sortie().is_some_and(|one| one.charger == charger.id));
        if is_free && needed_j <= f64::from(held.get()) { Readiness::Now(length) } else { Readiness::Later }
    }

    /// The shortest way between any two cells: a charger may use every door.
    fn way(&self, from: Cell, to: Cell) -> Option<(f64, Vec<Cell>)> {
        let mut workspace = Workspace::default();
        let plan = AStar::new(&self.site.grid, self.site.moves).plan(from, to, &mut workspace).ok()?;
        Some((plan.path.length().units(), plan.path.waypoints().to_vec()))
    }

    /// Decides on a charger; it is told at once.
    fn send_charger(&mut self, turn: &mut Turn, robot: RobotId, found: &Found) {
        let Some(config) = self.robots.get(&found.charger) else { return };
        let charge_s = f64::from(found.energy.get()) / f64::from(config.gives_w.unwrap_or(f32::INFINITY));
        let planned_s = LATE.1 * self.drive_s(config, found.length) + charge_s;
        let sortie = Sortie {
            charger: found.charger,
            command: self.state.next_command,
            energy: found.energy,
            until: turn.now.after(LATE.0).after(DurationMs::from_seconds(planned_s as f32)),
            charging: false,
        };
        self.record(
            turn,
            Fact::ChargerSent {
                robot,
                charger: sortie.charger,
                command: sortie.command,
                energy: sortie.energy,
                until: sortie.until,
            },
        );
        self.tell_charger(turn, robot, &sortie);
    }

    /// Tells a charger of its rescue until it says that it is about it, and again after a start of either.
    fn tell_charger(&mut self, turn: &mut Turn, robot: RobotId, sortie: &Sortie) {
        let now = turn.now;
        let known = self.errand(sortie).is_some();
        if !known && !self.plan_errand(robot, sortie) {
            return;
        }
        let Some(errand) = self.errand(sortie) else { return };
        let about_it = errand.heard_at.is_some_and(|heard| now.since(heard) <= limits::SILENCE);
        let told = errand.told_at.is_some_and(|told| now.since(told) < limits::REPEAT_INTERVAL);
        if about_it || told {
            return;
        }
        errand.told_at = Some(now);
        for Part { total, first, waypoints } in parts(&errand.waypoints) {
            let Sortie { command: rescue, energy, .. } = *sortie;
            let rescue = Rescue { rescue, robot, energy, total, first, waypoints };
            turn.send(DeviceId::Robot(sortie.charger), Message::Rescue(rescue));
        }
    }

    fn errand(&mut self, sortie: &Sortie) -> Option<&mut Errand> {
        let errand = self.observed.robots.get_mut(&sortie.charger)?.errand.as_mut()?;
        (errand.command == sortie.command).then_some(errand)
    }

    /// Plans a charger's way from where it is now. False before it was heard, when nobody knows where that
    /// is, and where no way leads any more: then it will be late.
    fn plan_errand(&mut self, robot: RobotId, sortie: &Sortie) -> bool {
        let at = |robot| self.observed.robots.get(&robot)?.last.map(|(position, _)| position);
        let goal = at(robot).or(self.state.helps.get(&robot).map(|help| help.position));
        let ends = at(sortie.charger).zip(goal);
        let way = ends.and_then(|(from, to)| self.way(self.site.cell_of(from)?, self.site.cell_of(to)?));
        let Some((_, cells)) = way else { return false };
        let mut waypoints: Vec<_> = cells.iter().map(|cell| self.site.position(*cell)).collect();
        waypoints.extend(goal);
        let errand = Errand { command: sortie.command, waypoints, told_at: None, heard_at: None };
        self.observed.robots.entry(sortie.charger).or_default().errand = Some(errand);
        true
    }
}
