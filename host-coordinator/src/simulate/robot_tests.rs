use protocol::{
    Availability, BootEpoch, ClaimRef, Fraction, NackReason, PileRow, PileTable, RescuePhase, RobotId, TagId,
    Unassigned, UnassignedReason,
};

use super::*;
use crate::{
    simulate::{random::Random, terrain::Terrain},
    site::Site,
};
use std::sync::Arc;

const ALERT_J: f64 = 1_000.0;
const PILE: PileId = PileId(2);
const BUILD: Build =
    Build { tag: TagId([1; 12]), full_j: 10_000.0, idle_w: 1.0, drive_j_per_m: 1.0, speed_mps: 0.5 };

/// A robot with its surroundings under the test's control.
struct Rig {
    site: Arc<Site>,
    robot: Robot,
    now: Millis,
    sensed: Sensed,
}

impl Rig {
    /// In the middle of a room, far from every pile.
    fn new() -> Self {
        let site = Arc::new(Site::fig7().unwrap());
        let terrain = Arc::new(Terrain::new(&site));
        let robot = Robot::new(RobotId(1), BUILD, Navigator::new(terrain, Random::new(1, 1)), ALERT_J);
        let position = Point { x_m: 40.0, y_m: 85.0 };
        let sensed = Sensed {
            position,
            energy_j: 5_000.0,
            arrived: true,
            end_clear: true,
            contacts_live: false,
            partner: false,
        };
        Self { site, robot, now: Millis(0), sensed }
    }

    fn waiting() -> (Self, RequestId) {
        let mut rig = Self::new();
        rig.sensed.energy_j = ALERT_J;
        let asked = requests(&rig.after(100, &[]));
        assert_eq!(rig.robot.activity(), Activity::Waiting);
        (rig, asked[0])
    }

    /// On the contacts of its pile.
    fn docked() -> Self {
        let (mut rig, request) = Self::waiting();
        rig.after(100, &[rig.assignment(request, PILE)]);
        (rig.sensed.position, rig.sensed.arrived) = (rig.dock(PILE), true);
        rig.after(100, &[]);
        assert_eq!(rig.robot.activity(), Activity::Docked);
        rig
    }

    fn after(&mut self, millis: u32, heard: &[Message]) -> Outputs {
        self.now = self.now.after(DurationMs(millis));
        let outputs = self.robot.step(self.now, &self.sensed, heard);
        if outputs.route.is_some() {
            self.sensed.arrived = false;
        }
        outputs
    }

    fn dock(&self, pile: PileId) -> Point {
        self.site.position(self.site.pile(pile).unwrap().cell).into()
    }

    fn assignment(&self, request: RequestId, pile: PileId) -> Message {
        let waypoints = [self.sensed.position.into(), self.dock(pile).into()].into_iter().collect();
        Message::Assignment(Assignment { request, pile, total: 2, first: 0, waypoints })
    }
}

fn requests(outputs: &Outputs) -> Vec<RequestId> {
    let asked = outputs.messages.iter().filter_map(|message| match message {
        Message::ChargeRequest(asked) => Some(asked.request),
        _ => None,
    });
    asked.collect()
}

fn accepted(outputs: &Outputs) -> Option<RequestId> {
    outputs.messages.iter().find_map(|message| match message {
        Message::RobotState(state) => state.accepted,
        _ => None,
    })
}

#[test]
fn a_robot_without_an_answer_keeps_asking_under_one_number() {
    let (mut rig, request) = Rig::waiting();
    let asked: Vec<_> = (0..100).flat_map(|_| requests(&rig.after(100, &[]))).collect();
    assert_eq!(asked, [request; 10]);
}

#[test]
fn a_robot_that_is_told_to_wait_asks_again_but_not_at_once() {
    let (mut rig, request) = Rig::waiting();
    let wait = Message::Unassigned(Unassigned { request, reason: UnassignedReason::AllTaken });
    rig.after(100, &[wait]);
    assert!((0..99).all(|_| requests(&rig.after(100, &[])).is_empty()));
    assert_eq!(requests(&rig.after(100, &[])), [request]);
}

#[test]
fn a_robot_whose_assignment_is_taken_back_waits_again_and_clears_the_dock() {
    for docked in [false, true] {
        let (mut rig, request) = if docked {
            let rig = Rig::docked();
            let request = rig.robot.request;
            (rig, request)
        } else {
            Rig::waiting()
        };
        rig.after(100, &[rig.assignment(request, PILE)]);
        let back = Message::Unassigned(Unassigned { request, reason: UnassignedReason::AllTaken });
        let outputs = rig.after(100, &[back]);
        assert_eq!((rig.robot.activity(), accepted(&outputs)), (Activity::Waiting, None));
        assert_eq!(outputs.moving, docked, "a robot away from the piles stands and waits");
        rig.after(100, &[rig.assignment(request, PileId(5))]);
        assert_eq!(rig.robot.activity(), Activity::Approaching);
    }
}

