//! What a person sees of the site: the rows of `GET /api/v1/state`.
//!
//! Coordinates are cells of the map's picture: from 0, x to the right, y down; a robot's are
//! fractional. Times are milliseconds of the site's clock.

use std::sync::Arc;

use protocol::{Activity, Availability, EndReason, FaultCode, PileId, RobotId, SiteMillis};
use serde::{Serialize, Serializer};

pub use super::site_view::{DoorView, FrameView, SiteView, SubareaView};
use super::{
    coordinator::Coordinator,
    decision::Decision,
    event::{Contradiction, Plight},
    state::{Charge, Help, HelpStage, Lease, Phase, Place},
};
use crate::{config::RobotConfig, site::SitePile};

/// The whole picture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct View {
    /// What does not change while the coordinator runs.
    #[serde(serialize_with = "shared")]
    pub site: Arc<SiteView>,
    /// The site's time.
    pub now_ms: u64,
    /// The coordinator's epoch.
    pub epoch: u32,
    /// Whether frames have no keys: whoever can reach the site's network can command it.
    pub insecure: bool,
    /// Why the coordinator can't record anything and so does nothing; `None` if all is well.
    pub degraded: Option<String>,
    /// Trouble an operator should know of, newest first.
    pub warnings: Vec<String>,
    /// The piles, by number.
    pub piles: Vec<PileView>,
    /// The robots, by number.
    pub robots: Vec<RobotView>,
    /// The robots that can't come to a pile, by number, and their help.
    pub helps: Vec<HelpView>,
    /// The newest decisions, newest first.
    pub decisions: Vec<Decision>,
    /// The newest charges, newest first.
    pub charges: Vec<ChargeView>,
    /// Sums since the event log began.
    pub totals: TotalsView,
}

/// One pile.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PileView {
    /// Its number.
    pub id: PileId,
    /// Its cell.
    pub at: [i32; 2],
    /// `free`, `reserved`, `charging`, `done`, `fault`, or `unknown` when it was silent for long.
    pub availability: &'static str,
    /// The share of the planned charge still ahead (LMPP eq. 1).
    pub remaining: f32,
    /// The planned time of the charge in seconds (eq. 2).
    pub planned_s: f32,
    /// How long the charge has run, in seconds.
    pub elapsed_s: f32,
    /// Whether its contacts are live.
    pub energised: bool,
    /// Who holds it: by its own report, or by a lease it has not confirmed yet.
    pub holder: Option<RobotId>,
    /// The lease that is or may be alive on it.
    pub lease: Option<LeaseView>,
    /// Who is promised it next.
    pub next: Option<RobotId>,
    /// `reader_silent`, `contactor_welded`, `contactor_stuck_open`.
    pub faults: Vec<&'static str>,
    /// What it and a robot say that cannot both be right, if that lasts.
    pub contradiction: Option<ContradictionView>,
}

/// What a pile and a robot say that cannot both be right.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct ContradictionView {
    /// `unleased`, `no_current`, `not_docked`.
    pub what: Contradiction,
    /// Which robot, if that is known.
    pub robot: Option<RobotId>,
    /// Since when.
    pub since_ms: u64,
}

/// A lease.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct LeaseView {
    /// Its number.
    pub id: u32,
    /// The epoch of the coordinator that granted or extended it last.
    pub epoch: u32,
    /// Whether the pile made it for itself, while it heard no coordinator.
    pub local: bool,
    /// Whose it is.
    pub robot: RobotId,
    /// When it runs out unless extended.
    pub expiry_ms: u64,
    /// `offered`, `held`, `refused`, `revoking`.
    pub phase: &'static str,
}

/// A charge that is over.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ChargeView {
    /// Counts the charges.
    pub id: u64,
    /// At which pile.
    pub pile: PileId,
    /// Who was charged.
    pub robot: RobotId,
    /// The lease.
    pub lease: u32,
    /// `completed`, `expired`, `revoked`, `robot_left`, `fault`; `restarted` if the pile lost its
    /// power, so that nobody knows what it gave.
    pub end: &'static str,
    /// When it began.
    pub began_ms: u64,
    /// When it was over, if the pile knows.
    pub ended_ms: Option<u64>,
    /// For how long the contacts were live, in seconds.
    pub charged_s: f32,
    /// What went over the contacts, in joules.
    pub energy_j: f32,
}

/// One robot.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RobotView {
    /// Its number.
    pub id: RobotId,
    /// Where it is; `None` until it says so.
    pub at: Option<[f64; 2]>,
    /// The share of its full battery that it has, 0 to 1.
    pub battery: f32,
    /// The same in joules.
    pub energy_j: f32,
    /// `working`, `waiting`, `approaching`, `docked`, `charging`, `stranded`, or `unknown` when it was silent
    /// for long.
    pub activity: &'static str,
    /// The pile that it is to use.
    pub pile: Option<PileId>,
    /// The cells where its way there turns.
    pub route: Vec<[i32; 2]>,
}

