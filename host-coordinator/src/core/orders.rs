//! What a person, or a program of theirs, says over the API: that a robot is to be charged, that it need not, or
//! that it was towed.
//!
//! An order is checked before it becomes an event, so that it is done as it was answered. A robot that is
//! ordered to charge hears of it as one that the coordinator calls (`calls`).

use protocol::{
    DeviceId, Message, Position, RequestId, RobotId, TaskId, TaskPriority, Unassigned, UnassignedReason,
};

use super::{
    coordinator::Coordinator,
    event::{Fact, Opener, RevokeReason},
    state::{HelpStage, Place, Request},
    turn::Turn,
};

/// An order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order {
    /// A robot is to be charged.
    Charge {
        /// Which robot.
        robot: RobotId,
        /// What it will work on afterwards, if that is known.
        task: Option<TaskId>,
        /// How important that is.
        priority: TaskPriority,
    },
    /// A request that was ordered is not needed any more.
    Withdraw {
        /// Which one.
        request: RequestId,
    },
    /// A robot that was to be towed has been moved.
    Towed {
        /// Which robot.
        robot: RobotId,
        /// Where to, if that is known.
        to: Option<Position>,
    },
}

/// Why an order can't be done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// There is no such robot.
    #[error("there is no robot {0} in the fleet: see [[robot]] in the coordinator's configuration")]
    UnknownRobot(RobotId),
    /// Nobody knows where the robot is.
    #[error("robot {0} was not heard since the coordinator started: nobody knows where it is")]
    Unheard(RobotId),
    /// The robot has a request.
    #[error("robot {robot} has a request already: {request}")]
    Waiting {
        /// Which robot.
        robot: RobotId,
        /// Its request.
        request: RequestId,
    },
    /// The robot is being charged.
    #[error("robot {0} is being charged")]
    Charging(RobotId),
    /// There is no such request.
    #[error("there is no open request {0}")]
    UnknownRequest(RequestId),
    /// Nobody ordered the request.
    #[error("request {0} was not ordered: it ends with the charge, or when its robot goes back to work")]
    NotOrdered(RequestId),
    /// Nobody is to tow the robot.
    #[error("robot {0} is not to be towed; `helps` in /api/v1/state has those that are")]
    NotToBeTowed(RobotId),
}

impl Coordinator {
    /// Whether an order can be done now, and for which robot.
    ///
    /// # Errors
    /// [`Refusal`] says why not.
    pub fn check(&self, order: &Order) -> Result<RobotId, Refusal> {
        match *order {
            Order::Charge { robot, .. } => {
                if !self.robots.contains_key(&robot) {
                    return Err(Refusal::UnknownRobot(robot));
                }
                if let Some(Request { id, .. }) = self.state.requests.get(&robot) {
                    let charging = self.is_charged(robot);
                    let waiting = Refusal::Waiting { robot, request: *id };
                    return Err(if charging { Refusal::Charging(robot) } else { waiting });
                }
                let seen = self.observed.robots.get(&robot).and_then(|seen| seen.last);
                seen.map(|_| robot).ok_or(Refusal::Unheard(robot))
            }
            Order::Withdraw { request } => {
                let open = self.state.requests.iter().find(|(_, open)| open.id == request);
                let (&robot, open) = open.ok_or(Refusal::UnknownRequest(request))?;
                match open.opener {
                    _ if self.is_charged(robot) => Err(Refusal::Charging(robot)),
                    Opener::Person => Ok(robot),
                    Opener::Robot | Opener::Coordinator => Err(Refusal::NotOrdered(request)),
                }
            }
            Order::Towed { robot, .. } => {
                let help = self.state.helps.get(&robot);
                let is_towed = help.is_some_and(|help| matches!(help.stage, HelpStage::Tow(_)));
                if is_towed { Ok(robot) } else { Err(Refusal::NotToBeTowed(robot)) }
            }
        }
    }

    fn is_charged(&self, robot: RobotId) -> bool {
        let leases =
            self.state.piles.iter().filter_map(|(pile, record)| Some((*pile, record.lease.as_ref()?)));
        leases
            .filter(|(_, lease)| lease.name.robot == robot)
            .any(|(pile, lease)| self.is_charging(pile, lease))
    }

    /// Does an order, if it can be done.
    pub(super) fn obey(&mut self, turn: &mut Turn, order: &Order) {
        let Ok(robot) = self.check(order) else { return };
        match *order {
            Order::Charge { task, priority, .. } => {
                self.open_request(turn, robot, Opener::Person, task, priority);
            }
            Order::Withdraw { request } => {
                match self.state.requests.get(&robot).map(|open| open.place) {
                    // The lease is taken back, and the request ends with it.
                    Some(Place::Granted(pile)) => {
                        if let Some(lease) = self.state.lease(pile).map(|lease| lease.name) {
                            self.revoke(turn, pile, lease, RevokeReason::Withdrawn);
                        }
                    }
                    Some(Place::Next(pile)) => {
                        self.record(turn, Fact::NextReleased { pile, robot });
                        self.record(turn, Fact::Withdrawn { robot });
                    }
                    Some(Place::Waiting) => self.record(turn, Fact::Withdrawn { robot }),
                    None => {}
                }
                self.send_to_work(turn, robot, request);
            }
            Order::Towed { to, .. } => self.end_tow(turn, robot, to),
        }
    }

    /// Tells a robot that a request under which it was called is over.
    pub(super) fn send_to_work(&self, turn: &mut Turn, robot: RobotId, request: RequestId) {
        let reason = UnassignedReason::Withdrawn;
        turn.send(DeviceId::Robot(robot), Message::Unassigned(Unassigned { request, reason }));
    }
}