#[test]
fn a_robot_at_work_follows_a_call_and_no_other_assignment_and_works_on_when_it_is_withdrawn() {
    let mut rig = Rig::new();
    rig.after(100, &[]);
    rig.after(100, &[rig.assignment(RequestId(9), PILE)]);
    assert_eq!(rig.robot.activity(), Activity::Working);
    let call = RequestId(RequestId::FIRST_CALL.0 + 9);
    let outputs = rig.after(100, &[rig.assignment(call, PILE)]);
    assert_eq!((rig.robot.activity(), accepted(&outputs)), (Activity::Approaching, Some(call)));
    let answer = |reason| Message::Unassigned(Unassigned { request: call, reason });
    rig.after(100, &[answer(UnassignedReason::AllTaken)]);
    assert_eq!(rig.robot.activity(), Activity::Waiting);
    rig.after(100, &[rig.assignment(call, PILE)]);
    rig.after(100, &[answer(UnassignedReason::Withdrawn)]);
    assert_eq!(rig.robot.activity(), Activity::Working);
}

#[test]
fn a_robot_sets_off_only_with_the_whole_route_and_says_so() {
    let (mut rig, request) = Rig::waiting();
    let Message::Assignment(whole) = rig.assignment(request, PILE) else { unreachable!() };
    let half = |first: u16| {
        let waypoints = whole.waypoints.iter().skip(first.into()).take(1).copied().collect();
        Message::Assignment(Assignment { first, waypoints, ..whole.clone() })
    };
    let first_half = rig.after(100, &[half(1)]);
    assert_eq!((first_half.route, rig.robot.activity()), (None, Activity::Waiting));
    let outputs = rig.after(100, &[half(0)]);
    assert_eq!(accepted(&outputs), Some(request));
    assert_eq!(outputs.route.unwrap().back(), Some(&rig.dock(PILE)));
    assert!(outputs.moving);
}

#[test]
fn repeats_and_answers_to_older_requests_change_nothing_and_another_pile_does() {
    let (mut rig, request) = Rig::waiting();
    rig.after(100, &[rig.assignment(RequestId(request.0.wrapping_sub(1)), PILE)]);
    assert_eq!(rig.robot.activity(), Activity::Waiting);
    rig.after(100, &[rig.assignment(request, PILE)]);
    assert_eq!(rig.after(100, &[rig.assignment(request, PILE)]).route, None);
    let changed = rig.after(100, &[rig.assignment(request, PileId(1))]);
    assert_eq!(changed.route.unwrap().back(), Some(&rig.dock(PileId(1))));
}

#[test]
fn a_robot_waits_beside_a_taken_dock_and_enters_when_it_is_clear() {
    let (mut rig, request) = Rig::waiting();
    rig.after(100, &[rig.assignment(request, PILE)]);
    rig.sensed.end_clear = false;
    assert!(rig.after(100, &[]).moving, "it is still far off");
    let dock = rig.dock(PILE);
    rig.sensed.position = Point { x_m: dock.x_m, y_m: dock.y_m + 0.9 * KEEP_CLEAR_M };
    assert!(!rig.after(100, &[]).moving);
    assert_eq!(rig.robot.activity(), Activity::Approaching);
    rig.sensed.end_clear = true;
    assert!(rig.after(100, &[]).moving);
}

#[test]
fn a_charge_is_over_when_live_contacts_go_dead_for_longer_than_a_bounce() {
    let mut rig = Rig::docked();
    rig.sensed.contacts_live = true;
    rig.sensed.energy_j = 4_000.0;
    rig.after(100, &[]);
    rig.sensed.contacts_live = false;
    rig.after(1_000, &[]);
    assert_eq!(rig.robot.activity(), Activity::Charging, "a bounce");
    let outputs = rig.after(1_000, &[]);
    assert_eq!(rig.robot.activity(), Activity::Working);
    assert!(outputs.route.is_some() && outputs.moving);
    assert_eq!(accepted(&outputs), None);
}

#[test]
fn a_robot_at_a_dead_pile_gives_up_clears_the_dock_and_asks_anew() {
    let mut rig = Rig::docked();
    let first = rig.robot.request;
    let steps = 10 * PATIENCE.0 / 1_000;
    assert!((1..steps).all(|_| requests(&rig.after(100, &[])).is_empty()));
    assert_eq!(rig.robot.activity(), Activity::Docked);
    assert!(rig.after(100, &[]).route.is_some());
    let outputs = rig.after(100, &[]);
    assert_eq!(requests(&outputs), [RequestId(first.0 + 1)]);
    assert!(outputs.moving, "it asks on its way out of the dock");
    rig.sensed.position = Point { x_m: 40.0, y_m: 85.0 };
    assert!(!rig.after(100, &[]).moving, "clear of the pile, it saves its energy");
}

