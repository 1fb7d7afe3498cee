//! Robots that can't come to a pile: mobile chargers, tows, and what becomes of the request.

use super::*;
use host_coordinator::core::{
    event::{HelpEnd, Plight, TowReason},
    orders::Order,
    state::{HelpStage, Sortie},
};

/// Robot 3 is a mobile charger.
const CHARGER: RobotId = RobotId(3);

impl Desk {
    /// A desk with a mobile charger that stands by at a pile, and robot 1 stranded at another.
    fn stranded(charger: bool) -> Self {
        let mut desk = Self::with_robots(Vec::new(), |robot| RobotConfig {
            gives_w: (charger && robot.id == CHARGER).then_some(100.0),
            full: if robot.id == CHARGER { EnergyJ::new(90_000.0).unwrap() } else { robot.full },
            ..robot
        });
        desk.charger_stands_by();
        desk.strands();
        desk
    }

    fn charger_stands_by(&mut self) {
        let (position, energy) = (self.beside(PileId(5)), EnergyJ::new(80_000.0).unwrap());
        let state = RobotState { position, energy, activity: Activity::Working, accepted: None };
        self.hear(DeviceId::Robot(CHARGER), Message::RobotState(state));
    }

    fn strands(&mut self) {
        let (position, energy) = (self.beside(P), EnergyJ::MIN);
        let state = RobotState { position, energy, activity: Activity::Stranded, accepted: None };
        self.hear(DeviceId::Robot(ROBOT), Message::RobotState(state));
    }

    /// Lets time pass in which both are heard.
    fn goes_on(&mut self, seconds: u64) {
        for _ in 0..seconds {
            self.wait(1_000);
            self.charger_stands_by();
            self.strands();
        }
    }

    fn help(&self) -> Option<HelpStage> {
        self.state().helps.get(&ROBOT).map(|help| help.stage)
    }

    fn sortie(&self) -> Sortie {
        *self.state().helps[&ROBOT].sortie().unwrap()
    }

    fn charger_says(&mut self, rescue: CommandId, phase: RescuePhase) {
        let given = EnergyJ::new(300.0).unwrap();
        let report = RescueState { rescue, phase, given };
        self.hear(DeviceId::Robot(CHARGER), Message::RescueState(report));
    }

    fn is_let_go(&self, rescue: CommandId) -> bool {
        let nack = Nack { of: Reference::Command(rescue), reason: NackReason::Ended };
        self.sent_to_robot(CHARGER).contains(&&Message::Nack(nack))
    }

    fn rescues(&self) -> Vec<&Rescue> {
        let sent = self.sent_to_robot(CHARGER).into_iter();
        sent.filter_map(|message| if let Message::Rescue(rescue) = message { Some(rescue) } else { None })
            .collect()
    }

    fn help_ends(&self) -> Vec<HelpEnd> {
        let ends = self.events.iter().filter_map(|event| match event.fact {
            Fact::HelpEnded { why, .. } => Some(why),
            _ => None,
        });
        ends.collect()
    }
}

#[test]
fn a_charger_is_sent_until_it_says_that_it_comes_and_gives_enough_for_the_nearest_pile() {
    let mut desk = Desk::stranded(true);
    let sortie = desk.sortie();
    let rescues = desk.rescues();
    assert_eq!((sortie.charger, rescues[0].rescue, rescues[0].robot), (CHARGER, sortie.command, ROBOT));
    let ways = (rescues[0].waypoints.first().copied(), rescues[0].waypoints.last().copied());
    assert_eq!(ways, (Some(desk.beside(PileId(5))), Some(desk.beside(P))));
    // The reserve, and a tenth of a battery in case that pile is taken.
    assert!((sortie.energy.get() - 1_200.0).abs() < 1.0, "it stands at a pile: {:?}", sortie.energy);
    desk.sent.clear();
    desk.goes_on(3);
    assert!((2..=4).contains(&desk.rescues().len()), "{}", desk.rescues().len());
    desk.charger_says(sortie.command, RescuePhase::Driving);
    desk.sent.clear();
    desk.goes_on(8);
    assert!(desk.rescues().is_empty());
    // It has started anew and does not know of it.
    desk.goes_on(4);
    assert!(!desk.rescues().is_empty());
}

