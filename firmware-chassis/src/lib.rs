//! The Mecanum chassis: its behaviour as a pure no_std core, and the boards it runs on.
//!
//! A chassis has four Mecanum wheels, each with a motor, a driver that can report a fault and an
//! encoder; a gyroscope; a battery whose voltage and current are measured; and a line to the
//! robot's computer, which tells it how to drive. The core is [`Chassis::step`]: time and one
//! input go in, what the motors shall do and messages come out. It reads no clock, waits for
//! nothing and allocates nothing, so the same code runs on the microcontroller, in its emulation
//! and in the tests.
//!
//! *A command becomes motion* walks through these rooms: [`commands`] takes it, [`limits`] refuses
//! what the robot must not do, [`kinematics`] makes wheel speeds of it, [`ramp`] leads there in
//! small steps, [`control`] makes duties of the difference to what [`wheel`] measures. The way
//! back: [`wheel`], [`kinematics`], [`odometry`].
//!
//! | module | one idea |
//! |---|---|
//! | [`chassis`] | the core: a control tick, and which input concerns which room |
//! | [`parameters`] | what differs from robot to robot |
//! | [`kinematics`] | wheel speeds and the robot's motion (Mecanum eqs. 1, 2) |
//! | [`limits`] | what the robot must not be asked for |
//! | [`commands`] | which commands are new, repeated or late |
//! | [`ramp`] | how set-points change: 0.01 m/s a tick |
//! | [`wheel`] | distance and speed of a wheel, from its encoder's counts |
//! | [`control`] | the duty that makes a wheel follow its set-point |
//! | [`motion`] | driving, stopping, braked: which of them, and why |
//! | [`odometry`] | where the robot is, and how sure that is |
//! | [`covariance`] | how sure a place in the plane is |
//! | [`trig`] | sine and cosine for a core without f64 |
//! | [`gyro`] | the turn rate, its bias taken out |
//! | [`icm20948`] | the driver of the gyroscope |
//! | [`monitor`] | what is wrong with the chassis, and how it is noticed |
//! | [`battery`] | what the battery holds, and what tasks take from it (Access eqs. 1, 2) |
//! | [`report`] | the numbers as quantities of the wire |
//! | [`passing`] | which piles the robot passes (LMPP eq. 4) |
//! | [`voice`] | what the chassis says of itself, and when |
//! | `tasks` | the task that runs the core, generic over a board's drivers; only built for ARM |
//! | `board` | the boards it runs on, only built for them |
//! | [`plant`] | a model of motors, wheels, battery and gyroscope, for tests and emulation |
#![cfg_attr(not(test), no_std)]

pub mod battery;
#[cfg(all(target_arch = "arm", target_os = "none"))]
pub mod board;
pub mod chassis;
pub mod commands;
pub mod control;
pub mod covariance;
pub mod gyro;
pub mod icm20948;
pub mod kinematics;
pub mod limits;
pub mod monitor;
pub mod motion;
pub mod odometry;
pub mod parameters;
pub mod passing;
pub mod plant;
pub mod ramp;
pub mod report;
#[cfg(all(target_arch = "arm", target_os = "none"))]
pub mod tasks;
pub mod trig;
pub mod voice;
pub mod wheel;

pub use chassis::{BatterySample, Chassis, Input, Messages, Motors, Sensors};
pub use kinematics::{Kinematics, Velocity, WheelSpeeds};
pub use parameters::{ParameterError, Parameters, Start};

/// The control tick in seconds: the paper's 100 Hz.
pub const TICK_S: f32 = 0.01;
/// The control tick in milliseconds.
pub const TICK: protocol::DurationMs = protocol::DurationMs(10);
