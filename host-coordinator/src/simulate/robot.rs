//! A robot's own computer, pure: it works, asks for a charge, drives to the pile it is given,
//! charges, and works again.
//!
//! It knows its map, what its sensors tell ([`Sensed`]) and what the coordinator says, and nothing
//! else. In particular it learns from its charge contacts that a charge has begun (they become
//! live) and that it is over (they go dead): no message says so.
//!
//! ```text
//!   Working --energy at the alert--> Waiting --route complete--> Approaching
//!      |  ^                                                        ^ | at the dock
//!      |  |                                                        | |
//!      +--|----------- called: the route of a call is complete ----+ |
//!         |                                                          |
//!      +----------- contacts dead after a charge ---------------- Docked
//!      +----------- contacts never live: asks again -----------------+
//! ```
//! A coordinator that watches over the robot calls it before it comes to its alert. While it waits and hears no coordinator it claims a pile by itself ([`claiming`](super::claiming)).
//!
//! One whose battery is empty has stranded, unless it stands at a pile. It asks again when it was helped: when
//! it was charged where it stood, or moved to a pile. A mobile charger is a robot too, whose work is to stand
//! by and to help others ([`charger`](super::charger)).

use protocol::{
    Ack, Activity, Assignment, ChargeRequest, ClaimPile, CommandId, DurationMs, EnergyJ, Epoch, Hello,
    Message, Millis, Nack, PileId, Reference, RequestId, Rescue, RobotId, RobotState, UnassignedReason,
    limits,
};

use super::{
    charger::Charger,
    claiming::Claiming,
    ground::{KEEP_CLEAR_M, Point, Route},
    navigator::Navigator,
    parts::Parts,
    tasks::{Runs, Task},
    world::{Build, CONTACT_M, Sensed},
};

/// How long contacts stay dead before a charge counts as over: longer than a contactor's bounce.
const DEAD: DurationMs = DurationMs(2_000);
/// How long a robot stands at a pile that never becomes live before it asks again.
const PATIENCE: DurationMs = DurationMs(60_000);
/// How often a robot repeats a request that was answered by "not now".
const ASK_AGAIN: DurationMs = DurationMs(10_000);

/// A robot this far from the beginning of a route, in metres, does not drive back to it.
const ROLLED_M: f64 = 2.0;

/// What a robot does after a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outputs {
    /// A new route for the drive; `None` keeps the old one.
    pub route: Option<Route>,
    /// Whether the drive follows its route.
    pub moving: bool,
    /// To the coordinator.
    pub messages: Vec<Message>,
    /// To the piles, when there seems to be no coordinator.
    pub claim: Option<ClaimPile>,
}

/// What the robot is about.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Mode {
    /// Drives to a place and works there until an instant, which it sets on arrival.
    Working { until: Option<Millis> },
    /// Has asked for a charge, asks again at an instant.
    Waiting { ask_at: Millis },
    /// Drives to the pile of its assignment.
    Approaching(Dock),
    /// Stands at it.
    Docked { dock: Dock, charge: Charge },
    /// Has no energy left.
    Stranded,
    /// Is about another robot's rescue.
    Rescuing,
}

/// Where an assignment ends.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Dock {
    pile: PileId,
    at: Point,
}

/// What the contacts have told so far.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Charge {
    /// Not live since the robot came.
    Expected { since: Millis },
    /// Live, most recently at this instant.
    Flowing { live_at: Millis },
}

/// A robot's own computer.
#[derive(Debug)]
pub struct Robot {
    navigator: Navigator,
    /// The energy at which it asks (LMPP eq. 3), in joules.
    alert_j: f64,
    mode: Mode,
    /// What it works at, or worked at last and will go on with after its charge.
    task: Task,
    /// What its battery held when the task began, in joules; none if there was a charge since.
    begun_j: Option<f64>,
    runs: Runs,
    claiming: Claiming,
    /// Its newest request of its own.
    asked: RequestId,
    /// The request that it is about: its own, or one under which it was called.
    request: RequestId,
    /// The parts of an assignment that are here so far.
    parts: Option<Parts<(RequestId, PileId)>>,
    /// What it is as a mobile charger.
    charger: Option<Charger>,
    greeted: bool,
    greet_at: Millis,
    /// What it last said of itself, and when.
    said: Option<(Activity, Option<RequestId>, Millis)>,
}

impl Robot {
    /// A robot that takes itself to be built as `believed`, starts to work, and asks for a charge at
    /// `alert_j` joules.
    #[must_use]
    pub fn new(robot: RobotId, believed: Build, mut navigator: Navigator, alert_j: f64) -> Self {
        Self {
            task: navigator.task(),
            begun_j: None,
            runs: Runs::default(),
            claiming: Claiming::new(robot, believed),
            navigator,
            alert_j,
            mode: Mode::Working { until: None },
            asked: RequestId(0),
            request: RequestId(0),
            parts: None,
            charger: None,
            greeted: false,
            greet_at: Millis(0),
            said: None,
        }
    }