/// A robot that can't come to a pile, and its help.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HelpView {
    /// Which robot.
    pub robot: RobotId,
    /// Since when.
    pub since_ms: u64,
    /// `stranded`, or `out_of_reach`: no pile is.
    pub plight: &'static str,
    /// `queued`: it waits for a mobile charger; `coming`: one is on its way; `charging`: one charges it;
    /// `tow`: people have to move it, and say so by `POST /api/v1/tows/{robot}`.
    pub stage: &'static str,
    /// The mobile charger.
    pub charger: Option<RobotId>,
    /// Why people have to move it.
    pub reason: Option<String>,
}

/// Sums since the event log began.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TotalsView {
    /// Requests.
    pub requests: u64,
    /// Charges that were given in full.
    pub charges_completed: u64,
    /// The power of all piles that draw any, or may, in watts.
    pub granted_w: f64,
    /// No more is given, if there is a cap.
    pub power_cap_w: Option<f64>,
    /// Charges that were cut short for a critical robot.
    pub preempted: u64,
    /// What all charges gave, as the piles measured it, in joules.
    pub energy_j: f64,
    /// The mean time from first asking to a pile's acceptance, in seconds.
    pub mean_wait_s: f64,
    /// The longest of those.
    pub worst_wait_s: f64,
    /// Robots in the queue now.
    pub waiting: usize,
    /// Robots that wait for help now.
    pub stranded: usize,
}

fn shared<S: Serializer>(site: &Arc<SiteView>, serializer: S) -> Result<S::Ok, S::Error> {
    site.as_ref().serialize(serializer)
}

/// A fault's name in the API and in warnings.
#[must_use]
pub const fn fault_name(code: FaultCode) -> &'static str {
    match code {
        FaultCode::ReaderSilent => "reader_silent",
        FaultCode::ContactorWelded => "contactor_welded",
        FaultCode::ContactorStuckOpen => "contactor_stuck_open",
        FaultCode::OverCurrent => "over_current",
        FaultCode::OverVoltage => "over_voltage",
        FaultCode::OverTemperature => "over_temperature",
        FaultCode::ReversedPolarity => "reversed_polarity",
        FaultCode::StrayCurrent => "stray_current",
        FaultCode::VoltageSensor => "voltage_sensor",
        FaultCode::CurrentSensor => "current_sensor",
        FaultCode::TemperatureSensor => "temperature_sensor",
        FaultCode::EmergencyStop => "emergency_stop",
        FaultCode::MainsLost => "mains_lost",
        FaultCode::StoreFailed => "store_failed",
    }
}

impl Coordinator {
    /// The picture at `now`. What the shell knows, `insecure`, `degraded` and `warnings`, it fills in itself.
    #[must_use]
    pub fn view(&self, now: SiteMillis) -> View {
        View {
            site: Arc::clone(&self.site_view),
            now_ms: now.0,
            epoch: self.state.epoch.0,
            insecure: false,
            degraded: None,
            warnings: Vec::new(),
            piles: self.site.piles.iter().map(|pile| self.pile_view(pile, now)).collect(),
            robots: self.robots.values().map(|robot| self.robot_view(robot, now)).collect(),
            helps: self.state.helps.iter().map(|(robot, help)| HelpView::new(*robot, help)).collect(),
            decisions: self.state.decisions.iter().cloned().collect(),
            charges: self.state.charges.iter().map(ChargeView::new).collect(),
            totals: self.totals_view(now),
        }
    }

    fn pile_view(&self, pile: &SitePile, now: SiteMillis) -> PileView {
        let report = self.observed.report(pile.id, now);
        let lease = self.state.lease(pile.id);
        let wanted = lease.filter(|lease| lease.is_wanted()).map(|lease| lease.name.robot);
        let availability = match report.map(|report| report.row.availability) {
            None => "unknown",
            Some(Availability::Free) if wanted.is_some() => "reserved",
            Some(Availability::Free) => "free",
            Some(Availability::Reserved) => "reserved",
            Some(Availability::Charging) => "charging",
            Some(Availability::Done) => "done",
            Some(Availability::Fault) => "fault",
        };
        let holder = report.and_then(|report| report.holder).map(|holder| holder.robot);
        let faults = self.state.piles.get(&pile.id).map(|record| &record.faults);
        PileView {
            id: pile.id,
            at: [pile.cell.x, pile.cell.y],
            availability,
            remaining: report.map_or(0.0, |report| report.row.remaining.get()),
            planned_s: report.map_or(0.0, |report| report.row.planned.as_seconds()),
            elapsed_s: report.map_or(0.0, |report| report.elapsed.as_seconds()),
            energised: report.is_some_and(|report| report.energised),
            holder: holder.or(wanted),
            lease: lease.map(LeaseView::new),
            next: self.state.next(pile.id),
            faults: faults.into_iter().flatten().map(|fault| fault_name(*fault)).collect(),
            contradiction: self
                .state
                .piles
                .get(&pile.id)
                .and_then(|record| record.contradiction)
                .map(|seen| ContradictionView { what: seen.what, robot: seen.robot, since_ms: seen.since.0 }),
        }
    }

