//! A witness of everything that is said to a pile and everything it does, who knows the rules and
//! nothing of how the pile keeps them.

use std::collections::{BTreeMap, BTreeSet};

use firmware_pile::{
    ChargingPile, Input, Outputs, Parameters, Power, Sensors, TagRead,
    faults::READER_TIMEOUT,
    lease::EXTENSION_GRACE,
    plant::{Battery, Plant, Says},
    store::Record,
};
use protocol::*;

use crate::bench::{SITE_AT_START, tag};

/// What a pile promised about a lease.
struct Promise {
    tag: TagId,
    expiry: SiteMillis,
    planned: Option<DurationMs>,
    /// Its charge began before it ran out.
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
    /// What the pile's board is connected to.
    pub plant: Plant,
    sensed: Option<(Millis, Sensors)>,
    power: Power,
    /// Since when something forbids live contacts that are live.
    forbidden_since: Option<Millis>,
    commands: Vec<Message>,
    obeyed: BTreeSet<(Epoch, CommandId)>,
    promises: BTreeMap<LeaseId, Promise>,
    over: BTreeSet<LeaseId>,
    holder: Option<LeaseId>,
    highest_epoch: Epoch,
    stored_latched: BTreeSet<FaultCode>,
    last_read: BTreeMap<TagId, Millis>,
    last_strong_read: BTreeMap<TagId, Millis>,
    reader_heard: Millis,
    asked_at: Option<Millis>,
    synchronised: bool,
    version: u32,
    /// How long each sensor has said the same, contactor and command have disagreed, and current has
    /// strayed: since when.
    same_since: [(u32, Millis); 3],
    disagrees_since: Option<Millis>,
    strays_since: Option<Millis>,
    /// Latched faults that were caused and not cleared since.
    uncleared: BTreeSet<FaultCode>,
    /// Faults that were caused.
    caused: BTreeSet<FaultCode>,
    /// Whether the last report of a fault said that it stands.
    told: BTreeMap<FaultCode, bool>,
    outstanding: Option<ReportId>,
    clearings: u32,
    /// Steps of the pile so far.
    pub steps: usize,
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
            plant: Plant::new(),
            sensed: None,
            power: Power::OFF,
            forbidden_since: None,
            commands: Vec::new(),
            obeyed: BTreeSet::new(),
            promises: BTreeMap::new(),
            over: BTreeSet::new(),
            holder: None,
            highest_epoch: Epoch(0),
            stored_latched: BTreeSet::new(),
            last_read: BTreeMap::new(),
            last_strong_read: BTreeMap::new(),
            reader_heard: Millis(0),
            asked_at: None,
            synchronised: false,
            version: 0,
            same_since: [(u32::MAX, Millis(0)); 3],
            disagrees_since: None,
            strays_since: None,
            uncleared: BTreeSet::new(),
            caused: BTreeSet::new(),
            told: BTreeMap::new(),
            outstanding: None,
            clearings: 0,
            steps: 0,
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

    /// The sensors are read for so long, every 10 ms.
    pub fn sense(&mut self, ms: u32) {
        for _ in 0..ms / 10 {
            self.pass_to(self.now.after(DurationMs(10)));
            let sensors = self.plant.sense(self.now);
            self.sensed = Some((self.now, sensors));
            let causes = self.causes(&sensors);
            self.step(Input::Sensors(sensors));
            self.judge_faults(&causes);
        }
    }

    /// Whatever was broken is sound again.
    pub fn mend(&mut self) {
        let plant = &mut self.plant;
        (plant.mains, plant.emergency_stop, plant.welded, plant.jammed) = (true, false, false, false);
        (plant.runaway_a, plant.leak_a) = (None, 0.0);
        (plant.voltage, plant.current, plant.temperature) = (Says::Truth, Says::Truth, Says::Truth);
        if let Some(battery) = &mut plant.battery {
            battery.reversed = false;
        }
    }

