//! A model of motors, wheels, battery and gyroscope, for tests and emulation. It knows nothing of
//! the control: what it gets is what the motors get, what it gives is what the sensors give.
//!
//! - A wheel with its share of the robot's mass is a first-order system with Coulomb friction and
//!   stiction: tau v' = v_free (duty V / V_nominal - friction sign(v)) - v. Braked, its duty is 0.
//! - A wheel's grip is the share of its speed that reaches the floor. The robot moves as the best
//!   fit of what reaches the floor says (eq. 2), along an arc each millisecond.
//! - An encoder counts whole counts in 16 bits and wraps.
//! - A driver takes from the battery its motor's current times its duty.
//! - The gyroscope has a bias and white noise, from a generator of its own: every run is the same.

use crate::{
    TICK_S,
    chassis::{BatterySample, Motors, Sensors},
    kinematics::{Kinematics, Velocity, WheelSpeeds},
    odometry::Pose,
    parameters::{Geometry, Motor, Pack, Parameters},
};

/// Sub-steps of a tick.
const SUBSTEPS: u8 = 10;
/// A standing wheel needs this much more than friction to break away.
const STICTION: f32 = 1.3;

/// A robot on a floor. Its public fields may be changed between ticks, to break something.
#[derive(Clone, Debug)]
pub struct Plant {
    /// The real motors, which may be unlike those in the control's parameters.
    pub motors: [Motor; 4],
    /// The share of each wheel's speed that reaches the floor; 1 unless it slips.
    pub grip: [f32; 4],
    /// Wheels that cannot turn.
    pub blocked: [bool; 4],
    /// Encoders that do not count.
    pub encoder_stuck: [bool; 4],
    /// Drivers that report a fault.
    pub driver_faults: [bool; 4],
    /// Of the gyroscope, in rad/s; none if it does not answer.
    pub gyro_bias_radps: Option<f32>,
    /// Standard deviation of the gyroscope's noise, in rad/s.
    pub gyro_noise_radps: f32,
    /// Whether the battery's meter answers.
    pub meter_answers: bool,
    geometry: Geometry,
    kinematics: Kinematics,
    pack: Pack,
    /// A sum of many small numbers.
    drawn_j: f64,
    current_a: f32,
    speeds_mps: WheelSpeeds,
    counters: [u16; 4],
    fractions: [f32; 4],
    velocity: Velocity,
    pose: Pose,
    noise: u32,
}

impl Plant {
    /// The robot of these parameters, at rest and full, its counters at `counters`.
    #[must_use]
    pub fn new(parameters: &Parameters, counters: [u16; 4]) -> Self {
        let Parameters { geometry, motor, pack, .. } = *parameters;
        Self {
            motors: [motor; 4],
            grip: [1.0; 4],
            blocked: [false; 4],
            encoder_stuck: [false; 4],
            driver_faults: [false; 4],
            gyro_bias_radps: Some(0.02),
            gyro_noise_radps: 0.003,
            meter_answers: true,
            geometry,
            kinematics: Kinematics::new(geometry.wheelbase_m, geometry.track_m),
            pack,
            drawn_j: 0.0,
            current_a: pack.idle_a,
            speeds_mps: WheelSpeeds::zeros(),
            counters,
            fractions: [0.5; 4],
            velocity: Velocity::zeros(),
            pose: Pose::default(),
            noise: 0x9E37_79B9,
        }
    }

    /// Where the robot really is.
    #[must_use]
    pub const fn pose(&self) -> Pose {
        self.pose
    }

    /// How it really moves, in its own frame.
    #[must_use]
    pub const fn velocity(&self) -> &Velocity {
        &self.velocity
    }

    /// How fast its wheels really turn, in m/s at the rim.
    #[must_use]
    pub const fn speeds_mps(&self) -> &WheelSpeeds {
        &self.speeds_mps
    }

    /// What its battery really holds, in J.
    #[must_use]
    pub fn energy_j(&self) -> f32 {
        (self.pack.full_j - self.drawn_j as f32).max(0.0)
    }

    /// What was ever drawn from it, in J.
    #[must_use]
    pub const fn drawn_j(&self) -> f32 {
        self.drawn_j as f32
    }

