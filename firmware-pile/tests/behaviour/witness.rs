//! A witness of everything that is said to a pile and everything it does, who knows the rules and
//! nothing of how the pile keeps them.

use std::collections::{BTreeMap, BTreeSet};

use firmware_pile::{
    ChargingPile, Contactor, Input, Outputs, Parameters, TagRead, faults::READER_TIMEOUT,
    lease::EXTENSION_GRACE,
};
use protocol::*;

use crate::bench::{SITE_AT_START, tag};

/// What a pile promised about a lease.
struct Promise {
    tag: TagId,
    expiry: SiteMillis,
    planned: Option<DurationMs>,
    /// The contacts were live under it before it ran out.
    begun: bool,
    live: DurationMs,
    heard_past_expiry: Option<Millis>,
    remaining: Fraction,
}

/// A pile under observation.
pub struct Witness {
    pile: ChargingPile,
    parameters: Parameters,
    now: Millis,
    contactor: Contactor,
    commands: Vec<Message>,
    obeyed: BTreeSet<(Epoch, CommandId)>,
    promises: BTreeMap<LeaseId, Promise>,
    over: BTreeSet<LeaseId>,
    holder: Option<LeaseId>,
    highest_epoch: Epoch,
    last_read: BTreeMap<TagId, Millis>,
    last_strong_read: BTreeMap<TagId, Millis>,
    reader_heard: Millis,
    asked_at: Option<Millis>,
    synchronised: bool,
    version: u32,
    /// Steps after which the contacts were live.
    pub live_steps: usize,
    /// Leases that ended because their charge was complete.
    pub completed: usize,
}

impl Witness {
    pub fn new() -> Self {
        let parameters = Parameters { eta: DurationMs(0), ..Parameters::new(PileId(1), 100.0) };
        let mut witness = Self {
            pile: ChargingPile::new(parameters),
            parameters,
            now: Millis(0),
            contactor: Contactor::Open,
            commands: Vec::new(),
            obeyed: BTreeSet::new(),
            promises: BTreeMap::new(),
            over: BTreeSet::new(),
            holder: None,
            highest_epoch: Epoch(0),
            last_read: BTreeMap::new(),
            last_strong_read: BTreeMap::new(),
            reader_heard: Millis(0),
            asked_at: None,
            synchronised: false,
            version: 0,
            live_steps: 0,
            completed: 0,
        };
        witness.step(Input::Tick);
        witness
    }

    /// Time passes unseen.
    pub fn sleep(&mut self, ms: u64) {
        self.pass_to(Millis(self.now.0 + ms));
        self.step(Input::Tick);
    }

    /// The pile's clock shows something earlier for a step.
    pub fn step_back(&mut self, ms: u64) {
        let outputs = self.pile.step(Millis(self.now.0.saturating_sub(ms)), Input::Tick);
        self.judge(&outputs);
    }

    pub fn read(&mut self, robot: u16, rssi_dbm: i8) {
        self.reader_heard = self.now;
        if rssi_dbm >= self.parameters.docked.leave_dbm {
            self.last_read.insert(tag(robot), self.now);
        }
        if rssi_dbm >= self.parameters.docked.enter_dbm {
            self.last_strong_read.insert(tag(robot), self.now);
        }
        self.step(Input::Tag(TagRead { tag: tag(robot), rssi_dbm }));
    }

    pub fn read_nothing(&mut self) {
        self.reader_heard = self.now;
        self.step(Input::ReaderIdle);
    }

    pub fn find_contactor(&mut self, closed: bool) {
        self.step(Input::ContactorFeedback { closed });
    }

    /// The coordinator answers the last question for the time.
    pub fn synchronise(&mut self) {
        if let Some(asked_at) = self.asked_at {
            let half = self.now.since(asked_at).0 / 2;
            let site_now = SiteMillis(self.site_now().0 - u64::from(half));
            self.hear(Message::TimeSync(TimeSync { asked_at, site_now }));
            self.synchronised = true;
        }
    }

