//! What is lost, said wrongly or said twice: the rows of "What is lost, and what follows" in
//! docs/operating.md, one test a row.

use host_coordinator::core::event::{Contradiction, Device};

use super::*;

const OTHER: RobotId = RobotId(2);

fn tag(robot: RobotId) -> Option<TagId> {
    Some(TagId([robot.0 as u8; 12]))
}

fn amperes(current: f32) -> Option<CurrentA> {
    Some(CurrentA::new(current).unwrap())
}

impl Desk {
    /// So many seconds, in each of which what `says` says is heard.
    fn hears_for(&mut self, seconds: u64, mut says: impl FnMut(&mut Self)) {
        for _ in 0..seconds {
            says(self);
            self.wait(1_000);
        }
    }

    fn has(&self, fact: &Fact) -> usize {
        self.events.iter().filter(|event| event.fact == *fact).count()
    }

    fn contradictions(&self) -> Vec<(PileId, Option<RobotId>, Contradiction)> {
        let facts = self.events.iter().filter_map(|event| match event.fact {
            Fact::Contradicted { pile, robot, what } => Some((pile, robot, what)),
            _ => None,
        });
        facts.collect()
    }

    /// A place where no pile is.
    fn away(&self) -> Position {
        let is_pile = |cell: &planning::grid::Cell| self.site.piles.iter().any(|pile| pile.cell == *cell);
        let cell = self.site.grid.free_cells().find(|cell| !is_pile(cell));
        self.site.position(cell.unwrap())
    }

    /// What the API says of a pile.
    fn shown(&self, pile: PileId) -> serde_json::Value {
        let view = self.coordinator.view(self.now);
        serde_json::to_value(view.piles.iter().find(|row| row.id == pile).unwrap()).unwrap()
    }

    /// A robot with the lease on the pile where it stands, which charges it with this current.
    fn charging(current: f32) -> (Self, LeaseRef) {
        let (mut desk, lease) = Self::granted();
        desk.current = amperes(current);
        desk.pile_says(P, Availability::Charging, Some(lease));
        (desk, lease)
    }
}

#[test]
fn a_pile_that_falls_silent_is_recorded_gets_no_robot_and_is_recorded_when_it_is_back() {
    let (mut desk, _) = Desk::granted();
    let who = Device::Pile(P);
    desk.hears_for(12, |desk| desk.robot_is(ROBOT, Activity::Approaching, Some(1)));
    assert_eq!(desk.has(&Fact::FellSilent { who }), 1);
    assert_eq!(desk.shown(P)["availability"], "unknown");
    desk.hears_for(120, |desk| desk.robot_is(ROBOT, Activity::Approaching, Some(1)));
    assert_eq!((desk.ends(), desk.place(ROBOT)), (vec![LeaseEnd::RanOut], Some(Place::Waiting)));
    desk.hears_for(2, |desk| desk.pile_says(P, Availability::Free, None));
    assert_eq!((desk.has(&Fact::FellSilent { who }), desk.has(&Fact::HeardAgain { who })), (1, 1));
}

#[test]
fn a_robot_that_falls_silent_is_recorded_and_its_lease_runs_out_unless_it_arrives() {
    let (mut desk, lease) = Desk::granted();
    let who = Device::Robot(ROBOT);
    desk.hears_for(12, |desk| desk.pile_says(P, Availability::Reserved, Some(lease)));
    assert_eq!(desk.has(&Fact::FellSilent { who }), 1);
    let extended = |desk: &Desk| desk.state().lease(P).unwrap().expiry;
    desk.hears_for(60, |desk| desk.pile_says(P, Availability::Reserved, Some(lease)));
    let expiry = extended(&desk);
    desk.hears_for(60, |desk| desk.pile_says(P, Availability::Reserved, Some(lease)));
    assert_eq!(extended(&desk), expiry, "nobody extends it");
    desk.robot_is(ROBOT, Activity::Approaching, Some(1));
    desk.wait(1_000);
    assert_eq!(desk.has(&Fact::HeardAgain { who }), 1);
}

