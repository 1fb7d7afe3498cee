//! The chassis' core: a control tick, and which input concerns which room. What the robot's computer
//! tells it is in `orders`, what it says itself in `telemetry`.
//!
//! A tick has five parts: sensors are taken in, the odometer moves on, faults and time decide
//! whether the robot may drive, set-points and duties follow, and messages that are due go out. A
//! step's work and memory are bounded.

mod orders;
mod telemetry;

use firmware_common::reader::TagRead;
use heapless::Vec;
use protocol::{Frame, FrameError, Message, Millis, StopReason};

use crate::{
    TICK, TICK_S,
    battery::{Battery, Tasks},
    commands::Commands,
    control::{ControlLaw, WheelControl, WheelState},
    gyro::Gyro,
    kinematics::{Kinematics, Velocity, WheelSpeeds, slip_speed},
    monitor::{Monitor, WheelSample},
    motion::Motion,
    odometry::{Odometer, Pose, Rolled},
    parameters::{ParameterError, Parameters, Start},
    passing::Passing,
    ramp::Ramp,
    voice::Voice,
    wheel::WheelObserver,
};

/// The most messages a step sends, at a tick: Hello, the state, a question for the time, passes,
/// odometry.
pub const MESSAGES_PER_STEP: usize = 5;
/// The most ticks a late one is taken for; further ones are lost to the odometer.
const MOST_PERIODS: u32 = 100;

/// What the sensors say at a tick. Numbers may be anything; nonsense is ignored.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sensors {
    /// The low 16 bits of the encoders' counters, wheels A to D, counting up as the wheel rolls
    /// forward.
    pub encoders: [u16; 4],
    /// Which motor drivers report a fault.
    pub driver_faults: [bool; 4],
    /// The gyroscope's rate about z, counter-clockwise, in rad/s, if it answered.
    pub gyro_radps: Option<f32>,
    /// The battery, if it was measured.
    pub battery: Option<BatterySample>,
}

/// A measurement of the battery.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BatterySample {
    /// At its terminals, in V.
    pub voltage_v: f32,
    /// Out of it, in A.
    pub current_a: f32,
}

/// What can happen to a chassis.
#[derive(Clone, Copy, Debug)]
pub enum Input<'a> {
    /// A control tick, every [`TICK`] by a hardware timer. The robot's motion is controlled here
    /// and nowhere else; other inputs wait for it.
    Tick(Sensors),
    /// The reader read a pile's tag.
    Tag(TagRead),
    /// A frame arrived.
    Frame(&'a Frame),
    /// Something arrived that is no frame.
    Discarded(FrameError),
}

/// What the motors do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motors {
    /// Windings shorted: they brake, and hold the robot.
    Brake,
    /// A signed share of the supply voltage for each, from -1 to 1; positive rolls forward.
    Drive([f32; 4]),
}

/// The messages of a step, all for the robot's computer.
pub type Messages = Vec<Message, MESSAGES_PER_STEP>;

/// A Mecanum chassis.
#[derive(Clone, Debug)]
pub struct Chassis {
    parameters: Parameters,
    kinematics: Kinematics,
    now: Millis,
    ticked_at: Option<Millis>,
    motors: Motors,
    motion: Motion,
    commands: Commands,
    ramp: Ramp,
    /// The ramp's last step, in m/s.
    step: WheelSpeeds,
    wheels: [WheelObserver; 4],
    law: ControlLaw,
    controls: [WheelControl; 4],
    gyro: Gyro,
    odometer: Odometer,
    monitor: Monitor,
    battery: Battery,
    tasks: Tasks,
    passing: Passing,
    voice: Voice,
    /// The velocity at the last tick: of the wheels, with the gyroscope's turn rate if there is one.
    velocity: Velocity,
    gyro_heard: bool,
    discarded: u32,
    /// The count of `discarded` when the last good frame arrived.
    discarded_before: u32,
}