    /// The same as a mobile charger.
    #[must_use]
    pub fn with_charger(self, charger: Charger) -> Self {
        Self { charger: Some(charger), ..self }
    }

    /// What it is as a mobile charger.
    #[must_use]
    pub const fn charger(&self) -> Option<&Charger> {
        self.charger.as_ref()
    }

    /// What the robot does.
    #[must_use]
    pub const fn activity(&self) -> Activity {
        match self.mode {
            Mode::Working { .. } | Mode::Rescuing => Activity::Working,
            Mode::Waiting { .. } => Activity::Waiting,
            Mode::Approaching(_) => Activity::Approaching,
            Mode::Docked { charge: Charge::Flowing { .. }, .. } => Activity::Charging,
            Mode::Docked { .. } => Activity::Docked,
            Mode::Stranded => Activity::Stranded,
        }
    }

    /// What it works at, or worked at last.
    #[must_use]
    pub const fn task(&self) -> Task {
        self.task
    }

    /// Whether it works at the place of its task, and is not on the way there.
    #[must_use]
    pub const fn is_at_work(&self) -> bool {
        matches!(self.mode, Mode::Working { until: Some(_) }) && self.charger.is_none()
    }

    /// The request that it is about.
    #[must_use]
    pub const fn request(&self) -> RequestId {
        self.request
    }

    /// When the next step is due by the robot's own timers, unless something is sensed or heard before.
    /// May lie in the past.
    #[must_use]
    pub fn wakes_at(&self) -> Millis {
        let says = self.said.map_or(Millis(0), |(.., at)| at.after(limits::STATE_INTERVAL));
        let greets = if self.greeted { says } else { self.greet_at };
        let own = match self.mode {
            Mode::Working { until: Some(until) } => until,
            Mode::Waiting { ask_at } => ask_at,
            Mode::Docked { charge: Charge::Expected { since }, .. } => since.after(PATIENCE),
            Mode::Docked { charge: Charge::Flowing { live_at }, .. } => live_at.after(DEAD),
            Mode::Working { until: None } | Mode::Approaching(_) | Mode::Stranded | Mode::Rescuing => says,
        };
        says.min(greets).min(own)
    }

    /// The coordinator has started anew: it does not know of this robot's start.
    pub const fn distrusted(&mut self) {
        self.greeted = false;
    }

    /// Takes what was sensed and heard by `now`.
    pub fn step(&mut self, now: Millis, sensed: &Sensed, heard: &[Message]) -> Outputs {
        let mut outputs = Outputs::default();
        for message in heard {
            match message {
                Message::Hello(_) | Message::Assignment(_) | Message::Unassigned(_) => {
                    self.claiming.coordinator_heard(now);
                }
                Message::PileTable(table) => self.claiming.hear(now, table),
                _ => {}
            }
            match message {
                Message::Hello(_) => self.greeted = true,
                Message::Ack(Ack { of: Reference::Claim(of) }) => {
                    if let Some(pile) = self.claiming.answered(now, *of, self.request, true) {
                        self.go_to_claimed(pile, sensed, &mut outputs);
                    }
                }
                Message::Nack(Nack { of: Reference::Claim(of), .. }) => {
                    self.claiming.answered(now, *of, self.request, false);
                }
                Message::Assignment(part) => self.take(part, sensed, &mut outputs),
                Message::Unassigned(answer) if answer.request == self.request => match answer.reason {
                    UnassignedReason::AllTaken | UnassignedReason::OutOfReach => {
                        self.wait(now, sensed, &mut outputs);
                    }
                    UnassignedReason::Withdrawn => self.work_on(sensed, &mut outputs),
                },
                Message::Rescue(part) => self.set_out(part, sensed, &mut outputs),
                Message::Nack(Nack { of: Reference::Command(rescue), .. }) => {
                    self.let_go(*rescue, sensed, &mut outputs);
                }
                _ => {}
            }
        }
        self.decide(now, sensed, &mut outputs);
        if let Mode::Waiting { .. } = self.mode {
            let body = (sensed.position, sensed.energy_j);
            outputs.claim = self.claiming.claim(now, self.request, body, &self.navigator);
        }
        outputs.moving = self.moving(sensed);
        self.speak(now, sensed, &mut outputs.messages);
        outputs
    }

    /// Told that there is no pile now. That also takes an assignment back, whose dock is then left
    /// to others.
    fn wait(&mut self, now: Millis, sensed: &Sensed, outputs: &mut Outputs) {
        match self.mode {
            Mode::Waiting { .. } => {}
            Mode::Approaching(_) | Mode::Docked { charge: Charge::Expected { .. }, .. } => {
                outputs.route = self.navigator.route_to_work(sensed.position);
            }
            Mode::Working { .. } | Mode::Docked { .. } | Mode::Stranded | Mode::Rescuing => return,
        }
        self.parts = None;
        self.mode = Mode::Waiting { ask_at: now.after(ASK_AGAIN) };
    }