#[test]
fn a_robot_without_energy_has_stranded_and_says_so_once_a_second() {
    let mut rig = Rig::new();
    rig.sensed.energy_j = 0.0;
    let outputs = rig.after(100, &[]);
    assert_eq!(rig.robot.activity(), Activity::Stranded);
    assert!(!outputs.moving);
    let said = (0..100).flat_map(|_| rig.after(100, &[]).messages).filter(
        |message| matches!(message, Message::RobotState(state) if state.activity == Activity::Stranded),
    );
    assert_eq!(said.count(), 10);
}

#[test]
fn it_tells_what_a_whole_run_of_a_task_took_and_names_the_task_it_goes_on_with() {
    let mut rig = Rig::new();
    let mut told = Vec::new();
    for _ in 0..4 {
        rig.sensed.arrived = true;
        rig.after(100, &[]);
        rig.sensed.energy_j -= 300.0;
        let outputs = rig.after(100_000, &[]);
        told.extend(outputs.messages.into_iter().filter_map(|message| match message {
            Message::TaskEnergy(run) => Some(run),
            _ => None,
        }));
    }
    let all: Vec<f32> = told.iter().map(|run| run.last.get()).collect();
    assert_eq!(all, [300.0; 3], "the first run had begun before anybody looked");
    assert!(told.iter().all(|run| run.mean.get() == 300.0 && run.runs >= 1));

    let task = rig.robot.task();
    rig.sensed.energy_j = ALERT_J;
    let outputs = rig.after(100, &[]);
    let asked = outputs.messages.iter().find_map(|message| match message {
        Message::ChargeRequest(asked) => Some((asked.task, asked.priority)),
        _ => None,
    });
    assert_eq!(asked, Some((Some(task.id()), task.priority())));
}

#[test]
fn a_stranded_robot_asks_anew_when_it_was_charged_or_moved_to_a_pile_and_not_before() {
    for towed in [false, true] {
        let (mut rig, first) = Rig::waiting();
        rig.after(100, &[rig.assignment(first, PILE)]);
        rig.sensed.energy_j = 0.0;
        rig.after(100, &[]);
        assert_eq!(rig.robot.activity(), Activity::Stranded);
        let outputs = if towed {
            (rig.sensed.position, rig.sensed.arrived) = (rig.dock(PILE), true);
            rig.after(100, &[])
        } else {
            (rig.sensed.energy_j, rig.sensed.contacts_live) = (500.0, true);
            assert_eq!(requests(&rig.after(10_000, &[])), [], "it is being charged");
            rig.sensed.contacts_live = false;
            let outputs = rig.after(100, &[]);
            assert_ne!(outputs.route.as_ref().unwrap().back(), Some(&rig.dock(PILE)), "that is another's");
            outputs
        };
        assert_eq!(requests(&outputs), [RequestId(first.0 + 1)]);
        assert_eq!(rig.robot.activity(), Activity::Waiting);
    }
}

/// A mobile charger that stands by where it is, and was sent to a robot.
fn sent_charger() -> (Rig, Message, Outputs) {
    let mut rig = Rig::new();
    let charger = Charger::new(rig.sensed.position, 100.0, 50.0);
    rig.robot = rig.robot.with_charger(charger);
    rig.sensed.energy_j = 9_000.0;
    rig.after(100, &[]);
    let waypoints = [rig.sensed.position.into(), rig.dock(PILE).into()].into_iter().collect();
    let (rescue, robot) = (CommandId(7), RobotId(1));
    let energy = EnergyJ::new(1_000.0).unwrap();
    let sent = Message::Rescue(Rescue { rescue, robot, energy, total: 2, first: 0, waypoints });
    let outputs = rig.after(100, std::slice::from_ref(&sent));
    (rig, sent, outputs)
}

fn phases(outputs: &Outputs) -> Vec<RescuePhase> {
    let said = outputs.messages.iter().filter_map(|message| match message {
        Message::RescueState(state) => Some(state.phase),
        _ => None,
    });
    said.collect()
}

