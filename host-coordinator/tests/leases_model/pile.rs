//! A pile of the model: the firmware's leases, which say by themselves when they are over.

use firmware_pile::lease::{Circumstances, Leases, Place};
use protocol::{
    Ack, Availability, BootEpoch, ClaimPile, DurationMs, EndReason, EnergyJ, Epoch, Fraction, Hello, LeaseId,
    Message, Millis, Nack, PileId, PileRow, PileState, Reference, RequestId, RobotId, SiteMillis, TagId,
};

use crate::world::{START, TICK};

/// How long a charge takes.
pub const PLANNED: DurationMs = DurationMs(2 * TICK.0);

/// What a pile of the model is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Firmware {
    /// What is flashed.
    Real,
    /// A planted defect: commands of every epoch are obeyed.
    IgnoresEpochs,
    /// A planted defect, and what is missing in `insecure`: a frame that was meant for an earlier start of
    /// the pile is believed.
    BelievesFramesForOtherStarts,
}

/// What happens to a pile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Input {
    /// A message from a coordinator arrives; its number.
    Hear(u32),
    /// Time has passed.
    Tick,
    /// A robot claims the pile.
    Claimed(RobotId),
    /// The robot of the lease is on the contacts.
    Arrives,
    /// It leaves them.
    Leaves,
    /// The power goes and comes.
    Restart,
}

/// A pile between two steps.
#[derive(Clone, Debug)]
pub struct Pile {
    pub leases: Leases,
    /// The highest epoch of a command that has changed a lease here, over restarts.
    pub obeyed: Epoch,
    /// Whether a command of a lower epoch has changed a lease after that.
    pub misled: bool,
    /// Leases that it has made for itself, over restarts.
    claims: u32,
    /// Whether a lease has ever taken the place of one that had not ended.
    pub replaced: bool,
}

impl Pile {
    pub fn new() -> Self {
        Self { leases: Leases::new(Epoch(0)), obeyed: Epoch(0), misled: false, claims: 0, replaced: false }
    }

    /// What tells it from others.
    pub fn canonical(&self) -> String {
        format!("{self:?}")
    }

    /// Takes an input at `now` on its own clock, which is `late` behind the site's. Answers with what it says.
    pub fn step(
        &mut self,
        firmware: Firmware,
        (now, late): (SiteMillis, DurationMs),
        input: Input,
        heard: Option<&Message>,
    ) -> Vec<Message> {
        let own = Millis(now.0 - START.0);
        let site_now = SiteMillis(now.0 - u64::from(late.0));
        let told = self.told();
        let held = self.leases.current().map(|lease| lease.name);
        let mut said = Vec::new();
        match input {
            Input::Hear(_) => {
                self.leases.coordinator_heard(own, Some(site_now));
                said.extend(heard.and_then(|message| self.hear(firmware, site_now, message)));
            }
            Input::Tick => {
                if let Some(charge) = self.leases.charge_mut() {
                    charge.advance(TICK);
                }
            }
            // The firmware waits until no coordinator was heard for long. What holds here does not rest on that.
            Input::Claimed(robot) => {
                let id = LeaseId::local(self.claims + 1);
                let claim = ClaimPile {
                    request: RequestId(0),
                    pile: PileId(0),
                    boot: BootEpoch(0),
                    version: 0,
                    tag: TagId([robot.0 as u8; 12]),
                    energy: EnergyJ::MIN,
                    within: DurationMs(3 * TICK.0),
                };
                let place = Place { site_now: Some(site_now), faulted: false, occupied: false };
                if self.leases.claim(id, robot, &claim, PLANNED, place).is_ok()
                    && self.leases.current().is_some_and(|lease| lease.name.lease == id)
                {
                    self.claims += 1;
                }
            }
            Input::Arrives => self.leases.begin_charge(),
            Input::Leaves => self.leases.end(EndReason::RobotLeft),
            Input::Restart => {
                let kept = self.leases.highest_epoch();
                self.leases = Leases::new(kept);
                said.push(Message::Hello(Hello::new(kept)));
            }
        }
        let seen = Circumstances { faulted: false, robot_left: false };
        if let Some(reason) = self.leases.over(own, Some(site_now), seen) {
            self.leases.end(reason);
        }
        if let Some((before, now)) = held.zip(self.leases.current().map(|lease| lease.name)) {
            self.replaced |= (before.lease, before.robot) != (now.lease, now.robot)
                && self.leases.ended().is_none_or(|ended| ended.lease.lease != before.lease);
        }
        if self.told() != told || matches!(input, Input::Tick | Input::Restart) {
            said.push(Message::PileState(self.report()));
        }
        said
    }