    pub fn acknowledge(&mut self, number: u32) {
        self.hear(Message::Ack(Ack { of: Reference::Report(ReportId { boot: BootEpoch(1), number }) }));
    }

    /// A new grant of `charge_ms`, valid for `life_ms`, as a lease that lasts `lease_ms`.
    pub fn grant(&mut self, lease: LeaseRef, charge_ms: u16, life_ms: u16, lease_ms: u16) {
        let head = self.head(life_ms);
        let energy = EnergyJ::clamped(f32::from(charge_ms) / 1_000.0 * self.parameters.power_w);
        let expiry = self.site_now().after(DurationMs(lease_ms.into()));
        self.command(Message::Grant(Grant { head, lease, tag: tag(lease.robot.0), expiry, energy }));
    }

    pub fn revoke(&mut self, lease: LeaseRef, life_ms: u16) {
        let head = self.head(life_ms);
        self.command(Message::Revoke(Revoke { head, lease }));
    }

    /// An old command arrives once more.
    pub fn repeat(&mut self, index: usize) {
        if let Some(command) = self.commands.get(index % self.commands.len().max(1)).cloned() {
            self.hear(command);
        }
    }

    fn site_now(&self) -> SiteMillis {
        SiteMillis(SITE_AT_START + self.now.0)
    }

    fn head(&self, life_ms: u16) -> CommandHead {
        let id = CommandId(u32::try_from(self.commands.len()).unwrap());
        CommandHead { id, valid_until: self.site_now().after(DurationMs(life_ms.into())) }
    }

    fn command(&mut self, command: Message) {
        self.commands.push(command.clone());
        self.hear(command);
    }

    fn hear(&mut self, message: Message) {
        let site_now = self.site_now();
        if self.synchronised
            && let Some(promise) = self.holder.and_then(|holder| self.promises.get_mut(&holder))
            && site_now >= promise.expiry
        {
            promise.heard_past_expiry.get_or_insert(self.now);
        }
        let header = Header::new(DeviceId::Coordinator, BootEpoch(1), Sequence(0));
        let outputs = self.pile.step(self.now, Input::Frame(&Frame { header, message: message.clone() }));
        let obeyed = |head: CommandHead| {
            let ack = Message::Ack(Ack { of: Reference::Command(head.id) });
            outputs.messages.iter().any(|sent| sent.message == ack)
        };
        match message {
            Message::Grant(grant) if obeyed(grant.head) => self.promise(&grant),
            Message::Revoke(revoke) if obeyed(revoke.head) => {
                self.over.insert(revoke.lease.lease);
            }
            _ => {}
        }
        self.judge(&outputs);
    }

    /// The pile has acknowledged `grant`.
    fn promise(&mut self, grant: &Grant) {
        if !self.obeyed.insert((grant.lease.epoch, grant.head.id)) {
            return;
        }
        assert!(grant.lease.epoch >= self.highest_epoch, "a stale epoch was obeyed");
        assert!(self.site_now() <= grant.head.valid_until, "a late command was obeyed");
        assert!(self.synchronised, "a lease was taken without a clock");
        assert!(!self.over.contains(&grant.lease.lease), "a lease that was over was taken again");
        let promise = self.promises.entry(grant.lease.lease).or_insert(Promise {
            tag: grant.tag,
            expiry: grant.expiry,
            planned: None,
            begun: false,
            live: DurationMs(0),
            heard_past_expiry: None,
            remaining: Fraction::MAX,
        });
        assert_eq!(promise.tag, grant.tag, "a lease went from one robot to another");
        promise.expiry = promise.expiry.max(grant.expiry);
        promise.heard_past_expiry = None;
    }

    fn step(&mut self, input: Input<'_>) {
        let outputs = self.pile.step(self.now, input);
        self.judge(&outputs);
    }

