//! Experiments 1 and 2 before the real coordinator: robots stand on the occupied points, are charged, and one
//! more asks.
//!
//! What a robot and a pile would say is said for them; who is sent where, whose charge is cut short and which
//! way is told are the coordinator's answers, with the paper's policy.

use std::sync::Arc;

use planning::{grid::Cell, path::Path};
use protocol::{
    Ack, Activity, Availability, BootEpoch, ChargeRequest, DeviceId, DurationMs, EnergyJ, Fraction, Frame,
    Header, LeaseRef, Message, PileId, PileRow, PileState, Position, Reference, RequestId, RobotId,
    RobotState, Sequence, SiteMillis, TagId, TaskPriority,
};

use crate::{
    config::{Policy, RobotConfig},
    core::{Coordinator, Effect, Event, Fact, Input, event::RevokeReason},
    selection::PolicyName,
    site::{Site, SitePile},
};

/// The number of the robot that asks; the others have those of their points.
const ASKER: u16 = 100;
/// A robot's full battery; the paper prints none.
const FULL_J: f32 = 100_000.0;
/// What the robot that asks has left, as a share: it is critical.
const NEARLY_EMPTY: f64 = 0.1;
/// For how long the others have been charged.
const CHARGED_FOR: DurationMs = DurationMs(600_000);

/// What the coordinator answers the robot that asks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answer {
    /// The point that it is sent to.
    pub pile: Option<PileId>,
    /// The point at which another's charge is cut short for it.
    pub makes_room: Option<PileId>,
    /// The way that it is told; none if it is told none.
    pub way: Option<Path>,
}

/// A robot at `from` asks, while robots with what `charged` says of a full battery are charged at the piles for
/// which it says something.
#[must_use]
pub fn ask(site: &Arc<Site>, from: Cell, charged: impl Fn(&SitePile) -> Option<f64>) -> Answer {
    let mut scene = Scene::new(site);
    for (number, pile) in (1..).zip(&site.piles) {
        scene.pile_says(pile.id, Availability::Free, None);
        if let Some(share) = charged(pile) {
            let robot = RobotId(number);
            scene.robot_asks(robot, site.position(pile.cell), share);
            scene.pile_obeys(pile.id);
            scene.robot_says(robot, site.position(pile.cell), share, Activity::Charging, true);
        }
    }
    let asker = RobotId(ASKER);
    scene.robot_asks(asker, site.position(from), NEARLY_EMPTY);
    scene.answer(asker)
}

/// The coordinator, and those who speak to it.
struct Scene {
    site: Arc<Site>,
    coordinator: Coordinator,
    events: Vec<Event>,
    sent: Vec<(DeviceId, Message)>,
    said: u32,
}

impl Scene {
    fn new(site: &Arc<Site>) -> Self {
        let ids = (1..).zip(&site.piles).map(|(number, _)| number).chain([ASKER]);
        let robots: Vec<_> = ids
            .map(|id| RobotConfig {
                id: RobotId(id),
                tag: TagId([id as u8; 12]),
                full: EnergyJ::clamped(FULL_J),
                energy_per_metre_j: 10.0,
                speed_mps: 1.0,
                gives_w: None,
            })
            .collect();
        let policy = Policy { choose: PolicyName::Access, ..Policy::default() };
        let coordinator = Coordinator::recover(Arc::clone(site), site.lmpp(1.0), policy, &robots, []);
        let (events, sent) = (Vec::new(), Vec::new());
        let mut scene = Self { site: Arc::clone(site), coordinator, events, sent, said: 0 };
        scene.step(Input::Started { boot_floor: BootEpoch(1) });
        scene
    }

    fn step(&mut self, input: Input) {
        let step = self.coordinator.step(SiteMillis(0).after(CHARGED_FOR), input);
        self.events.extend(step.events);
        self.sent.extend(step.effects.into_iter().filter_map(|effect| match effect {
            Effect::Send { to, message } => Some((to, message)),
            Effect::Warn(_) => None,
        }));
    }

    fn hear(&mut self, sender: DeviceId, message: Message) {
        self.said += 1;
        let header = Header::new(sender, BootEpoch(1), Sequence(self.said));
        self.step(Input::Frame(Frame { header, message }));
    }