    /// A pile has given itself to the robot.
    fn go_to_claimed(&mut self, pile: PileId, sensed: &Sensed, outputs: &mut Outputs) {
        let Mode::Waiting { .. } = self.mode else { return };
        let Some(route) = self.navigator.route_to_pile(sensed.position, pile) else { return };
        let Some(&at) = route.back() else { return };
        self.parts = None;
        outputs.route = Some(route);
        self.mode = Mode::Approaching(Dock { pile, at });
    }

    /// Told that its request was taken back, before its charge has begun.
    fn work_on(&mut self, sensed: &Sensed, outputs: &mut Outputs) {
        if matches!(
            self.mode,
            Mode::Waiting { .. }
                | Mode::Approaching(_)
                | Mode::Docked { charge: Charge::Expected { .. }, .. }
        ) {
            self.parts = None;
            self.mode = self.go_to_work(sensed, outputs);
        }
    }

    /// Takes a part of an assignment; sets off when it is the last.
    fn take(&mut self, part: &Assignment, sensed: &Sensed, outputs: &mut Outputs) {
        if part.request != self.request && part.request != self.asked && !part.request.is_call() {
            return;
        }
        let wanted = match self.mode {
            Mode::Waiting { .. } => true,
            Mode::Working { .. } => part.request.is_call(),
            Mode::Approaching(dock) | Mode::Docked { dock, charge: Charge::Expected { .. } } => {
                if dock.pile == part.pile {
                    // It had asked when it was called: both are about the same charge.
                    self.request = part.request;
                }
                // Another pile than before: the coordinator has changed its mind.
                dock.pile != part.pile
            }
            Mode::Docked { .. } | Mode::Stranded | Mode::Rescuing => false,
        };
        if !wanted {
            return;
        }
        let of = (part.request, part.pile);
        if !self.parts.as_ref().is_some_and(|parts| parts.is(&of, part.total)) {
            self.parts = Some(Parts::new(of, part.total));
        }
        let Some(parts) = &mut self.parts else { return };
        let Some(waypoints) = parts.add(part.first, &part.waypoints) else { return };
        self.parts = None;
        let (Some(&first), Some(&at)) = (waypoints.front(), waypoints.back()) else { return };
        // The route begins where the robot was heard last. If it has moved on since, it finds its own way.
        let is_there = first.distance_m(sensed.position) <= ROLLED_M;
        let goal = if is_there { first } else { at };
        let Some(mut route) = self.navigator.route(sensed.position, goal) else { return };
        if is_there {
            route.extend(waypoints);
        }
        outputs.route = Some(route);
        self.request = part.request;
        self.begun_j = None;
        self.mode = Mode::Approaching(Dock { pile: part.pile, at });
    }

    /// A mobile charger that stands by sets out for another robot.
    fn set_out(&mut self, part: &Rescue, sensed: &Sensed, outputs: &mut Outputs) {
        let Some(charger) = &mut self.charger else { return };
        if !matches!(self.mode, Mode::Working { .. } | Mode::Rescuing) {
            return;
        }
        let Some(waypoints) = charger.take(part) else { return };
        let first = waypoints.front().and_then(|&first| self.navigator.route(sensed.position, first));
        let Some(mut route) = first else { return };
        route.extend(waypoints);
        outputs.route = Some(route);
        self.mode = Mode::Rescuing;
    }

    /// A mobile charger's robot needs it no more.
    fn let_go(&mut self, rescue: CommandId, sensed: &Sensed, outputs: &mut Outputs) {
        if self.charger.as_mut().is_some_and(|charger| charger.let_go(rescue)) {
            self.mode = self.go_to_work(sensed, outputs);
        }
    }

    /// Whether its battery is empty and it stands where nothing charges it.
    fn is_stuck(&self, sensed: &Sensed) -> bool {
        let at_a_pile = || self.navigator.near_a_pile(sensed.position, CONTACT_M);
        sensed.energy_j <= 0.0 && !sensed.contacts_live && !at_a_pile()
    }

