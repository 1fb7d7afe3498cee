//! The core alone: frames and ticks of ten minutes, as robots and piles would send them.
//!
//! Every robot and pile reports its state each second and the time is told five times a second, as by the
//! daemon. A robot works for four minutes, asks, drives for 20 s and is charged for two minutes; a pile answers
//! a command at once.

use std::{collections::VecDeque, sync::Arc};

use host_coordinator::{
    config::Policy,
    core::{Coordinator, Effect, Fact, Input},
};
use protocol::{
    Ack, Activity, Availability, BootEpoch, ChargeRequest, DeviceId, DurationMs, EndReason, EndedLease,
    EnergyJ, Fraction, Frame, Header, LeaseRef, Message, PileId, PileRow, PileState, Position, Reference,
    RequestId, RobotId, RobotState, Sequence, SiteMillis, TaskPriority,
};

use crate::{clock::Clock, site};

const MINUTES: u64 = 10;
const STEP_MS: u64 = 200;
const WORK_S: u64 = 240;
const DRIVE_S: u64 = 20;
const CHARGE_S: u64 = 120;

/// What was taken in, and in what time.
#[derive(Default)]
pub struct Throughput {
    pub inputs: u64,
    pub events: u64,
    pub requests: u64,
    pub grants: u64,
    pub seconds: f64,
}

impl Throughput {
    pub fn per_second(&self) -> f64 {
        self.inputs as f64 / self.seconds
    }
}

/// What a robot does, and since when in seconds.
#[derive(Clone, Copy, PartialEq)]
enum Doing {
    Working,
    Waiting,
    Driving(PileId),
    Docked,
}

struct Robot {
    id: RobotId,
    doing: Doing,
    since: u64,
    request: u32,
    sequence: u32,
    position: Position,
}

struct Pile {
    id: PileId,
    sequence: u32,
    lease: Option<LeaseRef>,
    charging_since: Option<u64>,
    ended: Option<EndedLease>,
}

struct Fleet {
    coordinator: Coordinator,
    robots: Vec<Robot>,
    piles: Vec<Pile>,
    now: u64,
    done: Throughput,
    waiting: VecDeque<Input>,
}

pub fn measure() -> Throughput {
    let site = Arc::new(site::site());
    let robots = site::robots();
    let mut coordinator =
        Coordinator::recover(Arc::clone(&site), site.lmpp(1.0), Policy::default(), &robots, &[]);
    coordinator.step(SiteMillis(0), Input::Started { boot_floor: BootEpoch(0) });
    let places = site::places(&site);
    let robots = robots.iter().map(|robot| Robot {
        id: robot.id,
        doing: Doing::Working,
        since: 0,
        request: 0,
        sequence: 0,
        position: site::place(&places, robot.id, 0),
    });
    let piles = site.piles.iter().map(|pile| Pile {
        id: pile.id,
        sequence: 0,
        lease: None,
        charging_since: None,
        ended: None,
    });
    let mut fleet = Fleet {
        robots: robots.collect(),
        piles: piles.collect(),
        coordinator,
        now: 0,
        done: Throughput::default(),
        waiting: VecDeque::new(),
    };
    while fleet.now < MINUTES * 60_000 {
        fleet.pass(STEP_MS);
    }
    fleet.done
}

impl Fleet {
    /// A fifth of the devices speak in each fifth of a second.
    fn pass(&mut self, step_ms: u64) {
        self.now += step_ms;
        let part = (self.now / step_ms % (1000 / step_ms)) as usize;
        let parts = (1000 / step_ms) as usize;
        let now_s = self.now / 1000;
        for at in (part..self.piles.len()).step_by(parts) {
            self.pile_speaks(at, now_s);
        }
        for at in (part..self.robots.len()).step_by(parts) {
            self.robot_speaks(at, now_s);
        }
        self.waiting.push_back(Input::Tick);
        self.coordinate();
    }

    /// Gives the core what has come, and the piles' answers to it.
    fn coordinate(&mut self) {
        while !self.waiting.is_empty() {
            let inputs = std::mem::take(&mut self.waiting);
            self.done.inputs += inputs.len() as u64;
            let (coordinator, now) = (&mut self.coordinator, SiteMillis(self.now));
            let (micros, steps) = Clock::Thread
                .time(|| inputs.into_iter().map(|input| coordinator.step(now, input)).collect::<Vec<_>>());
            self.done.seconds += micros / 1e6;
            let events = steps.iter().flat_map(|step| &step.events);
            self.done.events += events.clone().count() as u64;
            self.done.grants +=
                events.filter(|event| matches!(event.fact, Fact::Granted { .. })).count() as u64;
            let effects = steps.into_iter().flat_map(|step| step.effects);
            for effect in effects {
                if let Effect::Send { to, message } = effect {
                    self.deliver(to, message);
                }
            }
        }
    }

