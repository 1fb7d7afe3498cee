//! Single steps of the core: what a message means, and what follows from it.

mod calls;
mod claims;
mod help;
mod losing;
mod piles;
mod preemption;
mod restarts;
mod robots;

use std::sync::Arc;

use host_coordinator::{
    config::{Policy, RobotConfig},
    core::{
        Coordinator, Effect, Event, Fact, Input, State,
        event::{LeaseEnd, RevokeReason},
        state::{Phase, Place},
    },
    site::Site,
};
use protocol::*;

const P: PileId = PileId(2);
const ROBOT: RobotId = RobotId(1);

/// A coordinator, and devices that say what the test wants.
struct Desk {
    site: Arc<Site>,
    coordinator: Coordinator,
    events: Vec<Event>,
    sent: Vec<(DeviceId, Message)>,
    warnings: Vec<String>,
    now: SiteMillis,
    sequence: u32,
    boot: BootEpoch,
    /// How long the charges that piles report have lasted.
    elapsed: DurationMs,
    /// What the robots that ask will do next.
    task: Option<TaskId>,
    /// Who stands at the piles that report, without a lease.
    standing: Option<TagId>,
    /// What flows out of them.
    current: Option<CurrentA>,
}

impl Desk {
    fn new() -> Self {
        Self::with_log(Vec::new())
    }

    fn with_log(events: Vec<Event>) -> Self {
        Self::with_robots(events, |robot| robot)
    }

    fn with_robots(events: Vec<Event>, of: impl Fn(RobotConfig) -> RobotConfig) -> Self {
        let site = Arc::new(Site::fig7().unwrap());
        let full = EnergyJ::new(10_000.0).unwrap();
        let robots: Vec<_> = (1..=3)
            .map(|id| RobotConfig {
                id: RobotId(id),
                tag: TagId([id as u8; 12]),
                full,
                energy_per_metre_j: 10.0,
                speed_mps: 0.5,
                gives_w: None,
            })
            .map(of)
            .collect();
        let coordinator =
            Coordinator::recover(Arc::clone(&site), site.lmpp(1.0), Policy::default(), &robots, &events);
        let mut desk = Self {
            site,
            coordinator,
            events,
            sent: Vec::new(),
            warnings: Vec::new(),
            now: SiteMillis(1_000_000),
            sequence: 0,
            boot: BootEpoch(1),
            elapsed: DurationMs(0),
            task: None,
            standing: None,
            current: None,
        };
        desk.step(Input::Started { boot_floor: BootEpoch(0) });
        desk
    }

    fn step(&mut self, input: Input) {
        let step = self.coordinator.step(self.now, input);
        self.events.extend(step.events);
        for effect in step.effects {
            match effect {
                Effect::Send { to, message } => self.sent.push((to, message)),
                Effect::Warn(text) => self.warnings.push(text),
            }
        }
    }

    fn hear(&mut self, sender: DeviceId, message: Message) {
        self.sequence += 1;
        let header = Header::new(sender, self.boot, Sequence(self.sequence));
        self.step(Input::Frame(Frame { header, message }));
    }

    /// Lets time pass, in which the devices given are heard.
    fn wait(&mut self, millis: u64) {
        for _ in 0..millis / 100 {
            self.now.0 += 100;
            self.step(Input::Tick);
        }
    }

    fn state(&self) -> &State {
        self.coordinator.state()
    }

    fn phase(&self, pile: PileId) -> Option<Phase> {
        self.state().lease(pile).map(|lease| lease.phase)
    }

    fn place(&self, robot: RobotId) -> Option<Place> {
        self.state().requests.get(&robot).map(|request| request.place)
    }

    fn pile_says(&mut self, pile: PileId, availability: Availability, holder: Option<LeaseRef>) {
        self.pile_reports(pile, availability, holder, None, 0.0);
    }