impl Chassis {
    /// A chassis that has just started: braked, at its origin.
    ///
    /// # Errors
    /// [`ParameterError`] names a parameter it cannot work with.
    pub fn new(parameters: Parameters) -> Result<Self, ParameterError> {
        parameters.check()?;
        let Parameters { geometry, start, ramp, noise, pack, motor, gains, passes, .. } = parameters;
        let reason = match start {
            Start::PowerOn => StopReason::Started,
            Start::Watchdog => StopReason::Watchdog,
        };
        Ok(Self {
            parameters,
            kinematics: Kinematics::new(geometry.wheelbase_m, geometry.track_m),
            now: Millis(0),
            ticked_at: None,
            motors: Motors::Brake,
            motion: Motion::Braked { reason },
            commands: Commands::new(),
            ramp: Ramp::new(ramp),
            step: WheelSpeeds::zeros(),
            law: ControlLaw::new(motor, gains),
            wheels: [const { WheelObserver::new() }; 4],
            controls: [const { WheelControl::new() }; 4],
            gyro: Gyro::new(),
            odometer: Odometer::new(noise, geometry.metres_per_count()),
            monitor: Monitor::new(),
            battery: Battery::new(pack),
            tasks: Tasks::new(),
            passing: Passing::new(passes, parameters.boot),
            voice: Voice::new(),
            velocity: Velocity::zeros(),
            gyro_heard: false,
            discarded: 0,
            discarded_before: 0,
        })
    }

    /// Takes one input at `now` on the chassis' own clock, and puts what is to be sent, in order, in
    /// place of what is in `messages`. Answers what the motors do from now on, to be done first: an
    /// emergency stop comes out of the step that took its frame. Should `now` lie before an earlier
    /// step's, no time has passed.
    ///
    /// The room for messages is the caller's because they are large: to move them out of here would
    /// cost as much as half of the tick.
    pub fn step(&mut self, now: Millis, input: Input<'_>, messages: &mut Messages) -> Motors {
        self.now = self.now.max(now);
        messages.clear();
        match input {
            Input::Tick(sensors) => {
                self.tick(&sensors);
                self.speak(messages);
            }
            Input::Tag(read) => self.passing.read(self.now, read),
            Input::Frame(frame) => self.hear(frame, messages),
            Input::Discarded(_) => self.discarded = self.discarded.saturating_add(1),
        }
        self.motors
    }

    /// Driving, stopping or braked, and why.
    #[must_use]
    pub const fn motion(&self) -> &Motion {
        &self.motion
    }

    /// The wheels' set-points at the last tick, in m/s; zero while braked.
    #[must_use]
    pub const fn setpoints(&self) -> &WheelSpeeds {
        self.ramp.setpoints()
    }

    /// Where the robot is.
    #[must_use]
    pub const fn pose(&self) -> Pose {
        self.odometer.pose()
    }

    /// How the robot moves, in its own frame: m/s, m/s, rad/s.
    #[must_use]
    pub const fn velocity(&self) -> &Velocity {
        &self.velocity
    }

    fn tick(&mut self, sensors: &Sensors) {
        let gap = self.ticked_at.replace(self.now).map_or(0, |at| self.now.since(at).0);
        let periods = ((gap + TICK.0 / 2) / TICK.0).clamp(1, MOST_PERIODS);
        let elapsed_s = TICK_S * periods as f32;

        let battery = sensors.battery.map(|sample| (sample.voltage_v, sample.current_a));
        self.battery.update(battery, elapsed_s);
        let counted = self.measure(sensors, elapsed_s);
        if let Some(reason) = self.check(sensors, counted) {
            self.brake(reason);
        }
        self.settle_motion();
        self.step = self.ramp.advance(&self.motion.target());
        self.command_motors();
    }

    /// Ends what is over: a command whose time is up, and a ramp to a stop.
    fn settle_motion(&mut self) {
        match self.motion {
            Motion::Driving { until, .. } if self.now >= until => {
                let damaged = self.discarded > self.discarded_before;
                let reason = if damaged { StopReason::LinkCorrupted } else { StopReason::LinkSilent };
                self.motion.stop_for(reason);
            }
            Motion::Stopping { reason } if *self.ramp.setpoints() == WheelSpeeds::zeros() => {
                self.brake(reason);
            }
            _ => {}
        }
    }

