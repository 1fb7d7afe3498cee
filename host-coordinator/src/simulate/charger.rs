//! What makes a robot a mobile charger: it drives to a robot that can't come to a pile, charges it, and
//! comes back. Pure; the robot that it is a part of ([`robot`](super::robot)) drives, speaks, and charges itself.

use protocol::{CommandId, DurationMs, EnergyJ, Millis, Rescue, RescuePhase, RescueState, RobotId, limits};

use super::{
    ground::{Point, Route},
    parts::Parts,
    world::Sensed,
};

/// How long it looks for a robot that is not where it should be.
const PATIENCE: DurationMs = DurationMs(10_000);

/// A mobile charger's coupling and what it is about.
#[derive(Debug)]
pub struct Charger {
    /// What it gives, in watts.
    power_w: f64,
    /// It gives nothing when it has no more than this itself, in joules.
    keep_j: f64,
    /// Where it stands by.
    home: Point,
    /// The highest number it has set off for.
    newest: Option<CommandId>,
    parts: Option<Parts<CommandId>>,
    job: Option<Job>,
    said: Option<(RescuePhase, Millis)>,
}

/// A rescue.
#[derive(Clone, Copy, Debug)]
struct Job {
    rescue: CommandId,
    robot: RobotId,
    energy_j: f64,
    phase: RescuePhase,
    given_j: f64,
    /// Since when it waits for the robot, or until when it has given.
    since: Option<Millis>,
}

impl Charger {
    /// A charger that stands by at `home`, gives `power_w` watts, and keeps `keep_j` joules for itself.
    #[must_use]
    pub const fn new(home: Point, power_w: f64, keep_j: f64) -> Self {
        Self { power_w, keep_j, home, newest: None, parts: None, job: None, said: None }
    }

    /// Where it stands by.
    #[must_use]
    pub const fn home(&self) -> Point {
        self.home
    }

    /// Whom it is to charge.
    #[must_use]
    pub fn partner(&self) -> Option<RobotId> {
        self.job.map(|job| job.robot)
    }

    /// Whether it gives energy.
    #[must_use]
    pub fn gives(&self) -> bool {
        self.job.is_some_and(|job| job.phase == RescuePhase::Charging)
    }

    /// Whether it is to drive.
    #[must_use]
    pub fn drives(&self) -> bool {
        self.job.is_some_and(|job| job.phase == RescuePhase::Driving)
    }

    /// Takes a part of a rescue; answers the route when it is the last of a new one.
    pub fn take(&mut self, part: &Rescue) -> Option<Route> {
        if self.newest.is_some_and(|newest| part.rescue <= newest) {
            return None;
        }
        if !self.parts.as_ref().is_some_and(|parts| parts.is(&part.rescue, part.total)) {
            self.parts = Some(Parts::new(part.rescue, part.total));
        }
        let route = self.parts.as_mut()?.add(part.first, &part.waypoints)?;
        self.parts = None;
        self.newest = Some(part.rescue);
        self.said = None;
        self.job = Some(Job {
            rescue: part.rescue,
            robot: part.robot,
            energy_j: part.energy.get().into(),
            phase: RescuePhase::Driving,
            given_j: 0.0,
            since: None,
        });
        Some(route)
    }

    /// Lets go of a rescue. False if it is about another one, or none.
    pub fn let_go(&mut self, rescue: CommandId) -> bool {
        self.job.take_if(|job| job.rescue == rescue).is_some()
    }

    /// Lets go of whatever it is about.
    pub const fn abandon(&mut self) {
        self.job = None;
    }

    /// Takes what was sensed by `now`.
    pub fn step(&mut self, now: Millis, sensed: &Sensed) {
        let Some(job) = &mut self.job else { return };
        match job.phase {
            RescuePhase::Driving if sensed.arrived => {
                let since = *job.since.get_or_insert(now);
                if sensed.partner {
                    (job.phase, job.since) = (RescuePhase::Charging, Some(now));
                } else if now.since(since) > PATIENCE {
                    job.phase = RescuePhase::GaveUp;
                }
            }
            RescuePhase::Charging => {
                let until = job.since.replace(now).unwrap_or(now);
                job.given_j += self.power_w * f64::from(now.since(until).0) / 1e3;
                if job.given_j >= job.energy_j {
                    job.phase = RescuePhase::Done;
                } else if !sensed.partner || sensed.energy_j <= self.keep_j {
                    job.phase = RescuePhase::GaveUp;
                }
            }
            RescuePhase::Driving | RescuePhase::Done | RescuePhase::GaveUp => {}
        }
    }

    /// What it has to say.
    pub fn speak(&mut self, now: Millis) -> Option<RescueState> {
        let job = self.job?;
        let said =
            self.said.is_some_and(|(phase, at)| phase == job.phase && now.since(at) < limits::STATE_INTERVAL);
        if said {
            return None;
        }
        self.said = Some((job.phase, now));
        let given = EnergyJ::clamped(job.given_j as f32);
        Some(RescueState { rescue: job.rescue, phase: job.phase, given })
    }
}