    /// Coordinator or tool clears a fault.
    pub fn clear(&mut self, code: FaultCode, service: bool) {
        self.clearings += 1;
        // Numbers that no other command has.
        let command = CommandId(1_000_000 + self.clearings);
        let sender = if service { DeviceId::Service } else { DeviceId::Coordinator };
        let header = Header::new(sender, BootEpoch(1), Sequence(0));
        let message = Message::ClearFault(ClearFault { command, code });
        let outputs = self.pile.step(self.now, Input::Frame(&Frame { header, message }));
        let done = Message::Ack(Ack { of: Reference::Command(command) });
        // Without mains it answers nothing.
        let is_silent = self.pile.faults().active().contains(FaultCode::MainsLost);
        if is_silent || outputs.messages.iter().any(|sent| sent.message == done) {
            self.uncleared.remove(&code);
        }
        if !service {
            self.coordinator_heard();
        }
        self.judge(&outputs);
    }

    /// At the end, with mains to speak by and somebody who listens: what was caused was told, and what
    /// was told last is true.
    pub fn conclude(&mut self) {
        self.plant.mains = true;
        for _ in 0..80 {
            self.sense(100);
            if let Some(report) = self.outstanding {
                self.hear(Message::Ack(Ack { of: Reference::Report(report) }));
            }
        }
        let untold: Vec<_> = self.caused.iter().filter(|code| !self.told.contains_key(code)).collect();
        assert!(untold.is_empty(), "nobody was told of {untold:?}");
        let stand: BTreeSet<_> = self.pile.faults().standing().iter().collect();
        let told: BTreeSet<_> =
            self.told.iter().filter(|(_, stands)| **stands).map(|(code, _)| *code).collect();
        assert_eq!(told, stand, "what was told last is not so");
    }

    /// The faults it was told of.
    pub fn reported(&self) -> impl Iterator<Item = FaultCode> {
        self.told.keys().copied()
    }

