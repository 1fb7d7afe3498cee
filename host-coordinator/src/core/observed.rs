//! What the coordinator has heard since it started: reports, who is silent, what was said when.
//!
//! None of this is in the event log. The world repeats it within seconds of a restart.

use std::{collections::BTreeMap, sync::Arc};

use planning::grid::Cell;
use protocol::{
    Activity, BootEpoch, DeviceId, DurationMs, EnergyJ, Header, PileId, PileState, Position, RequestId,
    RobotId, RobotState, Sequence, SiteMillis, limits,
};

use super::{consumption::Consumption, contradictions::Seen, rescue::Errand, routes::Ways};

/// A device that was silent for this long is lost, and what it was promised is given to others. One that is
/// silent but not lost may only be cut off, and goes on as it was told.
pub const LOST: DurationMs = DurationMs(60_000);

/// Everything heard.
#[derive(Debug, Default)]
pub struct Observed {
    /// When this coordinator started.
    pub started: SiteMillis,
    /// Of the piles.
    pub piles: BTreeMap<PileId, SeenPile>,
    /// Of the robots.
    pub robots: BTreeMap<RobotId, SeenRobot>,
    /// Whether anything changed that may help a robot in the queue.
    pub queue_is_due: bool,
    /// When it was last looked who needs a charge.
    pub called_at: SiteMillis,
    /// When the queue was last served.
    pub queue_served_at: SiteMillis,
    /// When what piles and robots say was last compared.
    pub compared_at: SiteMillis,
    /// Whether anything changed that may help a robot that can't come to a pile.
    pub help_is_due: bool,
    /// When those were last served.
    pub helped_at: SiteMillis,
}

/// The frames of one device.
#[derive(Clone, Copy, Debug, Default)]
pub struct Contact {
    /// When it was last heard.
    pub heard: Option<SiteMillis>,
    /// Whether it got our Hello since we started.
    pub greeted: bool,
    newest: Option<(BootEpoch, Sequence)>,
    distrusted: Option<Distrusted>,
}

/// A device whose frames do not authenticate.
#[derive(Clone, Copy, Debug)]
struct Distrusted {
    since: SiteMillis,
    greeted_at: SiteMillis,
}

/// What is to be done about a frame that does not authenticate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Distrust {
    /// To say Hello: the device may not know of our start.
    pub greet: bool,
    /// To tell the operator: it should have known by now.
    pub warn: bool,
}

/// Whether a frame says anything new.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Freshness {
    /// The first frame of a start of the device.
    FirstOfBoot,
    /// Newer than all before.
    Newer,
    /// A repeat of the network, or late. Everything worth saying is said again, so it is dropped.
    Old,
    /// Of an earlier start of the device than one that was heard.
    OldBoot,
}

/// What was heard of a pile.
#[derive(Clone, Copy, Debug, Default)]
pub struct SeenPile {
    /// Its frames.
    pub contact: Contact,
    /// Its last report since its start.
    pub report: Option<PileState>,
    /// Since when it has reported the availability of its last report.
    pub since: SiteMillis,
    /// When it was last sent a command.
    pub commanded_at: Option<SiteMillis>,
    /// What it and a robot say that cannot both be right, and since when.
    pub contradiction: Option<(Seen, SiteMillis)>,
}

/// What was heard of a robot.
#[derive(Clone, Debug, Default)]
pub struct SeenRobot {
    /// Its frames.
    pub contact: Contact,
    /// Its last report.
    pub report: Option<RobotState>,
    /// When that came.
    reported_at: SiteMillis,
    /// Where it was last, and what its battery held.
    pub last: Option<(Position, EnergyJ)>,
    /// Whether it did anything but work since it asked.
    pub left_work: bool,
    /// Since when it has said nothing but that it works.
    pub working_since: Option<SiteMillis>,
    /// Whether it was called to charge, and has said nothing since but that it works.
    pub called: bool,
    /// What it was last told, and when.
    pub told: Option<(Told, SiteMillis)>,
    /// The route of its assignment.
    pub route: Option<Route>,
    /// Its ways to all piles from the cell where it was when they were last wanted.
    pub ways: Option<(Cell, Arc<Ways>)>,
    /// What it was seen to take for a metre.
    pub consumption: Consumption,
    /// When it was last helped.
    pub helped_at: Option<SiteMillis>,
    /// What it was told to do as a mobile charger.
    pub errand: Option<Errand>,
}

/// What a robot can be told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Told {
    /// Go to a pile.
    Go(PileId),
    /// Wait.
    Wait,
}

/// A route as it was sent.
#[derive(Clone, Debug, PartialEq)]
pub struct Route {
    /// The request it answers.
    pub request: RequestId,
    /// Where it leads.
    pub pile: PileId,
    /// The cells where it turns, both ends included.
    pub cells: Vec<Cell>,
    /// The same in metres.
    pub waypoints: Vec<Position>,
}

