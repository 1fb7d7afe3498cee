//! Single steps of the core: what a message means, and what follows from it.

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
}

impl Desk {
    fn new() -> Self {
        Self::with_log(Vec::new())
    }

    fn with_log(events: Vec<Event>) -> Self {
        let site = Arc::new(Site::fig7().unwrap());
        let full = EnergyJ::new(10_000.0).unwrap();
        let robots: Vec<_> = (1..=3)
            .map(|id| RobotConfig {
                id: RobotId(id),
                tag: TagId([id as u8; 12]),
                full,
                energy_per_metre_j: 10.0,
            })
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
            planned: DurationMs(0),
        };
        let elapsed = DurationMs(0);
        let state = PileState { row, elapsed, holder, energised: false, ended };
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
        let asked = ChargeRequest { request: RequestId(request), position, energy };
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

    fn ends(&self) -> Vec<LeaseEnd> {
        let ends = self.events.iter().filter_map(|event| match event.fact {
            Fact::Ended { why, .. } => Some(why),
            _ => None,
        });
        ends.collect()
    }

    /// A robot with the lease on the pile where it stands.
    fn granted() -> (Self, LeaseRef) {
        let mut desk = Self::new();
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

#[test]
fn a_repeated_request_does_nothing_new_and_is_answered_again() {
    let (mut desk, _) = Desk::granted();
    desk.robot_is(ROBOT, Activity::Waiting, None);
    let events = desk.events.len();
    for _ in 0..5 {
        desk.now.0 += 1_000;
        desk.sent.clear();
        desk.ask(ROBOT, 1);
        let answers = desk.sent_to_robot(ROBOT);
        assert!(matches!(answers[..], [Message::Assignment(_), ..]), "{answers:?}");
    }
    assert_eq!(desk.events.len(), events);
}

#[test]
fn an_assignment_is_repeated_until_the_robot_says_that_it_follows_it() {
    let (mut desk, _) = Desk::granted();
    desk.sent.clear();
    desk.wait(3_000);
    assert!(desk.sent_to_robot(ROBOT).is_empty(), "it follows it");
    desk.robot_is(ROBOT, Activity::Waiting, None);
    desk.wait(3_000);
    let parts = desk.sent_to_robot(ROBOT).len();
    assert!((3..=4).contains(&parts), "{parts}");
}

#[test]
fn a_grant_is_repeated_every_second_and_taken_back_when_it_is_not_answered() {
    let mut desk = Desk::new();
    desk.pile_says(P, Availability::Free, None);
    desk.ask(ROBOT, 1);
    let (first, lease, _) = desk.last_command(P).unwrap();
    desk.wait(9_900);
    let grants = desk.sent.iter().filter(|(_, message)| matches!(message, Message::Grant(_))).count();
    assert!((9..=11).contains(&grants), "{grants}");
    assert_eq!(desk.last_command(P).unwrap().0, first, "a repeat has the same number");
    desk.wait(300);
    let (_, revoked, is_grant) = desk.last_command(P).unwrap();
    assert!(!is_grant && revoked.lease == lease.lease);
    assert_eq!(desk.place(ROBOT), Some(Place::Waiting));
    // Until the pile answers, or the lease has run out there, nobody else gets the pile.
    desk.pile_says(P, Availability::Free, None);
    desk.ask(RobotId(2), 1);
    assert_eq!(desk.place(RobotId(2)), Some(Place::Waiting));
    desk.ack(P);
    assert_eq!(desk.ends(), [LeaseEnd::Revoked]);
    assert!(matches!(desk.place(RobotId(2)), Some(Place::Granted(P))));
}

#[test]
fn a_pile_that_refuses_is_left_alone_and_the_robot_is_sent_elsewhere() {
    let other = PileId(5);
    let held = LeaseRef { epoch: Epoch(1), lease: LeaseId(0), robot: RobotId(9) };
    for reason in [NackReason::Occupied, NackReason::Faulted, NackReason::Held { by: held }] {
        let mut desk = Desk::new();
        desk.pile_says(P, Availability::Free, None);
        desk.ask(ROBOT, 1);
        desk.pile_says(other, Availability::Free, None);
        desk.nack(P, reason);
        assert_eq!(desk.phase(P), Some(Phase::Refused), "{reason:?}");
        assert_eq!(desk.place(ROBOT), Some(Place::Granted(other)), "{reason:?}");
        desk.wait(16_000);
        assert_eq!(desk.phase(P), None, "no copy of the grant can arrive any more");
    }
}

#[test]
fn a_pile_without_a_clock_is_asked_again_under_the_same_lease() {
    for reason in [NackReason::ClockUnknown, NackReason::TooLate] {
        let mut desk = Desk::new();
        desk.pile_says(P, Availability::Free, None);
        desk.ask(ROBOT, 1);
        let (command, lease, _) = desk.last_command(P).unwrap();
        desk.nack(P, reason);
        desk.wait(1_100);
        let (again, same, is_grant) = desk.last_command(P).unwrap();
        assert!(is_grant && again != command && same == lease, "{reason:?}");
        desk.ack(P);
        assert!(matches!(desk.phase(P), Some(Phase::Held { .. })));
    }
}

#[test]
fn a_coordinator_goes_beyond_every_epoch_it_hears_of() {
    let mut desk = Desk::new();
    assert_eq!(desk.state().epoch, Epoch(1));
    let hello = Hello { min: 1, current: 1, software: [0; 3], epoch: Epoch(7) };
    desk.hear(DeviceId::Pile(P), Message::Hello(hello));
    assert_eq!(desk.state().epoch, Epoch(8));
    desk.pile_says(P, Availability::Free, None);
    desk.ask(ROBOT, 1);
    desk.nack(P, NackReason::StaleEpoch { highest: Epoch(20) });
    assert_eq!(desk.state().epoch, Epoch(21));
    desk.wait(1_100);
    let (_, lease, is_grant) = desk.last_command(P).unwrap();
    assert!(is_grant && lease.epoch == Epoch(21));
}

#[test]
fn after_a_lost_log_no_lease_number_comes_again_and_a_charge_goes_on() {
    let mut desk = Desk::new();
    let old = LeaseRef { epoch: Epoch(1), lease: LeaseId(40), robot: RobotId(3) };
    desk.pile_says(P, Availability::Charging, Some(old));
    desk.robot_is(RobotId(3), Activity::Docked, Some(9));
    desk.wait(1_000);
    let (_, lease, is_grant) = desk.last_command(P).unwrap();
    assert!(is_grant && lease.lease == LeaseId(40) && lease.epoch > Epoch(1), "it is extended: {lease:?}");
    // A mere reservation is taken back, since nobody knows whether its robot comes.
    let other = PileId(5);
    let old = LeaseRef { epoch: Epoch(1), lease: LeaseId(41), robot: RobotId(2) };
    desk.pile_says(other, Availability::Reserved, Some(old));
    assert!(!desk.last_command(other).unwrap().2);
    desk.pile_says(PileId(6), Availability::Free, None);
    desk.ask_from(ROBOT, 1, desk.beside(PileId(6)), 5_000.0);
    assert_eq!(desk.last_command(PileId(6)).unwrap().1.lease, LeaseId(42));
}

#[test]
fn a_robot_that_goes_back_to_work_loses_its_lease_and_its_request() {
    let (mut desk, _) = Desk::granted();
    desk.robot_is(ROBOT, Activity::Working, None);
    assert_eq!(desk.phase(P), Some(Phase::Revoking { why: RevokeReason::Abandoned }));
    assert_eq!(desk.place(ROBOT), None);
    desk.ack(P);
    assert_eq!(desk.ends(), [LeaseEnd::Revoked]);
    assert_eq!(desk.state().totals.charges_completed, 0);
}

#[test]
fn a_robot_that_never_heeds_its_assignment_loses_it() {
    let mut desk = Desk::new();
    desk.pile_says(P, Availability::Free, None);
    desk.robot_is(ROBOT, Activity::Working, None);
    desk.ask(ROBOT, 1);
    desk.ack(P);
    let lease = desk.last_command(P).unwrap().1;
    for _ in 0..32 {
        desk.wait(1_000);
        desk.pile_says(P, Availability::Reserved, Some(lease));
        desk.robot_is(ROBOT, Activity::Working, None);
    }
    assert_eq!(desk.phase(P), Some(Phase::Revoking { why: RevokeReason::Abandoned }));
}

#[test]
fn a_stranded_robot_frees_its_pile_and_keeps_its_place() {
    let (mut desk, _) = Desk::granted();
    desk.robot_is(ROBOT, Activity::Stranded, Some(1));
    assert_eq!(desk.phase(P), Some(Phase::Revoking { why: RevokeReason::Stranded }));
    assert_eq!(desk.place(ROBOT), Some(Place::Waiting));
    assert!(desk.warnings.iter().any(|warning| warning.contains("robot 1 has stranded")));
    desk.ack(P);
    desk.pile_says(P, Availability::Free, None);
    desk.wait(2_000);
    assert_eq!(desk.phase(P), None, "nothing is granted to who can't come");
    desk.robot_is(ROBOT, Activity::Waiting, None);
    desk.wait(1_100);
    assert_eq!(desk.place(ROBOT), Some(Place::Granted(P)));
}

#[test]
fn a_lease_is_extended_while_its_robot_lives_and_runs_out_when_it_is_lost() {
    let (mut desk, lease) = Desk::granted();
    let first_expiry = desk.state().lease(P).unwrap().expiry;
    for _ in 0..60 {
        desk.wait(1_000);
        desk.pile_says(P, Availability::Reserved, Some(lease));
        desk.robot_is(ROBOT, Activity::Approaching, Some(1));
        if desk.state().lease(P).unwrap().command.is_some() {
            desk.ack(P);
        }
    }
    assert!(desk.state().lease(P).unwrap().expiry > first_expiry);
    for _ in 0..59 {
        desk.wait(1_000);
        desk.pile_says(P, Availability::Reserved, Some(lease));
    }
    let ended = EndedLease { lease, reason: EndReason::Expired, charged: DurationMs(0) };
    desk.pile_reports(P, Availability::Free, None, Some(ended), 0.0);
    assert_eq!(desk.ends(), [LeaseEnd::ByPile(EndReason::Expired)]);
    assert_eq!(desk.place(ROBOT), Some(Place::Waiting), "it may turn up again");
}

#[test]
fn a_silent_pile_keeps_its_lease_until_it_must_have_run_out() {
    let (mut desk, _) = Desk::granted();
    let mut lasted = 0;
    while desk.phase(P).is_some() {
        desk.wait(1_000);
        desk.robot_is(ROBOT, Activity::Approaching, Some(1));
        lasted += 1;
        assert!(lasted < 200);
    }
    let lease = desk.events.iter().rev().find_map(|event| match event.fact {
        Fact::Ended { why: LeaseEnd::RanOut, .. } => Some(event.at),
        _ => None,
    });
    let last_expiry = desk.events.iter().filter_map(|event| match event.fact {
        Fact::Granted { expiry, .. } | Fact::Extended { expiry, .. } => Some(expiry),
        _ => None,
    });
    assert!(lease.unwrap() > last_expiry.max().unwrap());
    assert_eq!(desk.place(ROBOT), Some(Place::Waiting));
}

#[test]
fn an_almost_charged_pile_is_promised_to_one_robot_and_given_when_it_is_free() {
    let (mut desk, lease) = Desk::granted();
    desk.pile_reports(P, Availability::Charging, Some(lease), None, 0.05);
    desk.ask(RobotId(2), 1);
    desk.ask(RobotId(3), 1);
    assert_eq!(desk.place(RobotId(2)), Some(Place::Next(P)));
    assert_eq!(desk.place(RobotId(3)), Some(Place::Waiting), "it is promised once");
    assert!(matches!(desk.sent_to_robot(RobotId(2))[..], [.., Message::Assignment(_)]), "it may set off");
    let ended = EndedLease { lease, reason: EndReason::Completed, charged: DurationMs(1) };
    desk.pile_reports(P, Availability::Done, None, Some(ended), 0.0);
    assert_eq!(desk.phase(P), None, "the charged robot still stands there");
    desk.pile_reports(P, Availability::Free, None, Some(ended), 0.0);
    assert_eq!(desk.state().lease(P).unwrap().name.robot, RobotId(2));
    assert_eq!(desk.state().totals.charges_completed, 1);
}

#[test]
fn a_promise_that_cannot_be_kept_is_released() {
    let (mut desk, lease) = Desk::granted();
    desk.pile_reports(P, Availability::Charging, Some(lease), None, 0.05);
    desk.ask(RobotId(2), 1);
    let ended = EndedLease { lease, reason: EndReason::Fault, charged: DurationMs(1) };
    desk.pile_reports(P, Availability::Fault, None, Some(ended), 0.0);
    assert_eq!(desk.place(RobotId(2)), Some(Place::Waiting));
    assert_eq!(desk.place(ROBOT), Some(Place::Waiting), "its charge was cut short");
}

#[test]
fn a_robot_whose_pile_changes_gives_up_the_old_one_first() {
    let (mut desk, lease) = Desk::granted();
    let other = PileId(5);
    desk.pile_says(other, Availability::Free, None);
    let ended = EndedLease { lease, reason: EndReason::Fault, charged: DurationMs(0) };
    desk.sent.clear();
    desk.pile_reports(P, Availability::Fault, None, Some(ended), 0.0);
    desk.ack(other);
    desk.wait(2_000);
    let told = desk.sent_to_robot(ROBOT);
    assert!(told.iter().all(|message| matches!(message, Message::Unassigned(_))) && !told.is_empty());
    desk.sent.clear();
    desk.robot_is(ROBOT, Activity::Waiting, None);
    let told = desk.sent_to_robot(ROBOT);
    assert!(matches!(told[..], [Message::Assignment(part), ..] if part.pile == other), "{told:?}");
}

#[test]
fn a_robot_in_a_wall_or_nowhere_is_told_and_reported_and_waits() {
    let metres = |x, y| Position { x: CoordinateM::new(x).unwrap(), y: CoordinateM::new(y).unwrap() };
    for position in [metres(-1e5, 1e5), metres(50.0, 68.0), metres(0.4, 99_999.0)] {
        let mut desk = Desk::new();
        desk.pile_says(P, Availability::Free, None);
        desk.ask_from(ROBOT, 1, position, 5_000.0);
        assert_eq!(desk.place(ROBOT), Some(Place::Waiting), "{position:?}");
        assert!(desk.warnings.iter().any(|warning| warning.contains("robot 1")), "{:?}", desk.warnings);
        let told = desk.sent_to_robot(ROBOT);
        let answer = Unassigned { request: RequestId(1), reason: UnassignedReason::OutOfReach };
        assert!(told.contains(&&Message::Unassigned(answer)), "{told:?}");
        // Its localisation comes back.
        desk.robot_is(ROBOT, Activity::Waiting, None);
        desk.wait(1_100);
        assert_eq!(desk.place(ROBOT), Some(Place::Granted(P)));
    }
}

#[test]
fn a_robot_with_no_energy_is_out_of_reach_and_one_too_many_finds_all_taken() {
    let mut desk = Desk::new();
    desk.pile_says(PileId(13), Availability::Free, None);
    desk.ask_from(ROBOT, 1, desk.beside(P), 0.0);
    desk.pile_says(PileId(13), Availability::Done, None);
    desk.ask_from(RobotId(2), 1, desk.beside(P), 9_000.0);
    let reason = |robot| {
        let told = desk.sent_to_robot(robot).into_iter().rev();
        let answers = told.filter_map(|message| match message {
            Message::Unassigned(answer) => Some(answer.reason),
            _ => None,
        });
        answers.clone().next()
    };
    // Robot 1 stands on pile 2, which is silent; it reaches that and nothing else.
    assert_eq!(reason(ROBOT), Some(UnassignedReason::AllTaken));
    assert_eq!(reason(RobotId(2)), Some(UnassignedReason::AllTaken));
}

#[test]
fn old_frames_and_frames_of_earlier_starts_are_not_heard() {
    let (mut desk, lease) = Desk::granted();
    let frame = |boot, sequence| {
        let row = PileRow {
            pile: P,
            boot: BootEpoch(boot),
            version: 0,
            stamp: None,
            availability: Availability::Free,
            remaining: Fraction::MIN,
            planned: DurationMs(0),
        };
        let state = PileState { row, elapsed: DurationMs(0), holder: None, energised: false, ended: None };
        let header = Header::new(DeviceId::Pile(P), BootEpoch(boot), Sequence(sequence));
        Input::Frame(Frame { header, message: Message::PileState(state) })
    };
    for old in [frame(1, 1), frame(1, desk.sequence - 1), frame(0, 99)] {
        desk.step(old);
        assert_eq!(desk.state().lease(P).map(|held| held.name), Some(lease));
    }
    desk.step(frame(2, 0));
    assert_eq!(desk.ends(), [LeaseEnd::Lost], "a pile that started anew has no lease");
}

#[test]
fn reports_count_once_however_often_they_come() {
    let mut desk = Desk::new();
    let report = |boot, number, passes| {
        let tag = TagId([1; 12]);
        let count = PassCount { tag, period: 3, passes };
        let stranger = PassCount { tag: TagId([99; 12]), period: 3, passes: 50 };
        let absurd = PassCount { tag, period: 60_000, passes: 50 };
        let passes = [count, stranger, absurd].into_iter().collect();
        Message::PassReport(PassReport { report: ReportId { boot: BootEpoch(boot), number }, passes })
    };
    for (number, passes) in [(1, 4), (1, 4), (2, 1), (1, 4)] {
        desk.sent.clear();
        desk.hear(DeviceId::Pile(P), report(1, number, passes));
        let ack = Message::Ack(Ack { of: Reference::Report(ReportId { boot: BootEpoch(1), number }) });
        assert!(desk.sent.iter().any(|(_, message)| *message == ack), "a repeat is answered again");
    }
    desk.hear(DeviceId::Pile(PileId(5)), report(1, 1, 15));
    assert_eq!(desk.state().pass_frequency(ROBOT, 3, P), 0.25);
    assert_eq!(desk.state().pass_frequency(ROBOT, 4, P), 0.0);
    assert_eq!(desk.state().passes.len(), 1);
    desk.boot = BootEpoch(2);
    desk.hear(DeviceId::Pile(P), report(1, 2, 1));
    assert_eq!(desk.state().pass_frequency(ROBOT, 3, P), 0.25, "an old report after a new start");
    desk.hear(DeviceId::Pile(P), report(2, 1, 10));
    assert_eq!(desk.state().pass_frequency(ROBOT, 3, P), 0.5, "a new start numbers anew");
}

#[test]
fn a_charge_is_noted_once_and_acknowledged_as_often_as_it_is_reported() {
    let mut desk = Desk::new();
    let id = |boot, number| ReportId { boot: BootEpoch(boot), number };
    let report = |report, energy_j| {
        Message::ChargeReport(ChargeReport {
            report,
            lease: LeaseRef { epoch: Epoch(1), lease: LeaseId(4), robot: ROBOT },
            tag: TagId([1; 12]),
            reason: EndReason::Completed,
            began: SiteMillis(1_000),
            ended: Some(SiteMillis(61_000)),
            charged: DurationMs(60_000),
            energy: EnergyJ::new(energy_j).unwrap(),
        })
    };
    for (of, energy_j) in [(id(1, 1), 500.0), (id(1, 1), 500.0), (id(1, 3), 20.0), (id(1, 1), 500.0)] {
        desk.sent.clear();
        desk.hear(DeviceId::Pile(P), report(of, energy_j));
        let ack = Message::Ack(Ack { of: Reference::Report(of) });
        assert!(desk.sent.iter().any(|(_, message)| *message == ack), "a repeat is answered again");
    }
    // After a restart of the pile what it has in its journal comes first, and some of it again.
    desk.boot = BootEpoch(2);
    for (of, energy_j) in [(id(1, 3), 20.0), (id(1, 4), 3.0), (id(2, 1), 1.0)] {
        desk.hear(DeviceId::Pile(P), report(of, energy_j));
    }
    let energies: Vec<f32> = desk.state().charges.iter().map(|charge| charge.energy.get()).collect();
    assert_eq!(energies, [1.0, 3.0, 20.0, 500.0], "newest first");
    assert_eq!(desk.state().totals.energy_j, 524.0);
    // Nor does a restart of the coordinator count one twice.
    let mut desk = Desk::with_log(desk.events);
    desk.boot = BootEpoch(2);
    desk.hear(DeviceId::Pile(P), report(id(2, 1), 1.0));
    assert_eq!(desk.state().charges.len(), 4);
}

#[test]
fn a_restart_keeps_leases_and_extends_them_under_the_new_epoch() {
    let (desk, lease) = Desk::granted();
    let before = *desk.state().lease(P).unwrap();
    let mut desk = Desk::with_log(desk.events);
    let after = desk.state().lease(P).unwrap();
    assert_eq!((after.name, after.phase), (before.name, before.phase));
    desk.pile_says(P, Availability::Reserved, Some(lease));
    desk.robot_is(ROBOT, Activity::Approaching, Some(1));
    let (_, extended, is_grant) = desk.last_command(P).unwrap();
    assert!(is_grant);
    assert_eq!(extended, LeaseRef { epoch: Epoch(lease.epoch.0 + 1), ..lease });
    assert!(!desk.sent.iter().any(|(_, message)| matches!(message, Message::Assignment(_))));
}

#[test]
fn after_a_restart_a_report_that_may_be_older_than_the_lease_does_not_end_it() {
    let (granted, lease) = Desk::granted();
    let restarted = || {
        let mut desk = Desk::with_log(granted.events.clone());
        desk.robot_is(ROBOT, Activity::Approaching, Some(1));
        desk.pile_says(P, Availability::Free, None);
        assert!(matches!(desk.phase(P), Some(Phase::Held { .. })));
        assert_eq!(desk.last_command(P).unwrap().1.lease, lease.lease, "the pile is asked");
        desk
    };
    let mut desk = restarted();
    desk.ack(P);
    assert!(matches!(desk.phase(P), Some(Phase::Held { .. })));
    let mut desk = restarted();
    desk.nack(P, NackReason::Ended);
    assert_ne!(desk.state().lease(P).unwrap().name.lease, lease.lease, "the free pile is granted anew");
}

#[test]
fn a_first_time_and_a_device_of_no_site_are_answered_and_refused() {
    let mut desk = Desk::new();
    let asked = Message::TimeRequest(TimeRequest { asked_at: Millis(55) });
    desk.hear(DeviceId::Pile(P), asked.clone());
    let sync = Message::TimeSync(TimeSync { asked_at: Millis(55), site_now: desk.now });
    assert!(desk.sent.contains(&(DeviceId::Pile(P), sync)));
    desk.sent.clear();
    for stranger in [DeviceId::Pile(PileId(77)), DeviceId::Robot(RobotId(77)), DeviceId::Coordinator] {
        desk.hear(stranger, asked.clone());
    }
    assert!(desk.sent.is_empty());
    assert_eq!(desk.warnings.len(), 3);
}

#[test]
fn a_pile_that_says_farewell_gets_no_robot_and_is_named() {
    let mut desk = Desk::new();
    desk.pile_says(P, Availability::Free, None);
    let state = FaultState { code: FaultCode::MainsLost, active: true, latched: false };
    let faults = [state].into_iter().collect();
    desk.hear(DeviceId::Pile(P), Message::PileFaults(PileFaults { faults }));
    assert!(desk.warnings.iter().any(|warning| warning.contains("pile 2") && warning.contains("mains_lost")));
    desk.ask(ROBOT, 1);
    assert_eq!(desk.place(ROBOT), Some(Place::Waiting));
    desk.pile_says(P, Availability::Free, None);
    desk.wait(1_000);
    assert_eq!(desk.place(ROBOT), Some(Place::Granted(P)));
}