#[test]
fn a_coordinator_that_starts_anew_says_so_and_has_the_same_leases_under_a_higher_epoch() {
    let (desk, lease) = Desk::granted();
    let (before, epoch) = (desk.state().lease(P).unwrap().name, desk.state().epoch);
    let desk = Desk::with_log(desk.events);
    assert_eq!((desk.state().lease(P).unwrap().name, before.lease), (before, lease.lease));
    assert!(desk.state().epoch > epoch);
    let starts = desk.events.iter().filter(|event| matches!(event.fact, Fact::Started { .. })).count();
    assert_eq!(starts, 2);
    assert_eq!(desk.has(&Fact::ClockSetBack { by: DurationMs(0) }), 0);
}

#[test]
fn a_clock_that_went_back_is_recorded_and_told_at_the_start() {
    let mut desk = Desk::new();
    desk.wait(3_600_000);
    desk.pile_says(P, Availability::Free, None);
    desk.ask(ROBOT, 1);
    let desk = Desk::with_log(desk.events);
    assert_eq!(desk.has(&Fact::ClockSetBack { by: DurationMs(3_600_000) }), 1);
    assert!(desk.warnings.iter().any(|text| text.contains("3600 s behind")), "{:?}", desk.warnings);
}

#[test]
fn what_comes_twice_happens_once_and_leaves_no_event() {
    let (mut desk, _) = Desk::granted();
    let before = (desk.events.clone(), desk.state().clone());
    desk.ask(ROBOT, 1);
    desk.ack(P);
    assert_eq!((desk.events, desk.coordinator.state().clone()), before);
}

#[test]
fn a_command_that_came_late_is_recorded_as_deferred_and_given_anew() {
    let mut desk = Desk::new();
    desk.pile_says(P, Availability::Free, None);
    desk.ask(ROBOT, 1);
    let (command, lease, _) = desk.last_command(P).unwrap();
    desk.nack(P, NackReason::TooLate);
    assert_eq!(desk.has(&Fact::Deferred { pile: P, lease: lease.lease, reason: NackReason::TooLate }), 1);
    desk.wait(1_100);
    let (again, same, is_grant) = desk.last_command(P).unwrap();
    assert!(is_grant && again != command && same == lease);
}

#[test]
fn a_robot_at_a_pile_without_a_lease_keeps_others_away_and_gets_the_pile_when_it_asks() {
    let mut desk = Desk::new();
    desk.standing = tag(OTHER);
    let says = |desk: &mut Desk| {
        desk.pile_says(P, Availability::Done, None);
        desk.robot_is(ROBOT, Activity::Waiting, None);
        desk.robot_at(OTHER, desk.beside(P), Activity::Working, None);
    };
    desk.hears_for(29, says);
    assert_eq!(desk.contradictions(), [], "it may only pass");
    desk.ask(ROBOT, 1);
    desk.hears_for(5, says);
    assert_eq!(desk.contradictions(), [(P, Some(OTHER), Contradiction::Unleased)]);
    assert_eq!(desk.shown(P)["contradiction"]["what"], "unleased");
    assert!(desk.warnings.iter().any(|text| text.contains("robot 2 stands at pile 2 without a lease")));
    assert_eq!(desk.place(ROBOT), Some(Place::Waiting));
    desk.ask(OTHER, 1);
    desk.wait(1_000);
    assert_eq!(desk.place(OTHER), Some(Place::Granted(P)), "nobody else could use it");
    desk.standing = None;
    let lease = desk.last_command(P).unwrap().1;
    desk.hears_for(2, |desk| desk.pile_says(P, Availability::Charging, Some(lease)));
    assert_eq!(desk.has(&Fact::ContradictionOver { pile: P }), 1);
    assert!(desk.shown(P)["contradiction"].is_null());
}