    fn hear(&mut self, firmware: Firmware, site_now: SiteMillis, message: &Message) -> Option<Message> {
        let place = Place { site_now: Some(site_now), faulted: false, occupied: false };
        let before = format!("{:?}{:?}", self.leases.current(), self.leases.ended());
        let (epoch, id, answer) = match message {
            Message::Hello(hello) => {
                self.leases.see_epoch(hello.epoch);
                return None;
            }
            Message::Grant(grant) => {
                let mut obeyed = *grant;
                if firmware == Firmware::IgnoresEpochs {
                    obeyed.lease.epoch = obeyed.lease.epoch.max(self.leases.highest_epoch());
                }
                (grant.lease.epoch, grant.head.id, self.leases.grant(&obeyed, PLANNED, place))
            }
            Message::Revoke(revoke) => {
                let mut obeyed = *revoke;
                if firmware == Firmware::IgnoresEpochs {
                    obeyed.lease.epoch = obeyed.lease.epoch.max(self.leases.highest_epoch());
                }
                (revoke.lease.epoch, revoke.head.id, self.leases.revoke(&obeyed, Some(site_now)))
            }
            other => panic!("a coordinator says {other:?} to a pile"),
        };
        if before != format!("{:?}{:?}", self.leases.current(), self.leases.ended()) {
            self.misled |= epoch < self.obeyed;
            self.obeyed = self.obeyed.max(epoch);
        }
        let of = Reference::Command(id);
        Some(match answer {
            Ok(()) => Message::Ack(Ack { of }),
            Err(reason) => Message::Nack(Nack { of, reason }),
        })
    }

    /// Whether its lease is over when it should be: a reservation by its expiry, a charge by its planned time.
    pub fn ends_in_time(&self, site_now: SiteMillis) -> bool {
        self.leases.current().is_none_or(|lease| match lease.charge {
            None => site_now < lease.expiry,
            Some(charge) => charge.elapsed() < charge.planned(),
        })
    }

    fn told(&self) -> (Option<protocol::LeaseRef>, bool, Option<protocol::EndedLease>) {
        let lease = self.leases.current();
        let charging = lease.is_some_and(|lease| lease.charge.is_some());
        (lease.map(|lease| lease.name), charging, self.leases.ended())
    }

    fn report(&self) -> PileState {
        let lease = self.leases.current();
        let charge = lease.and_then(|lease| lease.charge);
        let availability = match (lease, charge) {
            (_, Some(_)) => Availability::Charging,
            (Some(_), None) => Availability::Reserved,
            (None, None) => Availability::Free,
        };
        let row = PileRow {
            // The sender of the frame is what counts.
            pile: PileId(0),
            boot: BootEpoch(0),
            version: 0,
            stamp: None,
            availability,
            remaining: charge.map_or(Fraction::MIN, |charge| charge.remaining()),
            planned: charge.map_or(DurationMs(0), |charge| charge.planned()),
        };
        PileState {
            row,
            elapsed: charge.map_or(DurationMs(0), |charge| charge.elapsed()),
            holder: lease.map(|lease| lease.name),
            energised: charge.is_some(),
            ended: self.leases.ended(),
            standing: None,
            current: None,
        }
    }
}