    fn pile_reports(
        &mut self,
        pile: PileId,
        availability: Availability,
        holder: Option<LeaseRef>,
        ended: Option<EndedLease>,
        remaining: f32,
    ) {
        let row = PileRow {
            pile,
            boot: self.boot,
            version: self.sequence,
            stamp: None,
            availability,
            remaining: Fraction::new(remaining).unwrap(),
            planned: DurationMs(10 * self.elapsed.0),
        };
        let state = PileState {
            row,
            elapsed: self.elapsed,
            holder,
            energised: false,
            ended,
            standing: self.standing,
            current: self.current,
        };
        self.hear(DeviceId::Pile(pile), Message::PileState(state));
    }

    fn robot_at(&mut self, robot: RobotId, position: Position, activity: Activity, accepted: Option<u32>) {
        let energy = EnergyJ::new(5_000.0).unwrap();
        let accepted = accepted.map(RequestId);
        let state = RobotState { position, energy, activity, accepted };
        self.hear(DeviceId::Robot(robot), Message::RobotState(state));
    }

    fn robot_is(&mut self, robot: RobotId, activity: Activity, accepted: Option<u32>) {
        let position = self.beside(P);
        self.robot_at(robot, position, activity, accepted);
    }

    fn beside(&self, pile: PileId) -> Position {
        self.site.position(self.site.pile(pile).unwrap().cell)
    }

    fn ask(&mut self, robot: RobotId, request: u32) {
        let position = self.beside(P);
        self.ask_from(robot, request, position, 5_000.0);
    }

    fn ask_from(&mut self, robot: RobotId, request: u32, position: Position, energy: f32) {
        let energy = EnergyJ::new(energy).unwrap();
        let asked = ChargeRequest {
            request: RequestId(request),
            position,
            energy,
            task: self.task,
            priority: TaskPriority::USUAL,
        };
        self.hear(DeviceId::Robot(robot), Message::ChargeRequest(asked));
    }

    fn last_command(&self, pile: PileId) -> Option<(CommandId, LeaseRef, bool)> {
        self.sent.iter().rev().find_map(|(to, message)| match message {
            _ if *to != DeviceId::Pile(pile) => None,
            Message::Grant(grant) => Some((grant.head.id, grant.lease, true)),
            Message::Revoke(revoke) => Some((revoke.head.id, revoke.lease, false)),
            _ => None,
        })
    }

    fn ack(&mut self, pile: PileId) {
        let of = Reference::Command(self.last_command(pile).unwrap().0);
        self.hear(DeviceId::Pile(pile), Message::Ack(Ack { of }));
    }

    fn nack(&mut self, pile: PileId, reason: NackReason) {
        let of = Reference::Command(self.last_command(pile).unwrap().0);
        self.hear(DeviceId::Pile(pile), Message::Nack(Nack { of, reason }));
    }

    fn sent_to_robot(&self, robot: RobotId) -> Vec<&Message> {
        self.sent.iter().filter(|(to, _)| *to == DeviceId::Robot(robot)).map(|(_, message)| message).collect()
    }

    /// Where the last route begins that a robot was sent.
    fn led_from(&self, robot: RobotId) -> Option<Position> {
        self.sent_to_robot(robot).into_iter().rev().find_map(|message| match message {
            Message::Assignment(part) if part.first == 0 => part.waypoints.first().copied(),
            _ => None,
        })
    }

    fn ends(&self) -> Vec<LeaseEnd> {
        let ends = self.events.iter().filter_map(|event| match event.fact {
            Fact::Ended { why, .. } => Some(why),
            _ => None,
        });
        ends.collect()
    }

    /// A robot with the lease on the pile where it stands.
    fn granted() -> (Self, LeaseRef) {
        Self::granted_for(None)
    }

    fn granted_for(task: Option<TaskId>) -> (Self, LeaseRef) {
        let mut desk = Self { task, ..Self::new() };
        desk.pile_says(P, Availability::Free, None);
        desk.robot_is(ROBOT, Activity::Waiting, None);
        desk.ask(ROBOT, 1);
        desk.ack(P);
        let lease = desk.last_command(P).unwrap().1;
        assert!(matches!(desk.phase(P), Some(Phase::Held { .. })));
        desk.pile_says(P, Availability::Reserved, Some(lease));
        desk.robot_is(ROBOT, Activity::Approaching, Some(1));
        (desk, lease)
    }
}
