//! Help for robots that can't come to a pile: mobile chargers that give them energy, and people who tow them.

use protocol::{Activity, DurationMs, RobotId};

use super::{
    CHARGER,
    breach::Breach,
    faults::Fault,
    network::Node,
    rovers::MISSING,
    run::{Occasion, Run},
};
use crate::{
    core::{Input, ROBOT_PATIENCE, orders::Order, state::HelpStage},
    simulate::{charger::Charger, ground::Point, navigator::Navigator, robot::Robot},
};

/// What a mobile charger gives, in watts.
pub(super) const GIVES_W: f64 = 500.0;
/// A mobile charger charges itself when it has no more than this share of its full battery left.
const ALERT: f64 = 0.5;
/// It gives nothing of this share.
const KEEP: f64 = 0.1;
/// How close a mobile charger's coupling has to be to its robot, in metres.
const COUPLING_M: f64 = 1.0;
/// How long people take to a robot that is to be towed, in seconds: from, to.
const TOW_S: (f64, f64) = (60.0, 300.0);
/// How long they wait for a pile to become free, and for the coordinator.
const TOW_AGAIN: DurationMs = DurationMs(10_000);
/// A robot that stranded is helped, or its tow is wanted, within this: ten minutes in the queue, a charger that
/// does not come in time, and what delays both.
const HELPED_WITHIN: DurationMs = DurationMs(1_800_000);

/// The computer of a mobile charger that stands by at `home`.
pub(super) fn charger(robot: RobotId, navigator: Navigator, home: Point) -> Robot {
    let full_j = f64::from(CHARGER.full_j);
    Robot::new(robot, CHARGER.build(robot), navigator, ALERT * full_j).with_charger(Charger::new(
        home,
        GIVES_W,
        KEEP * full_j,
    ))
}

impl Run<'_> {
    /// The robot that a mobile charger is to charge, if it stands at its coupling.
    pub fn partner_of(&mut self, index: usize) -> Option<usize> {
        let charger = self.rovers[index].core.as_ref().and_then(Robot::charger)?;
        let partner = self.robot_index(charger.partner()?)?;
        self.sum_up(partner);
        let (one, other) = (&self.rovers[index].body, &self.rovers[partner].body);
        let couples =
            one.stands() && other.stands() && one.position().is_within(COUPLING_M, other.position());
        couples.then_some(partner)
    }

    /// Whether a mobile charger gives a robot energy.
    pub fn is_given_energy(&self, index: usize) -> bool {
        self.rovers.iter().skip(self.robots).any(|charger| charger.gives_to == Some(index))
    }

    /// What a mobile charger has given while this time passed.
    pub fn give_energy(&mut self, index: usize, passed: DurationMs) {
        let Some(partner) = self.rovers[index].gives_to else { return };
        let given_j = GIVES_W * f64::from(passed.0) / 1e3;
        self.rovers[index].body.charge(-given_j);
        let body = &mut self.rovers[partner].body;
        body.advance(self.now);
        body.charge(given_j);
    }

    /// People set off to tow a robot.
    pub fn call_for_tow(&mut self, robot: RobotId) {
        let wait_s = self.people.between(TOW_S.0, TOW_S.1);
        self.agenda.put(self.now.after(DurationMs::from_seconds(wait_s as f32)), Occasion::Tows(robot));
    }

    /// They have come: they put it on the contacts of a free pile, and say so.
    pub fn tow(&mut self, robot: RobotId) {
        let helps = &self.office.coordinator.state().helps;
        let wanted = helps.get(&robot).is_some_and(|help| matches!(help.stage, HelpStage::Tow(_)));
        if self.office.is_up() && !wanted {
            return;
        }
        let place = self.free_pile().filter(|_| self.office.is_up()).zip(self.robot_index(robot));
        let Some((place, index)) = place else {
            self.agenda.put(self.now.after(TOW_AGAIN), Occasion::Tows(robot));
            return;
        };
        self.sum_up(index);
        let rover = &mut self.rovers[index];
        rover.body.put(place);
        rover.route = rover.route.wrapping_add(1);
        self.step_robot(index, &[]);
        self.coordinate(Input::Order(Order::Towed { robot, to: Some(place.into()) }));
    }

    /// A pile that nobody uses or is to use, as people see it on the spot and on the dashboard.
    fn free_pile(&self) -> Option<Point> {
        let state = self.office.coordinator.state();
        let piles = self.ground.piles.iter().zip(&self.piles);
        let mut free = piles.filter(|((id, _, post), pile)| {
            let record = state.piles.get(id);
            let booked = record.is_some_and(|record| record.lease.is_some() || record.next.is_some());
            let occupied = self.rovers.iter().any(|rover| rover.body.position().is_within(COUPLING_M, *post));
            !booked && !occupied && pile.is_free()
        });
        free.next().map(|((_, _, post), _)| *post)
    }

    /// A robot that has stranded and was heard is in the book, and is helped before long, if not by people.
    pub fn check_helped(&mut self, index: usize) {
        let rover = &self.rovers[index];
        let robot = rover.id;
        if rover.activity() != Some(Activity::Stranded) {
            let rover = &mut self.rovers[index];
            (rover.helpless_since, rover.unbooked_since) = (None, None);
            return;
        }
        let help = self.office.coordinator.state().helps.get(&robot);
        let people_are_called = help.is_some_and(|help| matches!(help.stage, HelpStage::Tow(_)));
        let is_missing = self.office.is_up() && self.is_connected(Node::Robot(index)) && help.is_none();
        let (now, clock) = (self.now, self.trial.faults.contains(Fault::Clock));
        let rover = &mut self.rovers[index];
        if people_are_called {
            rover.helpless_since = Some(now);
        }
        let helpless_since = *rover.helpless_since.get_or_insert(now);
        let unbooked_since = if is_missing { *rover.unbooked_since.get_or_insert(now) } else { now };
        rover.unbooked_since = rover.unbooked_since.filter(|_| is_missing);
        if now.since(unbooked_since).0 > MISSING.0 + ROBOT_PATIENCE.0 {
            self.note(Breach::Forgotten { robot });
        } else if now.since(helpless_since) > HELPED_WITHIN && !clock {
            // A clock that is set back makes the coordinator wait for longer.
            self.note(Breach::Unhelped { robot });
        }
    }
}