#[test]
fn a_mobile_charger_drives_to_its_robot_gives_what_it_was_told_and_lets_go_when_it_is_told() {
    let (mut rig, sent, outputs) = sent_charger();
    assert_eq!(outputs.route.as_ref().unwrap().back(), Some(&rig.dock(PILE)));
    assert!(outputs.moving && phases(&outputs) == [RescuePhase::Driving]);
    assert_eq!(rig.after(100, std::slice::from_ref(&sent)).route, None, "a repeat");
    (rig.sensed.arrived, rig.sensed.partner) = (true, true);
    assert_eq!(phases(&rig.after(100, &[])), [RescuePhase::Charging]);
    assert!(rig.robot.charger().unwrap().gives());
    rig.after(9_000, &[]);
    assert!(rig.robot.charger().unwrap().gives());
    assert_eq!(phases(&rig.after(1_000, &[])), [RescuePhase::Done]);
    assert!(!rig.robot.charger().unwrap().gives());
    let nack = Nack { of: Reference::Command(CommandId(7)), reason: NackReason::Ended };
    let outputs = rig.after(100, &[Message::Nack(nack)]);
    assert!(outputs.route.is_some() && phases(&outputs).is_empty(), "it comes back");
    assert_eq!(rig.after(100, &[sent]).route, None, "a late repeat");
}

#[test]
fn a_mobile_charger_gives_up_where_its_robot_is_not_and_before_it_strands_itself() {
    for found in [false, true] {
        let (mut rig, ..) = sent_charger();
        (rig.sensed.arrived, rig.sensed.partner) = (true, found);
        rig.after(100, &[]);
        if found {
            rig.sensed.energy_j = 50.0;
        }
        let said: Vec<_> = (0..12).flat_map(|_| phases(&rig.after(1_000, &[]))).collect();
        assert_eq!(said.last(), Some(&RescuePhase::GaveUp), "{said:?}");
    }
}

/// What two piles gossip: 2 and 5 are free.
fn gossip(version: u32) -> Message {
    let rows = [2, 5].map(|pile| PileRow {
        pile: PileId(pile),
        boot: BootEpoch(4),
        version,
        stamp: None,
        availability: Availability::Free,
        remaining: Fraction::MIN,
        planned: DurationMs(0),
    });
    Message::PileTable(PileTable { rows: rows.into_iter().collect() })
}

impl Rig {
    /// Waits for so many seconds while piles gossip, and gives what it claims.
    fn alone_for(&mut self, seconds: u32) -> Vec<ClaimPile> {
        let from = self.now.0 as u32 / 1_000;
        (0..seconds).filter_map(|second| self.after(1_000, &[gossip(from + second)]).claim).collect()
    }
}

#[test]
fn a_robot_that_hears_piles_and_no_coordinator_claims_one_and_drives_there() {
    let (mut rig, request) = Rig::waiting();
    assert_eq!(rig.alone_for(29), []);
    let claims = rig.alone_for(4);
    assert!(claims.len() > 1, "it is repeated: {claims:?}");
    let claim = claims[0];
    assert!(claims.iter().all(|again| again.pile == claim.pile && again.request == request));
    assert_eq!((claim.boot, claim.tag), (BootEpoch(4), BUILD.tag));
    let of = Reference::Claim(ClaimRef { robot: RobotId(1), request });
    let for_another = Reference::Claim(ClaimRef { robot: RobotId(2), request });
    rig.after(100, &[Message::Ack(Ack { of: for_another })]);
    assert_eq!(rig.robot.activity(), Activity::Waiting);
    let outputs = rig.after(100, &[Message::Ack(Ack { of })]);
    assert_eq!(rig.robot.activity(), Activity::Approaching);
    assert_eq!(outputs.route.unwrap().back(), Some(&rig.dock(claim.pile)));
    assert_eq!(rig.alone_for(10), []);
}

#[test]
fn a_robot_that_is_refused_or_not_answered_claims_another_pile() {
    for refused in [true, false] {
        let (mut rig, request) = Rig::waiting();
        rig.alone_for(29);
        let first = rig.alone_for(2)[0].pile;
        if refused {
            let of = Reference::Claim(ClaimRef { robot: RobotId(1), request });
            rig.after(100, &[Message::Nack(Nack { of, reason: NackReason::NotClaimable })]);
        }
        let next = rig.alone_for(8);
        assert_ne!(next.last().unwrap().pile, first, "refused: {refused}");
    }
}

#[test]
fn a_robot_that_hears_the_coordinator_or_old_gossip_claims_nothing() {
    let (mut rig, request) = Rig::waiting();
    for _ in 0..6 {
        assert_eq!(rig.alone_for(10), []);
        let reason = UnassignedReason::AllTaken;
        rig.after(100, &[Message::Unassigned(Unassigned { request, reason })]);
    }
    let (mut rig, _) = Rig::waiting();
    assert!(rig.after(10_000, &[gossip(1)]).claim.is_none());
    for _ in 0..30 {
        assert!(rig.after(1_000, &[gossip(1)]).claim.is_none(), "it is no news");
    }
}