impl Contact {
    /// Takes note of a frame's header.
    pub fn hear(&mut self, now: SiteMillis, header: Header) -> Freshness {
        let freshness = match self.newest {
            Some((boot, _)) if header.boot < boot => Freshness::OldBoot,
            Some((boot, newest)) if header.boot == boot => {
                // Sequences wrap around.
                let ahead = header.sequence.0.wrapping_sub(newest.0);
                if ahead == 0 || ahead > u32::MAX / 2 { Freshness::Old } else { Freshness::Newer }
            }
            _ => Freshness::FirstOfBoot,
        };
        if matches!(freshness, Freshness::FirstOfBoot | Freshness::Newer) {
            self.newest = Some((header.boot, header.sequence));
            self.heard = Some(now);
            self.distrusted = None;
        }
        freshness
    }

    /// A frame that says it is of this device does not authenticate.
    pub fn distrust(&mut self, now: SiteMillis) -> Distrust {
        let Some(distrusted) = &mut self.distrusted else {
            self.distrusted = Some(Distrusted { since: now, greeted_at: now });
            // Whoever was heard in this start knows of it.
            return Distrust { greet: true, warn: self.heard.is_some() };
        };
        let greet = now.since(distrusted.greeted_at) >= limits::REPEAT_INTERVAL;
        if greet {
            distrusted.greeted_at = now;
        }
        Distrust { greet, warn: now.since(distrusted.since) >= limits::SILENCE }
    }

    /// The device's start that was heard last.
    #[must_use]
    pub fn boot(&self) -> Option<BootEpoch> {
        self.newest.map(|(boot, _)| boot)
    }
}

impl Observed {
    /// The frames of a device, if it is of a kind that the coordinator talks to.
    pub fn contact(&mut self, device: DeviceId) -> Option<&mut Contact> {
        match device {
            DeviceId::Pile(pile) => Some(&mut self.piles.entry(pile).or_default().contact),
            DeviceId::Robot(robot) => Some(&mut self.robots.entry(robot).or_default().contact),
            DeviceId::Coordinator | DeviceId::Chassis(_) | DeviceId::Service | DeviceId::Factory => None,
        }
    }

    /// Whether a device was silent for too long. Before its first frame the time since our start
    /// counts.
    #[must_use]
    pub fn is_silent(&self, contact: Option<&Contact>, now: SiteMillis) -> bool {
        self.silence(contact, now) > limits::SILENCE
    }

    fn silence(&self, contact: Option<&Contact>, now: SiteMillis) -> DurationMs {
        now.since(contact.and_then(|contact| contact.heard).unwrap_or(self.started))
    }

    /// Whether a pile was silent for too long.
    #[must_use]
    pub fn pile_is_silent(&self, pile: PileId, now: SiteMillis) -> bool {
        self.is_silent(self.piles.get(&pile).map(|seen| &seen.contact), now)
    }

    /// Whether a robot was silent for too long.
    #[must_use]
    pub fn robot_is_silent(&self, robot: RobotId, now: SiteMillis) -> bool {
        self.is_silent(self.robots.get(&robot).map(|seen| &seen.contact), now)
    }

    /// Whether a pile has been silent for so long that nobody waits for it any more.
    #[must_use]
    pub fn pile_is_lost(&self, pile: PileId, now: SiteMillis) -> bool {
        self.silence(self.piles.get(&pile).map(|seen| &seen.contact), now) > LOST
    }

    /// Whether a robot has been silent for so long that nothing is kept for it any more.
    #[must_use]
    pub fn robot_is_lost(&self, robot: RobotId, now: SiteMillis) -> bool {
        self.silence(self.robots.get(&robot).map(|seen| &seen.contact), now) > LOST
    }

    /// A pile's report, unless it was silent for too long since.
    #[must_use]
    pub fn report(&self, pile: PileId, now: SiteMillis) -> Option<&PileState> {
        let seen = self.piles.get(&pile)?;
        seen.report.as_ref().filter(|_| !self.is_silent(Some(&seen.contact), now))
    }
}

impl SeenRobot {
    /// Takes a report in.
    pub fn hear(&mut self, now: SiteMillis, report: RobotState) {
        if let Some(before) = self.report {
            self.consumption.learn(&before, &report, now.since(self.reported_at));
        }
        self.reported_at = now;
        self.last = Some((report.position, report.energy));
        if report.activity == Activity::Working {
            self.working_since.get_or_insert(now);
        } else {
            self.working_since = None;
            self.left_work = true;
            self.called = false;
        }
        self.report = Some(report);
    }
}