    fn robot_asks(&mut self, robot: RobotId, position: Position, share: f64) {
        self.robot_says(robot, position, share, Activity::Waiting, false);
        let asked = ChargeRequest {
            request: RequestId(1),
            position,
            energy: energy(share),
            task: None,
            priority: TaskPriority::USUAL,
        };
        self.hear(DeviceId::Robot(robot), Message::ChargeRequest(asked));
    }

    fn robot_says(
        &mut self,
        robot: RobotId,
        position: Position,
        share: f64,
        activity: Activity,
        accepts: bool,
    ) {
        let accepted = accepts.then_some(RequestId(1));
        let state = RobotState { position, energy: energy(share), activity, accepted };
        self.hear(DeviceId::Robot(robot), Message::RobotState(state));
    }

    fn pile_says(&mut self, pile: PileId, availability: Availability, holder: Option<LeaseRef>) {
        let charges = holder.is_some();
        let row = PileRow {
            pile,
            boot: BootEpoch(1),
            version: self.said,
            stamp: None,
            availability,
            remaining: if charges { Fraction::MAX } else { Fraction::default() },
            planned: if charges { CHARGED_FOR } else { DurationMs(0) },
        };
        let elapsed = if charges { CHARGED_FOR } else { DurationMs(0) };
        let state = PileState {
            row,
            elapsed,
            holder,
            energised: charges,
            ended: None,
            standing: None,
            current: None,
        };
        self.hear(DeviceId::Pile(pile), Message::PileState(state));
    }

    /// The pile accepts the lease that it was sent last, and charges.
    fn pile_obeys(&mut self, pile: PileId) {
        let grant = self.sent.iter().rev().find_map(|(to, message)| match message {
            Message::Grant(grant) if *to == DeviceId::Pile(pile) => Some((grant.head.id, grant.lease)),
            _ => None,
        });
        if let Some((command, lease)) = grant {
            self.hear(DeviceId::Pile(pile), Message::Ack(Ack { of: Reference::Command(command) }));
            self.pile_says(pile, Availability::Charging, Some(lease));
        }
    }

    fn answer(&mut self, asker: RobotId) -> Answer {
        let chosen = self.events.iter().rev().find_map(|event| match &event.fact {
            Fact::Decided(decision) if decision.robot == asker => decision.chosen,
            _ => None,
        });
        let makes_room = self.events.iter().find_map(|event| match event.fact {
            Fact::Revoked { pile, why: RevokeReason::Preempted, .. } => Some(pile),
            _ => None,
        });
        // A free point accepts before anybody is sent there.
        if let Some(pile) = chosen.filter(|_| makes_room.is_none()) {
            self.pile_obeys(pile);
        }
        let way = self.sent.iter().filter_map(|(to, message)| match message {
            Message::Assignment(part) if *to == DeviceId::Robot(asker) => Some(&part.waypoints),
            _ => None,
        });
        let way = way.flatten().filter_map(|waypoint| self.site.cell_of(*waypoint));
        Answer { pile: chosen, makes_room, way: path(way) }
    }
}

/// The path through cells where it turns, each straight or diagonal from the one before.
fn path(mut turns: impl Iterator<Item = Cell>) -> Option<Path> {
    let mut path = Path::at(turns.next()?);
    for turn in turns {
        while path.end() != turn {
            let Cell { x, y } = path.end();
            path.step(((turn.x - x).signum(), (turn.y - y).signum()));
        }
    }
    Some(path)
}

fn energy(share: f64) -> EnergyJ {
    EnergyJ::clamped((share * f64::from(FULL_J)) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_free_point_is_given_and_nobody_makes_room() {
        let site = Arc::new(Site::access_fig1().unwrap());
        let start = site.cell_at(90, 80).unwrap();
        let answer = ask(&site, start, |pile| pile.charged.filter(|_| pile.id != PileId(5)));
        assert_eq!((answer.pile, answer.makes_room), (Some(PileId(5)), None));
        let way = answer.way.unwrap();
        assert_eq!((way.start(), way.end()), (start, site.pile(PileId(5)).unwrap().cell));
        assert!(way.is_walkable(&site.grid, site.moves));
    }

    #[test]
    fn nobody_makes_room_who_has_too_little_for_a_task() {
        let site = Arc::new(Site::access_fig1().unwrap());
        let start = site.cell_at(90, 80).unwrap();
        let answer = ask(&site, start, |_| Some(0.2));
        assert_eq!(answer, Answer::default());
    }
}