#[test]
fn a_robot_that_was_charged_where_it_stood_asks_and_gets_a_pile() {
    let mut desk = Desk::stranded(true);
    let sortie = desk.sortie();
    desk.pile_says(P, Availability::Free, None);
    desk.charger_says(sortie.command, RescuePhase::Charging);
    assert!(desk.sortie().charging);
    desk.ask_from(ROBOT, 1, desk.beside(P), 2_000.0);
    desk.robot_is(ROBOT, Activity::Waiting, None);
    desk.wait(2_000);
    assert_eq!(desk.place(ROBOT), Some(Place::Waiting), "it is not torn from its charger");
    desk.charger_says(sortie.command, RescuePhase::Done);
    assert_eq!(desk.help_ends(), [HelpEnd::Charged { energy: EnergyJ::new(300.0).unwrap() }]);
    assert!(desk.is_let_go(sortie.command));
    assert_eq!(desk.place(ROBOT), Some(Place::Granted(P)));
}

#[test]
fn a_charger_that_is_about_what_nobody_wants_is_told_to_let_go() {
    let mut desk = Desk::stranded(true);
    let sortie = desk.sortie();
    // It moves again by itself.
    desk.robot_is(ROBOT, Activity::Working, None);
    assert_eq!(desk.help_ends(), [HelpEnd::NotNeeded]);
    assert!(!desk.is_let_go(sortie.command));
    desk.charger_says(sortie.command, RescuePhase::Driving);
    assert!(desk.is_let_go(sortie.command));
}

#[test]
fn after_a_restart_the_same_charger_goes_on_with_the_same_rescue() {
    let desk = Desk::stranded(true);
    let sortie = desk.sortie();
    let mut again = Desk::with_robots(desk.events.clone(), |robot| RobotConfig {
        gives_w: (robot.id == CHARGER).then_some(100.0),
        ..robot
    });
    assert_eq!(again.sortie(), sortie);
    again.wait(1_000);
    assert!(again.rescues().is_empty(), "nobody knows where it is");
    again.goes_on(2);
    assert_eq!(again.rescues()[0].rescue, sortie.command);
    again.charger_says(sortie.command, RescuePhase::Charging);
    assert!(again.sortie().charging && !again.is_let_go(sortie.command));
}

#[test]
fn chargers_that_fail_three_times_are_followed_by_a_tow() {
    let mut desk = Desk::stranded(true);
    for failures in 1..=3 {
        let sortie = desk.sortie();
        desk.charger_says(sortie.command, RescuePhase::GaveUp);
        assert!(desk.is_let_go(sortie.command));
        assert_eq!(desk.state().helps[&ROBOT].failures, failures);
        desk.goes_on(1);
    }
    assert_eq!(desk.help(), Some(HelpStage::Tow(TowReason::GaveUp)));
    assert!(desk.warnings.iter().any(|warning| warning.contains("robot 1 has to be towed")));
}

#[test]
fn a_charger_that_needs_a_charge_itself_is_not_waited_for() {
    let mut desk = Desk::stranded(true);
    desk.ask_from(CHARGER, 1, desk.beside(PileId(5)), 20_000.0);
    assert_eq!((desk.help(), desk.state().helps[&ROBOT].failures), (Some(HelpStage::Queued), 1));
}

#[test]
fn a_charger_that_does_not_come_in_time_is_given_up() {
    let mut desk = Desk::stranded(true);
    let first = desk.sortie();
    desk.goes_on(1 + first.until.since(desk.now).0 as u64 / 1_000);
    assert_eq!(desk.state().helps[&ROBOT].failures, 1);
    assert!(desk.sortie().command > first.command, "it is tried again");
}