    /// A robot comes to the contacts, or leaves them.
    pub fn touch(&mut self, touches: bool) {
        self.plant.battery = touches.then_some(Battery::new(1.0e6, 0.5e6));
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

    fn coordinator_heard(&mut self) {
        let site_now = self.site_now();
        if self.synchronised
            && let Some(promise) = self.holder.and_then(|holder| self.promises.get_mut(&holder))
            && site_now >= promise.expiry
        {
            promise.heard_past_expiry.get_or_insert(self.now);
        }
    }

    fn hear(&mut self, message: Message) {
        self.coordinator_heard();
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
        if self.power.is_closed()
            && let Some(promise) = self.holder.and_then(|holder| self.promises.get_mut(&holder))
            && promise.begun
        {
            promise.live.0 += now.since(self.now).0;
        }
        self.now = now;
    }

    /// What a sample says is wrong with a pile of 100 W for 24 V batteries, told what it was told.
    fn causes(&mut self, sensors: &Sensors) -> BTreeSet<FaultCode> {
        let Sensors { output_v, output_a, contact_c, contactor_closed, .. } = *sensors;
        for (value, (bits, since)) in [output_v, output_a, contact_c].iter().zip(&mut self.same_since) {
            if *bits != value.to_bits() {
                (*bits, *since) = (value.to_bits(), self.now);
            }
        }
        let [voltage, current, temperature] =
            self.same_since.map(|(_, since)| self.now.since(since) >= DurationMs(2_000));
        let is_voltage = output_v.abs() < 60.0 && !voltage;
        let is_current = output_a.abs() < 10.0 && !current;
        let told_closed = self.power.is_closed();
        let disagrees = contactor_closed != told_closed;
        let disagrees_since = disagrees.then(|| *self.disagrees_since.get_or_insert(self.now));
        let strays = is_current && output_a.abs() > 0.1 && !told_closed && !contactor_closed;
        let strays_since = strays.then(|| *self.strays_since.get_or_insert(self.now));
        (self.disagrees_since, self.strays_since) = (disagrees_since, strays_since);
        let lasts =
            |since: Option<Millis>, ms| since.is_some_and(|since| self.now.since(since) >= DurationMs(ms));
        let causes = [
            (FaultCode::ContactorWelded, lasts(disagrees_since, 250) && contactor_closed),
            (FaultCode::ContactorStuckOpen, lasts(disagrees_since, 250) && !contactor_closed),
            (FaultCode::OverCurrent, output_a.abs() > 5.51),
            (FaultCode::OverVoltage, is_voltage && output_v > 30.0),
            (FaultCode::OverTemperature, (80.0..125.0).contains(&contact_c) && !temperature),
            (FaultCode::ReversedPolarity, is_voltage && output_v < -2.0),
            (FaultCode::StrayCurrent, lasts(strays_since, 150)),
            (FaultCode::VoltageSensor, !is_voltage),
            (FaultCode::CurrentSensor, !is_current),
            (FaultCode::TemperatureSensor, !(-30.0..125.0).contains(&contact_c) || temperature),
            (FaultCode::EmergencyStop, sensors.emergency_stop),
            (FaultCode::MainsLost, !sensors.mains),
        ];
        causes.into_iter().filter(|(_, is_there)| *is_there).map(|(code, _)| code).collect()
    }

    /// What a sample shows is a fault from then on, and one that latches until it is cleared.
    fn judge_faults(&mut self, causes: &BTreeSet<FaultCode>) {
        use FaultCode::{EmergencyStop, MainsLost, ReversedPolarity};
        let active: BTreeSet<_> = self.pile.faults().active().iter().collect();
        assert!(causes.is_subset(&active), "{causes:?} are there, but only {active:?} found");
        self.caused.extend(causes);
        let passing = [EmergencyStop, MainsLost, ReversedPolarity];
        self.uncleared.extend(causes.iter().filter(|code| !passing.contains(code)));
    }

    fn judge(&mut self, outputs: &Outputs) {
        self.steps += 1;
        let stand: BTreeSet<_> = self.pile.faults().standing().iter().collect();
        assert!(self.uncleared.is_subset(&stand), "of {:?} only {stand:?} stand", self.uncleared);
        assert!(outputs.messages.len() < outputs.messages.capacity(), "a message may not have fitted");
        for record in &outputs.store {
            match record {
                Record::Epoch(epoch) => {
                    assert!(*epoch > self.highest_epoch);
                    self.highest_epoch = *epoch;
                }
                Record::Latched(latched) => self.stored_latched = latched.iter().collect(),
                Record::Counters(_) | Record::Waiting(..) | Record::Acknowledged(_) => {}
                Record::Identity(_) => panic!("nobody provisioned the pile"),
            }
        }
        let latched: BTreeSet<_> = self.pile.faults().latched().iter().collect();
        assert_eq!(latched, self.stored_latched, "a restart would forget faults");
        for outgoing in &outputs.messages {
            match &outgoing.message {
                Message::TimeRequest(request) => self.asked_at = Some(request.asked_at),
                Message::PileState(state) => self.judge_state(state),
                Message::PassReport(report) => self.outstanding = Some(report.report),
                Message::Fault(fault) => {
                    self.outstanding = Some(fault.report);
                    self.told.insert(fault.code, fault.active);
                }
                Message::PileFaults(told) => {
                    assert!(outputs.urgent && outputs.messages.len() == 1, "the last word comes alone");
                    let names = |code| told.faults.iter().any(|fault| fault.code == code);
                    assert!(names(FaultCode::MainsLost));
                }
                _ => {}
            }
        }
        let holder = self.pile.leases().current().map(|lease| lease.name.lease);
        self.judge_holder(holder);
        self.judge_beginning();
        self.judge_power(outputs.power);
        assert_eq!(self.pile.energised(), outputs.power.is_closed());
    }

    /// The contacts become live at no current and only while nothing forbids it. Once something
    /// does, they get no more current and are dead soon: at once, if it cannot wait.
    fn judge_power(&mut self, power: Power) {
        let before = std::mem::replace(&mut self.power, power);
        self.plant.command(power);
        assert!((0.0..=self.parameters.limits.current_max_a).contains(&power.current_limit_a));
        if !power.is_closed() {
            assert_eq!(power.current_limit_a, 0.0);
            self.forbidden_since = None;
            return;
        }
        assert!(before.is_closed() || power.current_limit_a == 0.0, "the contactor closed under load");
        let forbidden = self.forbids();
        if let Some(why) = &forbidden {
            assert!(before.is_closed(), "the contactor closed though {why}");
            self.forbidden_since.get_or_insert(self.now);
        } else {
            self.live_steps += 1;
        }
        let sensors = self.sensed.expect("live contacts without sensors").1;
        assert!(!sensors.emergency_stop, "closed with the emergency stop pressed");
        let over_a = 1.1 * self.parameters.limits.current_max_a;
        assert!(
            sensors.output_a.abs() <= over_a || sensors.output_a.is_nan(),
            "closed at {} A",
            sensors.output_a
        );
        let rises = power.current_limit_a > before.current_limit_a;
        assert!(!rises || sensors.contactor_closed, "more current through a contactor that is not closed");
        if let Some(since) = self.forbidden_since {
            assert!(power.current_limit_a <= before.current_limit_a, "more current though {forbidden:?}");
            let late = self.now.since(since);
            assert!(late < DurationMs(300), "closed {late:?} after {forbidden:?}");
        }
    }

    /// Why the contacts must not be live, if so.
    fn forbids(&self) -> Option<String> {
        let reason = |reason: &str| Some(reason.to_owned());
        let Some(promise) = self.holder.map(|holder| &self.promises[&holder]) else {
            return reason("no lease is held");
        };
        if self.pile.leases().current().is_none_or(|lease| lease.charge.is_none()) {
            return reason("no charge has begun");
        }
        let read_lately = |read: &Millis| self.now.since(*read) < self.parameters.tag_timeout;
        if !self.last_read.get(&promise.tag).is_some_and(read_lately) {
            return reason("the tag was not read lately");
        }
        if self.now.since(self.reader_heard) >= READER_TIMEOUT {
            return reason("the reader is silent");
        }
        if self.site_now() >= promise.expiry
            && promise.heard_past_expiry.is_some_and(|heard| self.now.since(heard) >= EXTENSION_GRACE)
        {
            return reason("the coordinator has not extended the lease");
        }
        if !self.uncleared.is_empty() || !self.pile.faults().standing().is_empty() {
            return Some(format!("there are faults: {:?}", self.pile.faults()));
        }
        match self.sensed {
            Some((at, sensors)) if self.now.since(at) < DurationMs(250) => forbidden_by(&sensors),
            _ => reason("the sensors were not read lately"),
        }
    }

    /// A charge begins before its lease has run out, and while its robot is alone at the contacts.
    fn judge_beginning(&mut self) {
        let Some(lease) = self.pile.leases().current().filter(|lease| lease.charge.is_some()) else { return };
        let site_now = self.site_now();
        let Some(promise) = self.promises.get_mut(&lease.name.lease).filter(|promise| !promise.begun) else {
            return;
        };
        promise.begun = true;
        assert!(site_now < promise.expiry, "a charge began under a lease that had run out");
        assert!(self.sensed.is_some_and(|(_, sensors)| sensors.mated), "a charge began without a robot");
        let lately = |read: &Millis| self.now.since(*read) < self.parameters.tag_timeout;
        let strangers =
            self.last_strong_read.iter().filter(|(tag, read)| **tag != promise.tag && lately(read));
        assert_eq!(strangers.count(), 0, "a charge began though another robot stood at the contacts");
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

    fn judge_state(&mut self, state: &PileState) {
        assert!(state.row.version > self.version);
        self.version = state.row.version;
        assert!((0.0..=1.0).contains(&state.row.remaining.get()));
        let Some(holder) = state.holder.filter(|_| state.row.availability == Availability::Charging) else {
            assert_eq!(state.row.remaining, Fraction::MIN);
            return;
        };
        let promise = self.promises.get_mut(&holder.lease).expect("a lease that was acknowledged");
        assert_eq!(*promise.planned.get_or_insert(state.row.planned), state.row.planned);
        assert!(state.row.remaining <= promise.remaining, "the charge went backwards");
        promise.remaining = state.row.remaining;
        assert_eq!(state.elapsed, promise.live);
    }
}

/// What the numbers of a pile for 24 V batteries forbid.
fn forbidden_by(sensors: &Sensors) -> Option<String> {
    let Sensors { output_v, output_a, contact_c, mated, mains, .. } = *sensors;
    let says = |text: String| Some(text);
    match () {
        () if !mated => says("nothing touches the contacts".into()),
        () if !mains => says("the mains are lost".into()),
        () if !(15.0..=30.0).contains(&output_v) => says(format!("{output_v} V")),
        () if !(-30.0..80.0).contains(&contact_c) => says(format!("{contact_c} degrees")),
        () if !output_a.is_finite() => says(format!("{output_a} A")),
        () => None,
    }
}