    fn pass_to(&mut self, now: Millis) {
        if self.contactor == Contactor::Closed
            && let Some(promise) = self.holder.and_then(|holder| self.promises.get_mut(&holder))
        {
            promise.live.0 += now.since(self.now).0;
        }
        self.now = now;
    }

    fn judge(&mut self, outputs: &Outputs) {
        assert!(outputs.messages.len() < outputs.messages.capacity(), "a message may not have fitted");
        if let Some(epoch) = outputs.store_epoch {
            assert!(epoch > self.highest_epoch);
            self.highest_epoch = epoch;
        }
        for outgoing in &outputs.messages {
            match &outgoing.message {
                Message::TimeRequest(request) => self.asked_at = Some(request.asked_at),
                Message::PileState(state) => self.judge_state(state),
                _ => {}
            }
        }
        let holder = self.pile.leases().current().map(|lease| lease.name.lease);
        self.judge_holder(holder);
        self.contactor = outputs.contactor;
        assert_eq!(self.pile.energised(), outputs.contactor == Contactor::Closed);
        if outputs.contactor == Contactor::Closed {
            self.judge_live();
        }
    }

    /// There is one lease at a time, and one that is over does not come back.
    fn judge_holder(&mut self, holder: Option<LeaseId>) {
        if let Some(before) = self.holder.filter(|&before| holder != Some(before)) {
            self.over.insert(before);
            let ended = self.pile.leases().ended().expect("a lease that is gone has ended");
            assert_eq!(ended.lease.lease, before);
            assert_eq!(
                ended.charged, self.promises[&before].live,
                "charged is the time for which contacts were live"
            );
            self.completed += usize::from(ended.reason == EndReason::Completed);
        }
        if let Some(holder) = holder {
            assert!(self.promises.contains_key(&holder), "lease {holder} was never acknowledged");
            assert!(!self.over.contains(&holder), "lease {holder} is over");
        }
        self.holder = holder;
    }

    fn judge_live(&mut self) {
        self.live_steps += 1;
        let holder = self.holder.expect("live contacts need a lease");
        let site_now = self.site_now();
        let promise = self.promises.get_mut(&holder).unwrap();
        let last_read = self.last_read.get(&promise.tag).expect("the lease's tag was never read");
        assert!(self.now.since(*last_read) < self.parameters.tag_timeout, "the tag was not read lately");
        assert!(self.now.since(self.reader_heard) < READER_TIMEOUT, "the reader is silent");
        assert_ne!(self.pile.availability(), Availability::Fault);
        if !promise.begun {
            let lately = |read: &Millis| self.now.since(*read) < self.parameters.tag_timeout;
            let strangers =
                self.last_strong_read.iter().filter(|(tag, read)| **tag != promise.tag && lately(read));
            assert_eq!(strangers.count(), 0, "a charge began though another robot stood at the contacts");
        }
        if site_now < promise.expiry {
            promise.begun = true;
        } else {
            assert!(promise.begun, "a charge began under a lease that had run out");
            let heard = promise.heard_past_expiry.map_or(DurationMs(0), |heard| self.now.since(heard));
            assert!(heard < EXTENSION_GRACE, "the coordinator has not extended the lease");
        }
    }

    fn judge_state(&mut self, state: &PileState) {
        assert!(state.row.version > self.version);
        self.version = state.row.version;
        assert!((0.0..=1.0).contains(&state.row.remaining.get()));
        let Some(holder) = state.holder.filter(|_| state.row.availability == Availability::Charging) else {
            assert_eq!(state.row.remaining, Fraction::MIN);
            assert!(!state.energised);
            return;
        };
        let promise = self.promises.get_mut(&holder.lease).expect("a lease that was acknowledged");
        assert_eq!(*promise.planned.get_or_insert(state.row.planned), state.row.planned);
        assert!(state.row.remaining <= promise.remaining, "the charge went backwards");
        promise.remaining = state.row.remaining;
        assert_eq!(state.elapsed, promise.live);
    }
}
