//! A step in the making: what has come of it so far, and whom it concerns.

use std::collections::BTreeSet;

use protocol::{DeviceId, Message, PileId, RobotId, SiteMillis};

use super::{
    coordinator::{Coordinator, Effect, Step},
    event::{Device, Fact},
    state::Place,
};

/// A step in the making.
pub(super) struct Turn {
    pub now: SiteMillis,
    pub step: Step,
    pub concerned: Concerned,
}

/// Whose leases and requests a step has to settle.
#[derive(Debug, Default)]
pub(super) struct Concerned {
    everybody: bool,
    piles: BTreeSet<PileId>,
    robots: BTreeSet<RobotId>,
}

impl Concerned {
    /// Everybody: time has passed, or the epoch is a new one.
    pub const fn everybody(&mut self) {
        self.everybody = true;
    }

    /// The sender of a frame.
    pub fn device(&mut self, device: DeviceId) {
        match device {
            DeviceId::Pile(pile) => _ = self.piles.insert(pile),
            DeviceId::Robot(robot) => _ = self.robots.insert(robot),
            _ => {}
        }
    }

    /// Whoever an event names.
    pub fn fact(&mut self, fact: &Fact) {
        let (pile, robot) = match fact {
            Fact::Started { .. } | Fact::EpochStarted { .. } => {
                self.everybody();
                return;
            }
            Fact::FellSilent { who: Device::Pile(pile) }
            | Fact::HeardAgain { who: Device::Pile(pile) }
            | Fact::Contradicted { pile, .. }
            | Fact::ContradictionOver { pile } => (Some(*pile), None),
            Fact::FellSilent { who: Device::Robot(robot) }
            | Fact::HeardAgain { who: Device::Robot(robot) }
            | Fact::Asked { robot, .. }
            | Fact::Withdrawn { robot }
            | Fact::Stranded { robot }
            | Fact::Recovered { robot }
            | Fact::HelpEnded { robot, .. } => (None, Some(*robot)),
            Fact::NextReserved { pile, robot }
            | Fact::NextReleased { pile, robot }
            | Fact::Assigned { robot, pile }
            | Fact::Ended { pile, robot, .. } => (Some(*pile), Some(*robot)),
            Fact::Granted { pile, lease, .. }
            | Fact::Extended { pile, lease, .. }
            | Fact::Revoked { pile, lease, .. }
            | Fact::Adopted { pile, lease } => (Some(*pile), Some(lease.robot)),
            Fact::Accepted { pile, .. } | Fact::Deferred { pile, .. } | Fact::Refused { pile, .. } => {
                (Some(*pile), None)
            }
            Fact::Decided(_)
            | Fact::ClockSetBack { .. }
            | Fact::TaskDone { .. }
            | Fact::Passed { .. }
            | Fact::Charged { .. }
            | Fact::FaultReported { .. }
            | Fact::HelpWanted { .. }
            | Fact::ChargerSent { .. }
            | Fact::ChargerArrived { .. }
            | Fact::ChargerFreed { .. }
            | Fact::TowWanted { .. } => {
                return;
            }
        };
        self.piles.extend(pile);
        self.robots.extend(robot);
    }
}

impl Turn {
    pub fn send(&mut self, to: DeviceId, message: Message) {
        self.step.effects.push(Effect::Send { to, message });
    }

    pub fn warn(&mut self, text: String) {
        self.step.effects.push(Effect::Warn(text));
    }
}

impl Coordinator {
    /// The robots whose requests are to be settled: of those concerned the ones that ask.
    pub(super) fn concerned_robots(&self, turn: &Turn) -> Vec<RobotId> {
        if turn.concerned.everybody {
            return self.state.requests.keys().copied().collect();
        }
        // Who holds a pile is told what becomes of it.
        let held = turn.concerned.piles.iter().filter_map(|pile| self.state.piles.get(pile));
        let held = held.flat_map(|record| [record.next, record.lease.as_ref().map(|lease| lease.name.robot)]);
        let mut robots = turn.concerned.robots.clone();
        robots.extend(held.flatten());
        robots.into_iter().filter(|robot| self.state.requests.contains_key(robot)).collect()
    }

    /// The piles whose leases and promises are to be settled: those concerned, and where the robots
    /// concerned have been sent.
    pub(super) fn concerned_piles(&self, turn: &Turn) -> Vec<PileId> {
        if turn.concerned.everybody {
            return self.state.piles.keys().copied().collect();
        }
        let requests = turn.concerned.robots.iter().filter_map(|robot| self.state.requests.get(robot));
        let sent = requests.filter_map(|request| match request.place {
            Place::Waiting => None,
            Place::Next(pile) | Place::Granted(pile) => Some(pile),
        });
        let mut piles = turn.concerned.piles.clone();
        piles.extend(sent);
        piles.into_iter().filter(|pile| self.state.piles.contains_key(pile)).collect()
    }
}
