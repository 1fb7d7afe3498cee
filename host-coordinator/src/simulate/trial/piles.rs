//! Piles: the real firmware core, a model of its charger, and what its store keeps.

use firmware_pile::{
    ChargingPile, Input, Parameters, TagRead, To,
    plant::{Battery, Plant},
    store::{Kept, Record},
};
use protocol::{
    Ack, Activity, Availability, BootEpoch, DeviceId, DurationMs, FrameError, LeaseId, Message, Millis, Nack,
    PileId, Reference, RobotId, limits,
};

use super::{
    breach::Breach,
    faults::Fault,
    network::{Letter, Node, Opened, Session},
    run::{Occasion, Run},
    watch::{PileWatch, Sight},
};
use crate::simulate::world::rssi_dbm;

/// How often sensors are read while something is at the contacts or flows.
const SENSE: DurationMs = DurationMs(100);
/// How often the reader is asked while somebody is near.
const READ: DurationMs = DurationMs(500);
/// For how long sensors are read on when nobody is at the contacts any more.
const AFTERWARDS: DurationMs = DurationMs(1_500);
/// A tag that comes this near, in metres, may count as passing.
pub(super) const NEAR_M: f64 = 1.6;
/// A tag this far off, in metres, counts as gone.
const GONE_M: f64 = 3.3;
/// How long a pile is without power, in seconds: from, to.
const AWAY_S: (f64, f64) = (1.0, 10.0);

/// A pile.
#[derive(Debug)]
pub(super) struct Pile {
    pub id: PileId,
    power_w: f32,
    pub core: ChargingPile,
    plant: Plant,
    /// What its store holds.
    pub kept: Kept,
    pub session: Session,
    up: bool,
    started: Millis,
    turn: u32,
    read_at: Millis,
    said_at: Millis,
    sense_until: Millis,
    /// Robots that came near and are not known to be gone.
    pub visitors: Vec<usize>,
    /// Robots on its contacts.
    pub docked: Vec<usize>,
    /// Whether its contacts are connected with the power stage.
    pub closed: bool,
    /// Whether its power stage may give power.
    gives: bool,
    /// The power goes when this share of the records of the next step is stored.
    doom: Option<f64>,
    pub watch: PileWatch,
    /// The last lease of its own under which it has charged.
    counted: Option<LeaseId>,
}

impl Pile {
    /// A pile from the factory, not switched on yet.
    pub fn new(id: PileId, power_w: f32) -> Self {
        Self {
            id,
            power_w,
            core: ChargingPile::new(Parameters::new(id, power_w)),
            plant: Plant::new(),
            kept: Kept::default(),
            session: Session::default(),
            up: false,
            started: Millis(0),
            turn: 0,
            read_at: Millis(0),
            said_at: Millis(0),
            sense_until: Millis(0),
            visitors: Vec::new(),
            docked: Vec::new(),
            closed: false,
            gives: false,
            doom: None,
            watch: PileWatch::default(),
            counted: None,
        }
    }

    /// Whether it says that it is free.
    pub fn is_free(&self) -> bool {
        self.up && self.core.availability() == Availability::Free
    }

    /// Whom it holds its place for.
    pub fn holder(&self) -> Option<RobotId> {
        self.core.leases().current().filter(|_| self.up).map(|lease| lease.name.robot)
    }

    /// The time on its own clock.
    const fn local(&self, now: Millis) -> Millis {
        Millis(now.0 - self.started.0)
    }

    /// Keeps a record, as the firmware's store does.
    fn keep(&mut self, record: &Record) {
        let kept = &mut self.kept;
        match record {
            Record::Identity(identity) => kept.identity = Some(*identity),
            Record::Epoch(epoch) => kept.epoch = *epoch,
            Record::Latched(latched) => kept.latched = *latched,
            Record::Counters(counters) => kept.counters = *counters,
            Record::Waiting(slot, report) => {
                if let Some(place) = kept.journal.get_mut(usize::from(*slot)) {
                    *place = Some(report.clone());
                }
            }
            Record::Acknowledged(slot) => {
                if let Some(place) = kept.journal.get_mut(usize::from(*slot)) {
                    *place = None;
                }
            }
        }
    }
}