#[test]
fn a_robot_that_says_it_stands_at_a_pile_whose_reader_does_not_see_it_counts_too() {
    let mut desk = Desk::new();
    let says = |desk: &mut Desk| {
        desk.pile_says(P, Availability::Free, None);
        desk.robot_at(OTHER, desk.beside(P), Activity::Working, None);
    };
    desk.hears_for(32, says);
    assert_eq!(desk.contradictions(), [(P, Some(OTHER), Contradiction::Unleased)]);
    desk.ask(ROBOT, 1);
    desk.wait(1_000);
    assert_eq!(desk.place(ROBOT), Some(Place::Waiting));
    desk.robot_at(OTHER, desk.away(), Activity::Working, None);
    desk.hears_for(2, |desk| desk.pile_says(P, Availability::Free, None));
    assert_eq!(desk.has(&Fact::ContradictionOver { pile: P }), 1);
    assert_eq!(desk.place(ROBOT), Some(Place::Granted(P)));
}

#[test]
fn whoever_a_pile_is_reserved_for_waits_again_while_another_stands_there() {
    let (mut desk, lease) = Desk::granted();
    desk.standing = tag(OTHER);
    desk.hears_for(32, |desk| {
        desk.pile_says(P, Availability::Reserved, Some(lease));
        desk.robot_at(ROBOT, desk.away(), Activity::Approaching, Some(1));
    });
    assert_eq!(desk.contradictions(), [(P, Some(OTHER), Contradiction::Unleased)]);
    assert_eq!(desk.phase(P), Some(Phase::Revoking { why: RevokeReason::Occupied }));
    assert_eq!(desk.place(ROBOT), Some(Place::Waiting));
}

#[test]
fn a_charge_without_current_is_recorded_taken_back_and_not_begun_again_at_once() {
    let (mut desk, lease) = Desk::charging(0.0);
    let says = |desk: &mut Desk| {
        desk.pile_says(P, Availability::Charging, Some(lease));
        desk.robot_is(ROBOT, Activity::Charging, Some(1));
    };
    desk.hears_for(32, says);
    assert_eq!(desk.contradictions(), [(P, Some(ROBOT), Contradiction::NoCurrent)]);
    assert_eq!(desk.phase(P), Some(Phase::Revoking { why: RevokeReason::NoCurrent }));
    assert_eq!(desk.place(ROBOT), Some(Place::Waiting));
    desk.ack(P);
    desk.standing = tag(ROBOT);
    desk.hears_for(10, |desk| {
        desk.pile_says(P, Availability::Done, None);
        desk.robot_is(ROBOT, Activity::Charging, Some(1));
    });
    assert_eq!(desk.place(ROBOT), Some(Place::Waiting));
    assert_eq!(desk.contradictions().len(), 1);
}

#[test]
fn a_charge_with_current_contradicts_nobody() {
    let (mut desk, lease) = Desk::charging(10.0);
    desk.hears_for(60, |desk| {
        desk.pile_says(P, Availability::Charging, Some(lease));
        desk.robot_is(ROBOT, Activity::Charging, Some(1));
    });
    assert_eq!(desk.contradictions(), []);
}

#[test]
fn a_pile_that_charges_a_robot_which_says_it_is_elsewhere_goes_on_and_is_recorded() {
    let (mut desk, lease) = Desk::charging(10.0);
    desk.hears_for(60, |desk| {
        desk.pile_says(P, Availability::Charging, Some(lease));
        desk.robot_at(ROBOT, desk.away(), Activity::Working, None);
    });
    assert_eq!(desk.contradictions(), [(P, Some(ROBOT), Contradiction::NotDocked)]);
    assert!(matches!(desk.phase(P), Some(Phase::Held { .. })));
    assert!(desk.warnings.iter().any(|text| text.contains("pile 2 charges robot 1")), "{:?}", desk.warnings);
}