    fn robot_view(&self, robot: &RobotConfig, now: SiteMillis) -> RobotView {
        let seen = self.observed.robots.get(&robot.id);
        let report = seen.and_then(|seen| seen.report);
        let activity = match report.map(|report| report.activity) {
            _ if self.observed.robot_is_silent(robot.id, now) => "unknown",
            None => "unknown",
            Some(Activity::Working) => "working",
            Some(Activity::Waiting) => "waiting",
            Some(Activity::Approaching) => "approaching",
            Some(Activity::Docked) => "docked",
            Some(Activity::Charging) => "charging",
            Some(Activity::Stranded) => "stranded",
        };
        let last = seen.and_then(|seen| seen.last);
        let energy_j = last.map_or(0.0, |(_, energy)| energy.get());
        let pile = self.state.requests.get(&robot.id).and_then(|request| match request.place {
            Place::Waiting => None,
            Place::Next(pile) | Place::Granted(pile) => Some(pile),
        });
        let route = seen.and_then(|seen| seen.route.as_ref()).filter(|route| Some(route.pile) == pile);
        RobotView {
            id: robot.id,
            at: last.map(|(position, _)| self.site.picture_of(position)),
            battery: if robot.full.get() > 0.0 { (energy_j / robot.full.get()).min(1.0) } else { 0.0 },
            energy_j,
            activity,
            pile,
            route: route.into_iter().flat_map(|route| &route.cells).map(|cell| [cell.x, cell.y]).collect(),
        }
    }

    fn totals_view(&self, now: SiteMillis) -> TotalsView {
        let totals = &self.state.totals;
        let waiting = self.state.requests.values().filter(|request| request.place == Place::Waiting);
        TotalsView {
            requests: totals.requests,
            charges_completed: totals.charges_completed,
            preempted: totals.preempted,
            granted_w: self.granted_w(now),
            power_cap_w: self.policy.power_cap_w,
            energy_j: totals.energy_j,
            mean_wait_s: totals.mean_wait_s(),
            worst_wait_s: totals.worst_wait_s(),
            waiting: waiting.count(),
            stranded: self.state.stranded.len(),
        }
    }
}

impl HelpView {
    fn new(robot: RobotId, help: &Help) -> Self {
        let (stage, reason) = match &help.stage {
            HelpStage::Queued => ("queued", None),
            HelpStage::Sent(sortie) if sortie.charging => ("charging", None),
            HelpStage::Sent(_) => ("coming", None),
            HelpStage::Tow(why) => ("tow", Some(why.to_string())),
        };
        Self {
            robot,
            since_ms: help.since.0,
            plight: match help.plight {
                Plight::Stranded => "stranded",
                Plight::OutOfReach => "out_of_reach",
            },
            stage,
            charger: help.sortie().map(|sortie| sortie.charger),
            reason,
        }
    }
}

impl ChargeView {
    fn new(charge: &Charge) -> Self {
        Self {
            id: charge.id,
            pile: charge.pile,
            robot: charge.robot,
            lease: charge.lease.0,
            end: match (charge.ended, charge.reason) {
                (None, _) => "restarted",
                (_, EndReason::Completed) => "completed",
                (_, EndReason::Expired) => "expired",
                (_, EndReason::Revoked) => "revoked",
                (_, EndReason::RobotLeft) => "robot_left",
                (_, EndReason::Fault) => "fault",
            },
            began_ms: charge.began.0,
            ended_ms: charge.ended.map(|ended| ended.0),
            charged_s: charge.charged.as_seconds(),
            energy_j: charge.energy.get(),
        }
    }
}

impl LeaseView {
    pub(super) const fn new(lease: &Lease) -> Self {
        Self {
            id: lease.name.lease.0,
            epoch: lease.name.epoch.0,
            local: lease.name.lease.is_local(),
            robot: lease.name.robot,
            expiry_ms: lease.expiry.0,
            phase: match lease.phase {
                Phase::Offered => "offered",
                Phase::Held { .. } => "held",
                Phase::Refused => "refused",
                Phase::Revoking { .. } => "revoking",
            },
        }
    }
}