impl Run<'_> {
    /// The power comes.
    pub fn start_pile(&mut self, index: usize) {
        let pile = &mut self.piles[index];
        if pile.up {
            return;
        }
        pile.kept.boot = BootEpoch(pile.kept.boot.0 + 1);
        let parameters = Parameters {
            boot: pile.kept.boot,
            highest_epoch: pile.kept.epoch,
            latched: pile.kept.latched,
            counters: pile.kept.counters,
            ..Parameters::new(pile.id, pile.power_w)
        };
        pile.core = ChargingPile::resume(parameters, pile.kept.journal.clone());
        pile.session = Session::default();
        pile.started = self.now;
        pile.up = true;
        self.poke(index);
    }

    /// A pile loses its power now, or while it stores what it has to store next.
    pub fn doom_pile(&mut self) {
        let chance = self.troubles.chance(Fault::PileCrash);
        let index = chance.between(0.0, self.piles.len() as f64) as usize;
        let storing = chance.between(0.0, 1.0) < 0.5;
        let share = chance.between(0.0, 1.0);
        if storing {
            self.piles[index].doom = Some(share);
        } else {
            self.crash_pile(index);
        }
    }

    fn crash_pile(&mut self, index: usize) {
        let pile = &mut self.piles[index];
        if !pile.up {
            return;
        }
        pile.up = false;
        pile.gives = false;
        pile.doom = None;
        pile.plant = Plant::new();
        pile.watch.restarted();
        self.contacts_changed(index);
        let chance = self.troubles.chance(Fault::PileCrash);
        let away = DurationMs::from_seconds(chance.between(AWAY_S.0, AWAY_S.1) as f32);
        self.agenda.put(self.now.after(away), Occasion::PileStarts(index));
    }

    /// Something happens at a pile that it may notice by itself.
    pub fn poke(&mut self, index: usize) {
        let pile = &mut self.piles[index];
        // Whoever comes or goes is noticed by the next sample, and by the next read of the reader.
        pile.sense_until = self.now.after(AFTERWARDS);
        pile.read_at = Millis(0);
        self.wake_pile(index, self.now);
    }

    fn wake_pile(&mut self, index: usize, at: Millis) {
        let pile = &mut self.piles[index];
        pile.turn = pile.turn.wrapping_add(1);
        self.agenda.put(at, Occasion::PileWakes { pile: index, turn: pile.turn });
    }

    pub fn pile_wakes(&mut self, index: usize, turn: u32) {
        if self.piles[index].turn != turn || !self.piles[index].up {
            return;
        }
        self.read(index);
        self.sense(index);
        let pile = &self.piles[index];
        if !pile.up {
            return;
        }
        let says = pile.said_at.after(limits::STATE_INTERVAL);
        let next = if pile.sense_until > self.now {
            self.now.after(SENSE)
        } else if pile.visitors.is_empty() {
            says.max(self.now.after(SENSE))
        } else {
            self.now.after(READ)
        };
        self.wake_pile(index, next);
    }

    /// Asks the reader who is near, if it is time.
    fn read(&mut self, index: usize) {
        let now = self.now;
        let pile = &mut self.piles[index];
        if now.since(pile.read_at) < READ && pile.read_at != Millis(0) {
            return;
        }
        pile.read_at = now;
        let (_, _, post) = self.ground.piles[index];
        let mut reads = heapless::Vec::<TagRead, 16>::new();
        let rovers = &mut self.rovers;
        pile.visitors.retain(|&robot| {
            let body = &mut rovers[robot].body;
            body.advance(now);
            let distance_m = body.position().distance_m(post);
            if distance_m <= GONE_M {
                let read = TagRead { tag: body.build().tag, rssi_dbm: rssi_dbm(distance_m) as i8 };
                // More than sixteen do not fit around a pile.
                let _ = reads.push(read);
            }
            distance_m <= GONE_M
        });
        if reads.is_empty() {
            self.step_pile(index, Input::ReaderIdle);
        }
        for read in reads {
            self.step_pile(index, Input::Tag(read));
        }
    }

    /// Reads the sensors, if anything is at the contacts or flows.
    fn sense(&mut self, index: usize) {
        let now = self.now;
        let pile = &mut self.piles[index];
        if !pile.docked.is_empty() || pile.closed || pile.core.energised() {
            pile.sense_until = now.after(AFTERWARDS);
        }
        if pile.sense_until < now || !pile.up {
            return;
        }
        let mut body = pile.docked.first().map(|&robot| &mut self.rovers[robot].body);
        if let Some(body) = &mut body {
            body.advance(now);
        }
        pile.plant.battery =
            body.as_ref().map(|body| Battery::new(body.build().full_j as f32, body.energy_j() as f32));
        let before_j = pile.plant.battery.map(|battery| battery.energy_j);
        let sensors = pile.plant.sense(pile.local(now));
        if let (Some(body), Some(before_j), Some(battery)) = (body, before_j, pile.plant.battery) {
            body.charge(f64::from(battery.energy_j - before_j));
        }
        self.contacts_changed(index);
        self.step_pile(index, Input::Sensors(sensors));
    }

    /// Tells the robots on a pile's contacts if these have become live or dead.
    fn contacts_changed(&mut self, index: usize) {
        let closed = self.piles[index].plant.supply_w().is_some();
        if closed == self.piles[index].closed {
            return;
        }
        let docked = self.piles[index].docked.clone();
        // Up to this instant they were as they were.
        docked.iter().for_each(|&robot| self.step_robot(robot, &[]));
        self.piles[index].closed = closed;
        docked.iter().for_each(|&robot| self.step_robot(robot, &[]));
    }

    pub fn robot_nears(&mut self, robot: usize, pile: usize, route: u32) {
        if self.rovers[robot].route == route {
            let visitors = &mut self.piles[pile].visitors;
            if !visitors.contains(&robot) {
                visitors.push(robot);
            }
            self.poke(pile);
        }
    }

    pub fn pile_hears(&mut self, index: usize, letter: &Letter) {
        let pile = &mut self.piles[index];
        if !pile.up {
            return;
        }
        if letter.from != Node::Office {
            self.step_pile(index, Input::Frame(&letter.frame));
            return;
        }
        match pile.session.open(pile.kept.boot, letter) {
            Opened::Taken => {
                pile.watch.hears(self.now, pile.core.site_now());
                self.step_pile(index, Input::Frame(&letter.frame));
            }
            Opened::Stale => {}
            Opened::Unauthentic => {
                let sender = DeviceId::Coordinator;
                self.step_pile(index, Input::Discarded(FrameError::Unauthentic { sender }));
            }
        }
    }

    /// As a board's task does it: the power first, then the store, then the messages.
    fn step_pile(&mut self, index: usize, input: Input<'_>) {
        let pile = &mut self.piles[index];
        if !pile.up {
            return;
        }
        let outputs = pile.core.step(pile.local(self.now), input);
        pile.plant.command(outputs.power);
        if !outputs.store.is_empty() {
            let doom = pile.doom.take();
            let stored =
                doom.map_or(outputs.store.len(), |share| (share * outputs.store.len() as f64) as usize);
            outputs.store.iter().take(stored).for_each(|record| pile.keep(record));
            if doom.is_some() {
                self.crash_pile(index);
                return;
            }
        }
        for outgoing in outputs.messages.iter().filter(|outgoing| outgoing.to == To::Peers) {
            self.tell_robots(index, &outgoing.message);
        }
        for outgoing in outputs.messages.iter().filter(|outgoing| outgoing.to == To::Coordinator) {
            if matches!(outgoing.message, Message::PileState(_)) {
                self.piles[index].said_at = self.now;
            }
            self.send(Node::Pile(index), Node::Office, outgoing.message.clone());
        }
        self.check_pile(index);
    }

    /// Gossip, for the robots that wait, who alone listen; the answer to a claim.
    fn tell_robots(&mut self, index: usize, message: &Message) {
        let claimant = match message {
            Message::Ack(Ack { of: Reference::Claim(of) })
            | Message::Nack(Nack { of: Reference::Claim(of), .. }) => self.robot_index(of.robot),
            _ => None,
        };
        for robot in 0..self.rovers.len() {
            let listens = self.rovers[robot].activity() == Some(Activity::Waiting);
            if claimant.map_or(listens, |claimant| claimant == robot) {
                self.send_directly(Node::Pile(index), Node::Robot(robot), message.clone());
            }
        }
    }

    fn check_pile(&mut self, index: usize) {
        let connected = self.office.is_up() && self.is_connected(Node::Pile(index));
        let pile = &mut self.piles[index];
        let local = pile.core.leases().current().filter(|lease| lease.name.lease.is_local());
        if let Some(lease) = local.filter(|lease| lease.charge.is_some()).map(|lease| lease.name.lease)
            && pile.counted.replace(lease) != Some(lease)
        {
            self.tally.counts.local_charges += 1;
        }
        let docked = pile.docked.first().map(|&robot| self.rovers[robot].id);
        let booked = if self.office.is_up() { self.office.coordinator.state().lease(pile.id) } else { None };
        let sight = Sight {
            pile: pile.id,
            lease: pile.core.leases().current(),
            ended: pile.core.leases().ended(),
            limit_a: pile.core.power().current_limit_a,
            docked,
            site_now: pile.core.site_now(),
            booked,
            connected,
        };
        let gave = std::mem::replace(&mut pile.gives, sight.limit_a > 0.0);
        let begins = pile.gives && !gave;
        if let Some(breach) = pile.watch.look(self.now, &sight) {
            self.note(breach);
        }
        if begins {
            self.check_power();
        }
    }

    /// All piles that may give power give no more than the facility has.
    fn check_power(&mut self) {
        let giving = self.piles.iter().filter(|pile| pile.gives);
        let drawn_w = giving.map(|pile| f64::from(pile.power_w)).sum();
        if self.ground.power_cap_w.is_some_and(|cap_w| drawn_w > cap_w) {
            self.note(Breach::Overdrawn { drawn_w });
        }
    }
}
