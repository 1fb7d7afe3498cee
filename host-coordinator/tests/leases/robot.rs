//! A simple robot: it works, asks, follows its assignment, is charged and works again.

use std::collections::BTreeMap;

use host_coordinator::config::RobotConfig;
use protocol::{
    Activity, Assignment, ChargeRequest, EnergyJ, Epoch, Hello, Message, PileId, Position, RequestId,
    RobotState, Session, Sessions, TaskPriority,
};

const SPEED_MPS: f64 = 2.0;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mode {
    Working,
    Waiting,
    Approaching { pile: PileId, arrival: u64 },
    Docked { pile: PileId, since: u64, live_at: Option<u64> },
}

pub struct Robot {
    pub config: RobotConfig,
    pub greeted: bool,
    pub sessions: Sessions<[Session; 1]>,
    pub mode: Mode,
    pub energy: f32,
    pub position: Position,
    /// Where it works.
    pub home: Position,
    pub request: RequestId,
    pub parts: BTreeMap<u16, Vec<Position>>,
    pub say_at: u64,
}

impl Robot {
    pub fn take(&mut self, part: &Assignment, now: u64) {
        self.parts.insert(part.first, part.waypoints.to_vec());
        let route: Vec<_> = self.parts.values().flatten().copied().collect();
        if route.len() < usize::from(part.total) {
            return;
        }
        let coordinate = |position: &Position| (f64::from(position.x.get()), f64::from(position.y.get()));
        let length: f64 = route
            .windows(2)
            .map(|pair| {
                let ((x, y), (to_x, to_y)) = (coordinate(&pair[0]), coordinate(&pair[1]));
                (to_x - x).hypot(to_y - y)
            })
            .sum();
        self.parts.clear();
        let arrival = now + (length / SPEED_MPS * 1000.0) as u64;
        self.mode = Mode::Approaching { pile: part.pile, arrival };
        self.say_at = now;
    }

    pub fn talk(&self) -> Vec<Message> {
        let (position, energy) = (self.position, EnergyJ::clamped(self.energy));
        let (activity, accepted) = match self.mode {
            Mode::Working => (Activity::Working, None),
            Mode::Waiting => (Activity::Waiting, None),
            Mode::Approaching { .. } => (Activity::Approaching, Some(self.request)),
            Mode::Docked { .. } => (Activity::Docked, Some(self.request)),
        };
        let hello = (!self.greeted).then(|| Message::Hello(Hello::new(Epoch(0))));
        let mut messages: Vec<_> = hello.into_iter().collect();
        messages.push(Message::RobotState(RobotState { position, energy, activity, accepted }));
        if self.mode == Mode::Waiting {
            messages.push(Message::ChargeRequest(ChargeRequest {
                request: self.request,
                position,
                energy,
                task: None,
                priority: TaskPriority::USUAL,
            }));
        }
        messages
    }
}
