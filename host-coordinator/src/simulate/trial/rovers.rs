//! Robots: a computer each, and a body that is not quite as everybody believes.

use std::sync::Arc;

use protocol::{Activity, BootEpoch, DeviceId, DurationMs, Message, Millis, RequestId, RobotId, SiteMillis};

use super::{
    CHARGER, Ground, MODEL,
    body::Body,
    breach::Breach,
    faults::Fault,
    help,
    network::{Letter, Node, Opened, Session},
    piles::NEAR_M,
    run::{Occasion, Run},
};
use crate::simulate::{
    charger::Charger,
    fleet,
    ground::{KEEP_CLEAR_M, Point},
    navigator::Navigator,
    random::Random,
    robot::Robot,
    world::{Build, CONTACT_M, SIGHT_M, Sensed},
};

/// What a robot really consumes, as a share of what everybody believes: from, to.
const TRUTH: (f64, f64) = (0.7, 1.3);
/// How long a robot's computer is away, in seconds: from, to.
const AWAY_S: (f64, f64) = (2.0, 20.0);
/// A way this close to a door's middle, in metres, leads through it.
const DOORWAY_M: f64 = 1.5;
/// How long a robot stands at the most crowded door at the worst time of day, in milliseconds.
const CROWDED_MS: f64 = 20_000.0;
/// Standing closer than this to the end of another robot's way, in metres, is in its way.
const IN_THE_WAY_M: f64 = 1.0;
/// How long a robot that was heard may be missing from the book of a coordinator that it can reach.
pub(super) const MISSING: DurationMs = DurationMs(30_000);

/// A robot.
#[derive(Debug)]
pub(super) struct Rover {
    pub id: RobotId,
    pub core: Option<Robot>,
    pub body: Body,
    pub boot: BootEpoch,
    pub session: Session,
    turn: u32,
    /// Which of its routes this is.
    pub route: u32,
    at_pile: Option<usize>,
    /// Where it was when it was last looked for on contacts.
    looked: Option<(Point, bool)>,
    stepped_at: Millis,
    driven_m: f64,
    /// The charge that it asked for, or was called to, and has not got yet.
    needs: Option<Need>,
    stranded: bool,
    /// Since when it has stranded, and neither was helped nor were people called.
    pub helpless_since: Option<Millis>,
    /// Since when the coordinator could know that, and does not.
    pub unbooked_since: Option<Millis>,
    /// Where it stands by, of a mobile charger.
    home: Option<Point>,
    /// Whom it charges, as a mobile charger.
    pub gives_to: Option<usize>,
    /// Its last request that the coordinator has taken.
    pub heard: Option<(BootEpoch, RequestId)>,
    missing_since: Option<Millis>,
    /// Since when two piles hold to it.
    pub two_since: Option<Millis>,
}

/// A charge that a robot needs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Need {
    /// Whether a pile was within its true reach when it asked, or was called.
    reachable: bool,
    /// When it left its work for it.
    left_work: Option<Millis>,
}

impl Rover {
    /// The robot of this number, not switched on yet; after so many robots come mobile chargers.
    pub fn new(ground: &Ground, seed: u64, index: usize, robots: usize) -> Self {
        let charger = index.checked_sub(robots);
        let number = charger.map_or(index, |charger| usize::from(ground.robots) + charger) + 1;
        let id = RobotId(u16::try_from(number).unwrap_or(u16::MAX));
        let mut random = Random::new(seed, id.0.into());
        let believed = if charger.is_some() { CHARGER.build(id) } else { MODEL.build(id) };
        let truth = random.between(TRUTH.0, TRUTH.1);
        let build = Build {
            idle_w: believed.idle_w * truth,
            drive_j_per_m: believed.drive_j_per_m * truth,
            ..believed
        };
        let share = random.between(fleet::INITIAL_CHARGE.0, fleet::INITIAL_CHARGE.1);
        let energy_j = build.full_j * if charger.is_some() { 1.0 } else { share };
        let position = random.choose(ground.terrain.places()).copied();
        let position = position.unwrap_or(Point { x_m: 0.0, y_m: 0.0 });
        Self {
            id,
            core: None,
            body: Body::new(build, position, energy_j),
            boot: BootEpoch(0),
            session: Session::default(),
            turn: 0,
            route: 0,
            at_pile: None,
            looked: None,
            stepped_at: Millis(0),
            driven_m: 0.0,
            needs: None,
            stranded: false,
            helpless_since: None,
            unbooked_since: None,
            home: charger.map(|_| position),
            gives_to: None,
            heard: None,
            missing_since: None,
            two_since: None,
        }
    }