#[test]
fn without_chargers_a_tow_is_wanted_at_once_and_stays_so_until_a_person_has_moved_the_robot() {
    let mut desk = Desk::stranded(false);
    desk.ask_from(ROBOT, 1, desk.beside(P), 0.0);
    assert_eq!(desk.help(), Some(HelpStage::Tow(TowReason::NoCharger)));
    let again = Desk::with_log(desk.events.clone());
    assert_eq!(again.help(), desk.help(), "a restart forgets nothing");
    desk.goes_on(3_600);
    assert_eq!(desk.help(), Some(HelpStage::Tow(TowReason::NoCharger)));
    // It is put on the contacts of a pile, which its empty battery reaches.
    let to = desk.beside(PileId(6));
    desk.pile_says(PileId(6), Availability::Free, None);
    desk.robot_at(ROBOT, to, Activity::Waiting, None);
    desk.step(Input::Order(Order::Towed { robot: ROBOT, to: Some(to) }));
    assert_eq!((desk.help(), desk.place(ROBOT)), (None, Some(Place::Granted(PileId(6)))));
}

#[test]
fn a_tow_that_nobody_wanted_changes_nothing() {
    let mut desk = Desk::new();
    let events = desk.events.len();
    desk.step(Input::Order(Order::Towed { robot: ROBOT, to: None }));
    assert_eq!(desk.events.len(), events);
}

#[test]
fn a_robot_that_is_still_stranded_after_its_tow_is_towed_again() {
    let mut desk = Desk::stranded(false);
    desk.step(Input::Order(Order::Towed { robot: ROBOT, to: None }));
    assert_eq!(desk.help_ends(), [HelpEnd::Towed { to: None }]);
    desk.goes_on(20);
    assert_eq!(desk.help(), None, "it may take a moment");
    desk.goes_on(20);
    assert_eq!(desk.help(), Some(HelpStage::Tow(TowReason::NoCharger)));
}

#[test]
fn a_robot_that_reaches_no_pile_is_helped_before_it_strands_and_not_when_it_reaches_one_after_all() {
    let mut desk = Desk::stranded(true);
    let robot = RobotId(2);
    let far = desk.site.position(desk.site.cell_at(40, 64).unwrap());
    desk.robot_at(robot, far, Activity::Waiting, None);
    desk.ask_from(robot, 1, far, 10.0);
    desk.wait(1_000);
    assert_eq!(desk.state().helps[&robot].plight, Plight::OutOfReach);
    desk.ask_from(robot, 2, far, 9_000.0);
    desk.wait(1_000);
    assert!(!desk.state().helps.contains_key(&robot));
}

#[test]
fn a_charger_with_too_little_for_both_waits_for_its_own_charge_and_people_come_if_that_lasts() {
    let mut desk = Desk::stranded(false);
    desk.events.clear();
    let mut desk = Desk::with_robots(desk.events, |robot| RobotConfig {
        gives_w: (robot.id == CHARGER).then_some(100.0),
        full: EnergyJ::new(90_000.0).unwrap(),
        ..robot
    });
    let weak = |desk: &mut Desk| {
        let (position, energy) = (desk.beside(PileId(5)), EnergyJ::new(900.0).unwrap());
        let state = RobotState { position, energy, activity: Activity::Working, accepted: None };
        desk.hear(DeviceId::Robot(CHARGER), Message::RobotState(state));
    };
    weak(&mut desk);
    desk.strands();
    assert_eq!(desk.help(), Some(HelpStage::Queued));
    for _ in 0..601 {
        desk.wait(1_000);
        weak(&mut desk);
        desk.strands();
    }
    assert_eq!(desk.help(), Some(HelpStage::Tow(TowReason::Waited)));
}