    /// Takes in wheels and gyroscope, and moves the odometer on. Answers which wheels have counted.
    fn measure(&mut self, sensors: &Sensors, elapsed_s: f32) -> [bool; 4] {
        let metres_per_count = self.parameters.geometry.metres_per_count();
        let mut counts = [0; 4];
        let each = counts.iter_mut().zip(&mut self.wheels).zip(sensors.encoders).zip(self.step.iter());
        for (((counts, wheel), counter), &step_mps) in each {
            *counts = wheel.update(counter, metres_per_count, step_mps, elapsed_s);
        }

        let rest = counts == [0; 4] && *self.ramp.setpoints() == WheelSpeeds::zeros();
        let gyro_radps = self.gyro.update(sensors.gyro_radps, rest);
        let speeds = self.speeds();
        self.velocity = self.kinematics.twist(&speeds);
        let arm_m = self.parameters.geometry.lever_arm_m();
        let turn_mps = gyro_radps.map_or(0.0, |rate| (rate - self.velocity.z) * arm_m);
        self.monitor.check_grip(slip_speed(&speeds), turn_mps);

        let wheels_m = WheelSpeeds::from(counts.map(|counts| f32::from(counts) * metres_per_count));
        let gyro_rad = gyro_radps.map(|rate| rate * elapsed_s);
        let slipping = self.monitor.is_slipping();
        self.odometer.advance(&self.kinematics, &Rolled { wheels_m, gyro_rad, elapsed_s, slipping });
        self.gyro_heard = gyro_radps.is_some();
        self.velocity.z = gyro_radps.unwrap_or(self.velocity.z);
        counts.map(|counts| counts != 0)
    }

    /// Why the chassis has to brake now, if it has to. The duties are those of the last tick.
    fn check(&mut self, sensors: &Sensors, counted: [bool; 4]) -> Option<StopReason> {
        let duties = match self.motors {
            Motors::Brake => [0.0; 4],
            Motors::Drive(duties) => duties,
        };
        let speeds = self.speeds();
        let wheels = core::array::from_fn(|wheel| WheelSample {
            duty: duties[wheel],
            speed_mps: speeds[wheel],
            counted: counted[wheel],
            driver_fault: sensors.driver_faults[wheel],
        });
        let current_a = self.battery.state().filter(|_| !self.battery.is_silent()).map(|b| b.current.get());
        self.monitor.check(wheels, current_a, &self.parameters.motor, &self.parameters.pack)
    }

    fn brake(&mut self, reason: StopReason) {
        self.motion.brake_for(reason);
        self.ramp.reset();
        self.step = WheelSpeeds::zeros();
        self.controls.iter_mut().for_each(WheelControl::reset);
        self.motors = Motors::Brake;
    }

    fn command_motors(&mut self) {
        if let Motion::Braked { .. } = self.motion {
            self.motors = Motors::Brake;
            return;
        }
        let motor = &self.parameters.motor;
        let boost = self
            .battery
            .state()
            .map_or(1.0, |battery| (motor.nominal_v / battery.voltage.get().max(1.0)).clamp(0.5, 2.0));
        let mut duties = [0.0; 4];
        let each = duties.iter_mut().zip(&mut self.controls).zip(&self.wheels);
        for (((duty, control), wheel), (&setpoint_mps, &step_mps)) in
            each.zip(self.ramp.setpoints().iter().zip(self.step.iter()))
        {
            let wheel = WheelState { setpoint_mps, step_mps, speed_mps: wheel.speed_mps() };
            *duty = control.duty(&self.law, wheel, boost);
        }
        self.motors = Motors::Drive(duties);
    }

    fn speeds(&self) -> WheelSpeeds {
        WheelSpeeds::from(self.wheels.each_ref().map(WheelObserver::speed_mps))
    }
}

fn say(messages: &mut Messages, message: Message) {
    // It fits: a step sends each kind of message at most once, and they are fewer than the room.
    let _ = messages.push(message);
}