    pub fn activity(&self) -> Option<Activity> {
        Some(self.core.as_ref()?.activity())
    }
}

impl Run<'_> {
    /// The computer starts.
    pub fn start_robot(&mut self, index: usize) {
        let rover = &mut self.rovers[index];
        if rover.core.is_some() {
            return;
        }
        rover.boot.0 += 1;
        let stream = u64::from(rover.id.0) + (u64::from(rover.boot.0) << 32);
        let random = Random::new(self.trial.seed, stream);
        let navigator = Navigator::new(Arc::clone(&self.ground.terrain), random);
        rover.core = Some(match rover.home {
            Some(home) => help::charger(rover.id, navigator, home),
            None => Robot::new(rover.id, MODEL.build(rover.id), navigator, self.ground.alert_j),
        });
        rover.session = Session::default();
        rover.stepped_at = self.now;
        self.step_robot(index, &[]);
    }

    /// A robot's computer fails; its body stands where it is.
    pub fn crash_robot(&mut self) {
        let chance = self.troubles.chance(Fault::RobotCrash);
        let index = chance.between(0.0, self.rovers.len() as f64) as usize;
        let away = DurationMs::from_seconds(chance.between(AWAY_S.0, AWAY_S.1) as f32);
        if self.rovers[index].core.is_none() {
            return;
        }
        self.sum_up(index);
        let rover = &mut self.rovers[index];
        rover.core = None;
        rover.gives_to = None;
        rover.heard = None;
        rover.missing_since = None;
        rover.body.stop();
        rover.body.command(false, 0.0);
        rover.route = rover.route.wrapping_add(1);
        self.find_on_contacts(index);
        self.agenda.put(self.now.after(away), Occasion::RobotStarts(index));
    }

    pub fn robot_wakes(&mut self, index: usize, turn: u32) {
        if self.rovers[index].turn == turn {
            self.step_robot(index, &[]);
        }
    }

    pub fn robot_hears(&mut self, index: usize, letter: Letter) {
        let rover = &mut self.rovers[index];
        let Some(core) = &mut rover.core else { return };
        if letter.from != Node::Office {
            self.step_robot(index, &[letter.frame.message]);
            return;
        }
        match rover.session.open(rover.boot, &letter) {
            Opened::Taken => self.step_robot(index, &[letter.frame.message]),
            Opened::Stale => {}
            Opened::Unauthentic => {
                core.distrusted();
                self.step_robot(index, &[]);
            }
        }
    }

    /// Lets a robot's computer sense, hear, decide and speak.
    pub fn step_robot(&mut self, index: usize, heard: &[Message]) {
        self.sum_up(index);
        self.find_on_contacts(index);
        let end_clear = self.sees_its_end_clear(index);
        let partner = self.partner_of(index);
        let rover = &self.rovers[index];
        let at_live_pile = rover.at_pile.is_some_and(|pile| self.piles[pile].closed);
        let contacts_live = at_live_pile || self.is_given_energy(index);
        let rover = &mut self.rovers[index];
        let sensed = Sensed {
            position: rover.body.position(),
            energy_j: rover.body.energy_j(),
            arrived: rover.body.has_arrived(),
            end_clear,
            contacts_live,
            partner: partner.is_some(),
        };
        let Some(core) = &mut rover.core else { return };
        let outputs = core.step(self.now, &sensed, heard);
        let work_w = if core.is_at_work() { core.task().power_w() } else { 0.0 };
        if let Some(route) = &outputs.route {
            let (doors, hour) = (&self.ground.doors, rush(self.site_now()));
            let rover = &mut self.rovers[index];
            rover.body.take_route(route, |from, to| pause_ms(doors, hour, from, to));
            rover.route = rover.route.wrapping_add(1);
            self.foresee(index);
        }
        let rover = &mut self.rovers[index];
        rover.body.command(outputs.moving, work_w);
        let gives = rover.core.as_ref().and_then(Robot::charger).is_some_and(Charger::gives);
        rover.gives_to = partner.filter(|_| gives);
        self.find_on_contacts(index);
        self.note_need(index, contacts_live);
        self.check_helped(index);
        for message in outputs.messages {
            self.send(Node::Robot(index), Node::Office, message);
        }
        if let Some(claim) = outputs.claim
            && let Some(Node::Pile(pile)) = self.node(DeviceId::Pile(claim.pile))
        {
            self.send_directly(Node::Robot(index), Node::Pile(pile), Message::ClaimPile(claim));
        }
        self.check_booked(index);
        self.plan_robot(index);
    }

    /// Puts down when the robot's computer has something to do next.
    fn plan_robot(&mut self, index: usize) {
        let rover = &mut self.rovers[index];
        let Some(core) = &rover.core else { return };
        let short_m = match core.activity() {
            Activity::Approaching => KEEP_CLEAR_M,
            _ => 0.0,
        };
        let body = &rover.body;
        let arrives = [0.0, short_m].into_iter().filter_map(|short_m| body.time_to_end_ms(short_m));
        let soon = arrives.filter(|ms| *ms > 0).min().map(|ms| Millis(self.now.0 + ms));
        let own = core.wakes_at().max(Millis(self.now.0 + 1));
        let at = soon.map_or(own, |soon| soon.min(own));
        rover.turn = rover.turn.wrapping_add(1);
        self.agenda.put(at, Occasion::RobotWakes { robot: index, turn: rover.turn });
    }

    /// Puts down when a robot with a new route comes near piles.
    fn foresee(&mut self, index: usize) {
        let rover = &self.rovers[index];
        for (pile, &(_, _, post)) in self.ground.piles.iter().enumerate() {
            if let Some(ms) = rover.body.time_to_disc_ms(post, NEAR_M) {
                let at = Millis(self.now.0 + ms);
                self.agenda.put(at, Occasion::Nears { robot: index, pile, route: rover.route });
            }
        }
    }

    /// Moves the body on, and counts what it did.
    pub fn sum_up(&mut self, index: usize) {
        let rover = &mut self.rovers[index];
        rover.body.advance(self.now);
        let passed = self.now.since(rover.stepped_at);
        rover.stepped_at = self.now;
        self.give_energy(index, passed);
        let rover = &mut self.rovers[index];
        let driven_m = rover.body.driven_m() - rover.driven_m;
        rover.driven_m = rover.body.driven_m();
        match rover.activity() {
            _ if rover.home.is_some() => {}
            Some(Activity::Working) => self.tally.worked_ms += u64::from(passed.0),
            Some(Activity::Approaching) => self.tally.counts.charge_distance_m += driven_m,
            _ => {}
        }
    }

    /// Notices when a robot has come to stand on contacts, or has left them.
    fn find_on_contacts(&mut self, index: usize) {
        let rover = &mut self.rovers[index];
        let look = (rover.body.position(), rover.body.stands());
        if rover.looked.replace(look) == Some(look) {
            return;
        }
        let touches = |&(_, _, post): &(_, _, Point)| look.0.is_within(CONTACT_M, post);
        let at_pile = self.ground.piles.iter().position(touches).filter(|_| look.1);
        let before = std::mem::replace(&mut rover.at_pile, at_pile);
        if before == at_pile {
            return;
        }
        if let Some(pile) = before {
            self.piles[pile].docked.retain(|robot| *robot != index);
            self.poke(pile);
        }
        if let Some(pile) = at_pile {
            self.piles[pile].docked.push(index);
            self.robot_nears(index, pile, self.rovers[index].route);
        }
    }

    /// Whether a robot on its way to a pile sees nobody at the end of it.
    fn sees_its_end_clear(&mut self, index: usize) -> bool {
        let rover = &self.rovers[index];
        let (position, end) = (rover.body.position(), rover.body.end());
        if rover.activity() != Some(Activity::Approaching) || !position.is_within(SIGHT_M, end) {
            return true;
        }
        let Some(pile) = self.ground.piles.iter().position(|(.., post)| post.is_within(CONTACT_M, end))
        else {
            return true;
        };
        self.piles[pile].visitors.iter().all(|&other| {
            let body = &mut self.rovers[other].body;
            body.advance(self.now);
            other == index || !body.position().is_within(IN_THE_WAY_M, end)
        })
    }

    /// A robot asks for a charge, or is called to one, unless it needs one already.
    pub fn needs(&mut self, index: usize) -> &mut Need {
        let rover = &mut self.rovers[index];
        rover.needs.get_or_insert_with(|| {
            self.tally.counts.requests += 1;
            let nearest_m = self.ground.terrain.nearest_pile_m(rover.body.position());
            let needed_j = nearest_m.map(|nearest_m| nearest_m * rover.body.per_metre_j());
            let reachable = needed_j.is_some_and(|needed_j| needed_j <= rover.body.energy_j());
            Need { reachable, left_work: None }
        })
    }

    /// Notes when a robot begins to need a charge, gets one, or strands.
    fn note_need(&mut self, index: usize, contacts_live: bool) {
        let now = self.now;
        let rover = &mut self.rovers[index];
        let activity = rover.activity();
        if activity == Some(Activity::Waiting) {
            rover.stranded = false;
        }
        let stands_by = rover.home.is_some();
        if matches!(activity, Some(Activity::Waiting | Activity::Approaching)) && !stands_by {
            self.needs(index).left_work.get_or_insert(now);
        }
        let rover = &mut self.rovers[index];
        match activity {
            Some(Activity::Docked | Activity::Charging) if contacts_live => {
                if let Some(left_work) = rover.needs.take().and_then(|need| need.left_work) {
                    self.tally.waits_ms.push(now.since(left_work).0);
                }
            }
            Some(Activity::Stranded) if !rover.stranded => {
                rover.stranded = true;
                // Its wait ends here; when it was helped it asks anew.
                if rover.needs.take().is_some_and(|need| need.reachable) {
                    self.tally.counts.stranded_reachable += 1;
                } else {
                    self.tally.counts.stranded_unreachable += 1;
                }
            }
            _ => {}
        }
    }

    /// A robot that waits and was heard is in the book.
    pub fn check_booked(&mut self, index: usize) {
        let rover = &self.rovers[index];
        let asks = rover.core.as_ref().filter(|core| core.activity() == Activity::Waiting);
        let asked = asks.map(|core| (rover.boot, core.request()));
        let is_missing = asked.is_some()
            && asked == rover.heard
            && self.office.is_up()
            && self.is_connected(Node::Robot(index))
            && !self.is_booked(rover.id);
        let rover = &mut self.rovers[index];
        if !is_missing {
            rover.missing_since = None;
        } else if self.now.since(*rover.missing_since.get_or_insert(self.now)) > MISSING {
            let robot = rover.id;
            self.note(Breach::Forgotten { robot });
        }
    }

    /// At the end of the run: what robots still wait for counts too.
    pub fn count_open_waits(&mut self) {
        let now = self.now;
        let left = self.rovers.iter().filter_map(|rover| rover.needs?.left_work);
        self.tally.waits_ms.extend(left.map(|left_work| now.since(left_work).0));
    }
}

/// How crowded doors are at a time of day, 0 to 1: people come in the morning and leave in the
/// afternoon.
fn rush(now: SiteMillis) -> f64 {
    let hour = (now.0 % 86_400_000) as f64 / 3_600_000.0;
    let peak = |at: f64| (1.0 - (hour - at).abs() / 3.0).max(0.0);
    0.2 + 0.8 * peak(9.0).max(peak(17.0))
}

/// How long a robot stands on a straight part of its way, because doors on it are crowded.
fn pause_ms(doors: &[(Point, f64)], rush: f64, from: Point, to: Point) -> f64 {
    let (dx, dy) = (to.x_m - from.x_m, to.y_m - from.y_m);
    let square = dx * dx + dy * dy;
    let passes = |door: &Point| {
        let share = ((door.x_m - from.x_m) * dx + (door.y_m - from.y_m) * dy) / square;
        // The end belongs to the next part.
        (0.0..1.0).contains(&share) && {
            let foot = Point { x_m: from.x_m + share * dx, y_m: from.y_m + share * dy };
            foot.distance_m(*door) < DOORWAY_M
        }
    };
    doors.iter().filter(|(door, _)| passes(door)).map(|(_, rho)| rho * rush * CROWDED_MS).sum()
}