    fn deliver(&mut self, to: DeviceId, message: Message) {
        match (to, message) {
            (DeviceId::Pile(id), Message::Grant(grant)) => {
                let at = usize::from(id.0) - 1;
                self.piles[at].lease = Some(grant.lease);
                self.answer(at, Reference::Command(grant.head.id));
            }
            (DeviceId::Pile(id), Message::Revoke(revoke)) => {
                let at = usize::from(id.0) - 1;
                if self.piles[at].lease.is_some_and(|lease| lease.lease == revoke.lease.lease) {
                    self.end(at, EndReason::Revoked);
                }
                self.answer(at, Reference::Command(revoke.head.id));
            }
            (DeviceId::Robot(id), Message::Assignment(part)) => {
                let robot = &mut self.robots[usize::from(id.0) - 1];
                if robot.doing == Doing::Waiting && part.request.0 == robot.request {
                    (robot.doing, robot.since) = (Doing::Driving(part.pile), self.now / 1000);
                }
            }
            _ => {}
        }
    }

    fn answer(&mut self, at: usize, of: Reference) {
        self.pile_says(at, Message::Ack(Ack { of }));
        self.report(at);
    }

    fn end(&mut self, at: usize, reason: EndReason) {
        let pile = &mut self.piles[at];
        if let Some(lease) = pile.lease.take() {
            pile.charging_since = None;
            pile.ended = Some(EndedLease { lease, reason, charged: DurationMs(0) });
        }
    }

    fn pile_speaks(&mut self, at: usize, now_s: u64) {
        if self.piles[at].charging_since.is_some_and(|since| now_s >= since + CHARGE_S) {
            if let Some(lease) = self.piles[at].lease {
                let robot = &mut self.robots[usize::from(lease.robot.0) - 1];
                (robot.doing, robot.since) = (Doing::Working, now_s);
            }
            self.end(at, EndReason::Completed);
        }
        self.report(at);
    }

    fn report(&mut self, at: usize) {
        let pile = &self.piles[at];
        let availability = match (pile.charging_since, pile.lease) {
            (Some(_), _) => Availability::Charging,
            (None, Some(_)) => Availability::Reserved,
            (None, None) => Availability::Free,
        };
        let passed_s = pile.charging_since.map_or(0, |since| (self.now / 1000).saturating_sub(since));
        let row = PileRow {
            pile: pile.id,
            boot: BootEpoch(1),
            version: 0,
            stamp: None,
            availability,
            remaining: Fraction::clamped(1.0 - passed_s as f32 / CHARGE_S as f32),
            planned: DurationMs(CHARGE_S as u32 * 1000),
        };
        let state = PileState {
            row,
            elapsed: DurationMs(passed_s as u32 * 1000),
            holder: pile.lease,
            energised: pile.charging_since.is_some(),
            ended: pile.ended,
            standing: None,
            current: None,
        };
        self.pile_says(at, Message::PileState(state));
    }

    fn pile_says(&mut self, at: usize, message: Message) {
        let pile = &mut self.piles[at];
        pile.sequence += 1;
        let header = Header::new(DeviceId::Pile(pile.id), BootEpoch(1), Sequence(pile.sequence));
        self.waiting.push_back(Input::Frame(Frame { header, message }));
    }

    fn robot_speaks(&mut self, at: usize, now_s: u64) {
        let robot = &mut self.robots[at];
        // They do not all ask at once.
        let shift = u64::from(robot.id.0) * WORK_S / u64::from(site::ROBOTS);
        let works_until = if robot.request == 0 { shift } else { robot.since + WORK_S };
        match robot.doing {
            Doing::Working if now_s >= works_until => {
                (robot.doing, robot.since) = (Doing::Waiting, now_s);
                robot.request += 1;
                self.done.requests += 1;
            }
            Doing::Driving(id) if now_s >= robot.since + DRIVE_S => {
                let pile = &mut self.piles[usize::from(id.0) - 1];
                if pile.lease.is_some_and(|lease| lease.robot == robot.id) {
                    pile.charging_since = Some(now_s);
                    (robot.doing, robot.since) = (Doing::Docked, now_s);
                }
            }
            _ => {}
        }
        let energy = EnergyJ::clamped(0.4 * site::FULL_J);
        let request = RequestId(robot.request);
        let (activity, accepted) = match robot.doing {
            Doing::Working => (Activity::Working, None),
            Doing::Waiting => (Activity::Waiting, None),
            Doing::Driving(_) => (Activity::Approaching, Some(request)),
            Doing::Docked => (Activity::Docked, Some(request)),
        };
        let position = robot.position;
        let state = Message::RobotState(RobotState { position, energy, activity, accepted });
        let asks = (robot.doing == Doing::Waiting).then_some(Message::ChargeRequest(ChargeRequest {
            request,
            position,
            energy,
            task: None,
            priority: TaskPriority::USUAL,
        }));
        for message in [Some(state), asks].into_iter().flatten() {
            robot.sequence += 1;
            let header = Header::new(DeviceId::Robot(robot.id), BootEpoch(1), Sequence(robot.sequence));
            self.waiting.push_back(Input::Frame(Frame { header, message }));
        }
    }
}
