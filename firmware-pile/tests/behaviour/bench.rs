//! A pile on a bench: what the tests say to it and what it answers.

use firmware_pile::{
    ChargingPile, Input, Outputs, Parameters, TagRead, To,
    plant::{Battery, Plant},
};
use protocol::*;

/// The site's clock shows this when the pile starts.
pub const SITE_AT_START: u64 = 1_000_000;

/// How often the sensors are read.
pub const SAMPLE: DurationMs = DurationMs(10);

/// A half full battery.
pub const BATTERY: Battery = Battery::new(1.0e6, 0.5e6);

/// What an RFID reader does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reader {
    /// It sees the tag that stands there.
    Sees,
    /// It answers that there is none.
    Misses,
    /// It does not answer.
    Silent,
}

/// A pile, its clock, and what its board is connected to.
pub struct Bench {
    /// The pile.
    pub pile: ChargingPile,
    /// The pile's time.
    pub now: Millis,
    /// Everything it ever sent to the coordinator.
    pub sent: Vec<Message>,
    /// Everything it ever sent to a person's tool.
    pub serviced: Vec<Message>,
    /// Everything it ever sent to the other piles.
    pub gossip: Vec<Message>,
    /// The tag of the robot that stands before the reader, and how loud it is.
    pub standing: Option<(TagId, i8)>,
    /// Power stage, contactor, contacts, sensors.
    pub plant: Plant,
    /// The battery of a robot that stands near enough to touch the contacts.
    pub battery: Option<Battery>,
    /// What the reader does.
    pub reader: Reader,
    /// Whether the coordinator answers reports and questions for the time.
    pub coordinator: bool,
    next_command: u32,
}

impl Bench {
    /// A pile of 100 W without adjustment, so that 1 kJ takes 10 s.
    pub fn new() -> Self {
        Self::with(Parameters { eta: DurationMs(0), ..Parameters::new(PileId(1), 100.0) })
    }

    /// A pile with these parameters, its clock set.
    pub fn with(parameters: Parameters) -> Self {
        let mut bench = Self {
            pile: ChargingPile::new(parameters),
            now: Millis(0),
            sent: Vec::new(),
            serviced: Vec::new(),
            gossip: Vec::new(),
            standing: None,
            plant: Plant::new(),
            battery: Some(BATTERY),
            reader: Reader::Sees,
            coordinator: true,
            next_command: 0,
        };
        bench.wait(100);
        bench
    }

    /// One step at the present time; a present coordinator answers at once.
    pub fn step(&mut self, input: Input<'_>) -> Outputs {
        let outputs = self.pile.step(self.now, input);
        self.plant.command(outputs.power);
        for outgoing in &outputs.messages {
            match outgoing.to {
                To::Coordinator => self.sent.push(outgoing.message.clone()),
                To::Service | To::Provisioner => self.serviced.push(outgoing.message.clone()),
                To::Peers => self.gossip.push(outgoing.message.clone()),
            }
        }
        if self.coordinator {
            for outgoing in &outputs.messages {
                match &outgoing.message {
                    Message::TimeRequest(request) => {
                        let sync = TimeSync { asked_at: request.asked_at, site_now: self.site_now() };
                        self.hear(Message::TimeSync(sync));
                    }
                    Message::PassReport(report) => self.acknowledge(report.report),
                    Message::ChargeReport(report) => self.acknowledge(report.report),
                    Message::Fault(fault) => self.acknowledge(fault.report),
                    _ => {}
                }
            }
        }
        outputs
    }

    /// Lets time pass: the sensors are read every 10 ms, and every 100 ms the reader sees what
    /// stands there.
    pub fn wait(&mut self, ms: u64) {
        for _ in 0..ms.div_ceil(100) {
            (0..100 / SAMPLE.0).for_each(|_| drop(self.sample()));
            match (self.reader, self.standing) {
                (Reader::Silent, _) => continue,
                (Reader::Sees, Some((tag, rssi_dbm))) => self.step(Input::Tag(TagRead { tag, rssi_dbm })),
                _ => self.step(Input::ReaderIdle),
            };
        }
    }

    /// Lets the time of one sample pass.
    pub fn sample(&mut self) -> Outputs {
        self.now = self.now.after(SAMPLE);
        let touches = self.standing.is_some_and(|(_, rssi_dbm)| rssi_dbm >= -62);
        self.plant.battery = if touches { self.plant.battery.or(self.battery) } else { None };
        let sensors = self.plant.sense(self.now);
        self.step(Input::Sensors(sensors))
    }

    /// The site's time.
    pub fn site_now(&self) -> SiteMillis {
        SiteMillis(SITE_AT_START + self.now.0)
    }

    /// The coordinator says something.
    pub fn hear(&mut self, message: Message) -> Outputs {
        let header = Header::new(DeviceId::Coordinator, BootEpoch(1), Sequence(0));
        self.step(Input::Frame(&Frame { header, message }))
    }

    /// Puts a command into the world that is valid for 5 s.
    pub fn head(&mut self) -> CommandHead {
        self.next_command += 1;
        CommandHead {
            id: CommandId(self.next_command),
            valid_until: self.site_now().after(DurationMs(5_000)),
        }
    }

    /// A grant of `energy_j` to `robot`, whose tag has its number, for 60 s.
    pub fn grant(&mut self, epoch: u32, lease: u32, robot: u16, energy_j: f32) -> Grant {
        Grant {
            head: self.head(),
            lease: LeaseRef { epoch: Epoch(epoch), lease: LeaseId(lease), robot: RobotId(robot) },
            tag: tag(robot),
            expiry: self.site_now().after(DurationMs(60_000)),
            energy: EnergyJ::new(energy_j).unwrap(),
        }
    }

    /// Sends a grant and gives the pile's answer.
    pub fn send(&mut self, grant: Grant) -> Message {
        self.hear(Message::Grant(grant)).messages[0].message.clone()
    }

    /// Whether the contacts are live after a tick.
    pub fn live(&mut self) -> bool {
        self.step(Input::Tick).power.is_closed()
    }

    /// The reports of passes so far, added up: tag, period, passes.
    pub fn passes_of(&self, tag: TagId) -> u32 {
        let reports = self.sent.iter().filter_map(|message| match message {
            Message::PassReport(report) => Some(report),
            _ => None,
        });
        reports
            .flat_map(|report| &report.passes)
            .filter(|count| count.tag == tag)
            .map(|count| count.passes)
            .sum()
    }

    fn acknowledge(&mut self, report: ReportId) {
        self.hear(Message::Ack(Ack { of: Reference::Report(report) }));
    }
}

/// The tag of `robot`.
pub fn tag(robot: u16) -> TagId {
    let [high, low] = robot.to_be_bytes();
    TagId([0xE2, 0, 0, 0, 0, 0, 0, 0, 0, 0, high, low])
}

/// The answer to a command that was obeyed.
pub fn ack(grant: &Grant) -> Message {
    Message::Ack(Ack { of: Reference::Command(grant.head.id) })
}

/// The answer to a command that was refused.
pub fn nack(grant: &Grant, reason: NackReason) -> Message {
    Message::Nack(Nack { of: Reference::Command(grant.head.id), reason })
}