    /// What the robot is about from now on.
    fn decide(&mut self, now: Millis, sensed: &Sensed, outputs: &mut Outputs) {
        let stuck = self.is_stuck(sensed);
        if stuck {
            self.mode = Mode::Stranded;
        }
        if let (Mode::Rescuing, Some(charger)) = (self.mode, &mut self.charger) {
            // Nobody has sensed anything of a route that was taken just now.
            if outputs.route.is_none() {
                charger.step(now, sensed);
            }
        } else if let Some(charger) = &mut self.charger {
            charger.abandon();
        }
        self.mode = match self.mode {
            Mode::Working { .. } if sensed.energy_j <= self.alert_j => self.ask(now),
            Mode::Stranded if !stuck && !sensed.contacts_live => {
                // It was on its way to a pile that is another's by now.
                if !self.navigator.near_a_pile(sensed.position, CONTACT_M) {
                    outputs.route = self.navigator.route_to_work(sensed.position);
                }
                self.ask(now)
            }
            Mode::Working { until: None } if sensed.arrived && self.charger.is_some() => {
                Mode::Working { until: Some(Millis(u64::MAX)) }
            }
            Mode::Working { until: None } if sensed.arrived => {
                Mode::Working { until: Some(now.after(self.navigator.time_at_work(self.task))) }
            }
            Mode::Working { until: Some(until) } if now >= until => {
                self.end_task(sensed, outputs);
                self.go_to_work(sensed, outputs)
            }
            Mode::Approaching(dock) if sensed.arrived && sensed.position.distance_m(dock.at) < CONTACT_M => {
                Mode::Docked { dock, charge: Charge::Expected { since: now } }
            }
            Mode::Docked { dock, .. } if sensed.contacts_live => {
                Mode::Docked { dock, charge: Charge::Flowing { live_at: now } }
            }
            Mode::Docked { charge: Charge::Flowing { live_at }, .. } if now.since(live_at) >= DEAD => {
                self.go_to_work(sensed, outputs)
            }
            Mode::Docked { charge: Charge::Expected { since }, .. } if now.since(since) >= PATIENCE => {
                self.go_to_work(sensed, outputs)
            }
            mode => mode,
        };
    }

    /// Begins to ask for a charge.
    fn ask(&mut self, now: Millis) -> Mode {
        self.asked.0 = self.asked.0.wrapping_add(1) % RequestId::FIRST_CALL.0;
        self.request = self.asked;
        self.parts = None;
        self.begun_j = None;
        self.claiming.coordinator_heard(now);
        Mode::Waiting { ask_at: now }
    }

    fn go_to_work(&mut self, sensed: &Sensed, outputs: &mut Outputs) -> Mode {
        outputs.route = match &self.charger {
            Some(charger) => self.navigator.route(sensed.position, charger.home()),
            None => self.navigator.route_to_work(sensed.position),
        };
        Mode::Working { until: None }
    }

    /// Tells what the task took, unless a charge came between, and begins the next.
    fn end_task(&mut self, sensed: &Sensed, outputs: &mut Outputs) {
        if let Some(begun_j) = self.begun_j {
            let run = self.runs.add(self.task, begun_j - sensed.energy_j);
            outputs.messages.push(Message::TaskEnergy(run));
        }
        self.task = self.navigator.task();
        self.begun_j = Some(sensed.energy_j);
    }

    fn moving(&self, sensed: &Sensed) -> bool {
        match self.mode {
            Mode::Working { until } => until.is_none(),
            Mode::Waiting { .. } => self.navigator.near_a_pile(sensed.position, KEEP_CLEAR_M),
            Mode::Approaching(dock) => sensed.end_clear || sensed.position.distance_m(dock.at) > KEEP_CLEAR_M,
            Mode::Rescuing => self.charger.as_ref().is_some_and(Charger::drives),
            Mode::Docked { .. } | Mode::Stranded => false,
        }
    }

    fn speak(&mut self, now: Millis, sensed: &Sensed, messages: &mut Vec<Message>) {
        let position = sensed.position.into();
        let energy = EnergyJ::clamped(sensed.energy_j as f32);
        if !self.greeted && now >= self.greet_at {
            self.greet_at = now.after(limits::REPEAT_INTERVAL);
            messages.push(Message::Hello(Hello::new(Epoch(0))));
        }
        let activity = self.activity();
        let accepted =
            matches!(self.mode, Mode::Approaching(_) | Mode::Docked { .. }).then_some(self.request);
        let news = self.said.is_none_or(|(was, had, at)| {
            (was, had) != (activity, accepted) || now.since(at) >= limits::STATE_INTERVAL
        });
        if news {
            self.said = Some((activity, accepted, now));
            messages.push(Message::RobotState(RobotState { position, energy, activity, accepted }));
        }
        messages
            .extend(self.charger.as_mut().and_then(|charger| charger.speak(now)).map(Message::RescueState));
        if let Mode::Waiting { ask_at } = &mut self.mode
            && now >= *ask_at
        {
            *ask_at = now.after(limits::REPEAT_INTERVAL);
            messages.push(Message::ChargeRequest(ChargeRequest {
                request: self.request,
                position,
                energy,
                task: Some(self.task.id()),
                priority: self.task.priority(),
            }));
        }
    }
}

#[cfg(test)]
#[path = "robot_tests.rs"]
mod tests;