    /// One tick with this command. Answers what the sensors say at its end.
    pub fn advance(&mut self, motors: Motors) -> Sensors {
        let duties = match motors {
            Motors::Brake => [0.0; 4],
            Motors::Drive(duties) => duties,
        };
        let step_s = TICK_S / f32::from(SUBSTEPS);
        let mut drawn_as = 0.0;
        for _ in 0..SUBSTEPS {
            let voltage = self.voltage();
            let mut current = self.pack.idle_a;
            for (wheel, duty) in duties.into_iter().enumerate() {
                current += self.turn(wheel, duty, voltage, step_s);
            }
            self.current_a = current;
            drawn_as += current * step_s;
            self.drawn_j += f64::from(voltage * current * step_s);
            let floor = self.speeds_mps.component_mul(&WheelSpeeds::from(self.grip));
            self.velocity = self.kinematics.twist(&floor);
            self.pose = self.pose.moved(&(self.velocity * step_s));
        }
        // The meter averages over the tick.
        self.current_a = drawn_as / TICK_S;
        self.sensors()
    }

    /// What the sensors say now.
    pub fn sensors(&mut self) -> Sensors {
        let noise = self.gyro_noise_radps * self.gauss();
        Sensors {
            encoders: self.counters,
            driver_faults: self.driver_faults,
            gyro_radps: self.gyro_bias_radps.map(|bias| self.velocity.z + bias + noise),
            battery: self
                .meter_answers
                .then(|| BatterySample { voltage_v: self.voltage(), current_a: self.current_a }),
        }
    }

    fn voltage(&self) -> f32 {
        let Pack { full_j, full_v, empty_v, resistance_ohm, .. } = self.pack;
        empty_v + (full_v - empty_v) * self.energy_j() / full_j - resistance_ohm * self.current_a
    }

    /// A sub-step of a wheel. Answers what its driver takes from the battery, in A.
    fn turn(&mut self, wheel: usize, duty: f32, voltage: f32, step_s: f32) -> f32 {
        let (Some(motor), Some(speed)) = (self.motors.get(wheel), self.speeds_mps.get_mut(wheel)) else {
            return 0.0;
        };
        let supply = duty * voltage / motor.nominal_v;
        let drive = motor.free_speed_mps * supply;
        let friction = motor.free_speed_mps * motor.friction_duty;
        let before = *speed;
        *speed = if self.blocked.get(wheel).is_some_and(|&blocked| blocked)
            || (before == 0.0 && drive.abs() <= STICTION * friction)
        {
            0.0
        } else {
            let against = if before == 0.0 { friction.copysign(drive) } else { friction.copysign(before) };
            let after = before + step_s / motor.time_constant_s * (drive - against - before);
            // Friction stops a wheel and does not turn it back.
            if after * before < 0.0 && drive.abs() <= friction { 0.0 } else { after }
        };
        let rolled_m = 0.5 * (before + *speed) * step_s;
        let motor_a = motor.stall_current_a * (supply - *speed / motor.free_speed_mps);
        self.count(wheel, rolled_m);
        duty * motor_a
    }

    fn count(&mut self, wheel: usize, rolled_m: f32) {
        let stuck = self.encoder_stuck.get(wheel).is_some_and(|&stuck| stuck);
        let (Some(counter), Some(fraction)) = (self.counters.get_mut(wheel), self.fractions.get_mut(wheel))
        else {
            return;
        };
        *fraction += rolled_m / self.geometry.metres_per_count();
        let whole = libm::floorf(*fraction);
        *fraction -= whole;
        if !stuck {
            *counter = counter.wrapping_add(whole as i32 as u16);
        }
    }

    /// About normal, from the sum of four uniform numbers (xorshift).
    fn gauss(&mut self) -> f32 {
        let mut sum = -2.0;
        for _ in 0..4 {
            self.noise ^= self.noise << 13;
            self.noise ^= self.noise >> 17;
            self.noise ^= self.noise << 5;
            sum += self.noise as f32 / u32::MAX as f32;
        }
        sum * 1.732
    }
}
