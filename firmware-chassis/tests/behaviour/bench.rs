//! A chassis on a floor: the core, a model of its robot, and the robot's computer.

use firmware_chassis::{Chassis, Input, Messages, Motors, Parameters, Sensors, Velocity, plant::Plant};
use protocol::*;

/// The robot of all tests.
pub const ROBOT: Parameters = Parameters::new(RobotId(7));
/// Rounding of set-points of up to 1 m/s.
pub const ROUNDING_MPS: f32 = 2.0 * f32::EPSILON;

/// What came out of a step.
pub struct Outputs {
    /// What the motors do.
    pub motors: Motors,
    /// What is sent.
    pub messages: Messages,
}

/// A chassis, its world and its clock.
pub struct Bench {
    /// The core.
    pub chassis: Chassis,
    /// The world.
    pub plant: Plant,
    /// The chassis' time.
    pub now: Millis,
    /// What the sensors said last.
    pub sensors: Sensors,
    /// What the motors were told last.
    pub motors: Motors,
    /// Everything the chassis ever sent.
    pub sent: Vec<Message>,
    next: u32,
}

impl Bench {
    /// A rested robot: its gyroscope's bias is known.
    pub fn new() -> Self {
        Self::with(ROBOT)
    }

    /// The same with other parameters.
    pub fn with(parameters: Parameters) -> Self {
        // The counters are about to wrap, each its own way.
        let mut plant = Plant::new(&parameters, [0xFFF0, 0x0010, 0x7FF0, 0x8010]);
        let sensors = plant.sensors();
        let chassis = Chassis::new(parameters).unwrap();
        let motors = Motors::Brake;
        let mut bench = Self { chassis, plant, now: Millis(0), sensors, motors, sent: Vec::new(), next: 0 };
        bench.wait(2.0);
        bench
    }

    /// One step at the present time.
    pub fn step(&mut self, input: Input<'_>) -> Outputs {
        let mut messages = Messages::new();
        let motors = self.chassis.step(self.now, input, &mut messages);
        let outputs = Outputs { motors, messages };
        self.motors = outputs.motors;
        self.sent.extend(outputs.messages.iter().cloned());
        outputs
    }

    /// One control tick: the world moves on, then the chassis looks.
    pub fn tick(&mut self) -> Outputs {
        self.now.0 += 10;
        self.sensors = self.plant.advance(self.motors);
        self.step(Input::Tick(self.sensors))
    }

    /// Ticks for so long.
    pub fn wait(&mut self, seconds: f32) {
        for _ in 0..(seconds * 100.0).round() as u32 {
            self.tick();
        }
    }

    /// A frame from the robot's computer, in its start 1.
    pub fn hear(&mut self, message: Message) -> Outputs {
        let header = Header::new(DeviceId::Robot(ROBOT.robot), BootEpoch(1), Sequence(0));
        self.step(Input::Frame(&Frame { header, message }))
    }

    /// The next number of a command.
    pub fn command(&mut self) -> CommandId {
        self.next += 1;
        CommandId(self.next)
    }

    /// Tells it to drive; answers what it answered.
    pub fn drive(&mut self, velocity: Velocity, ttl: DurationMs) -> Result<(), NackReason> {
        let command = self.command();
        let outputs = self.hear(Message::Drive(Drive { command, ttl, twist: twist(velocity) }));
        answer(&outputs, command)
    }

    /// Drives for so long as a good computer does: a command every 100 ms. Calls `each` at every
    /// tick.
    pub fn keep_driving(&mut self, velocity: Velocity, seconds: f32, mut each: impl FnMut(&Self)) {
        for tick in 0..(seconds * 100.0).round() as u32 {
            if tick % 10 == 0 {
                assert_eq!(self.drive(velocity, limits::DRIVE_TTL), Ok(()));
            }
            self.tick();
            each(self);
        }
    }

    /// Tells it to stop; answers what it answered.
    pub fn stop(&mut self, emergency: bool) -> Result<(), NackReason> {
        let command = self.command();
        let outputs = self.hear(Message::Stop(Stop { command, emergency }));
        answer(&outputs, command)
    }

    /// Releases a held stop; answers what it answered.
    pub fn release(&mut self) -> Result<(), NackReason> {
        let command = self.command();
        let outputs = self.hear(Message::Release(Release { command }));
        answer(&outputs, command)
    }

    /// The mode and stop it told last.
    pub fn told(&self) -> (ChassisMode, Option<StopReason>) {
        let state = self.state();
        (state.mode, state.stop)
    }

    /// The state it told last.
    pub fn state(&self) -> &ChassisState {
        let states = self.sent.iter().rev();
        states
            .filter_map(|message| if let Message::ChassisState(state) = message { Some(state) } else { None })
            .next()
            .unwrap()
    }

    /// The motion it told last.
    pub fn odometry(&self) -> &Odometry {
        let reports = self.sent.iter().rev();
        reports
            .filter_map(|message| if let Message::Odometry(report) = message { Some(report) } else { None })
            .next()
            .unwrap()
    }
}

/// A velocity as it goes over the wire.
pub fn twist(velocity: Velocity) -> Twist {
    Twist {
        vx: SpeedMps::new(velocity.x).unwrap(),
        vy: SpeedMps::new(velocity.y).unwrap(),
        wz: TurnRateRadps::new(velocity.z).unwrap(),
    }
}

/// The answer to a command.
pub fn answer(outputs: &Outputs, command: CommandId) -> Result<(), NackReason> {
    let of = Reference::Command(command);
    let mut answers = outputs.messages.iter().filter_map(|message| match message {
        Message::Ack(ack) if ack.of == of => Some(Ok(())),
        Message::Nack(nack) if nack.of == of => Some(Err(nack.reason)),
        _ => None,
    });
    answers.next_back().expect("every command is answered")
}

/// The refusal of a chassis.
pub fn refused(refusal: ChassisRefusal) -> Result<(), NackReason> {
    Err(NackReason::Chassis { refusal })
}
