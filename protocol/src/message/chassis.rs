//! How a robot's computer drives its chassis, and what the chassis says of its motion and itself.
//!
//! Axes are those of ROS REP 103: x forward, y to the left, z up, so that a turn is positive
//! counter-clockwise. [`Drive`] carries what ROS calls a Twist and [`Odometry`] what it calls an
//! Odometry: pose in the frame in which the chassis started, twist in the frame of the robot.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::{
    ids::{CommandId, TaskId},
    limits,
    units::{
        AngleRad, CoordinateM, Covariance, CurrentA, DurationMs, EnergyJ, Millis, SpeedMps, TurnRateRadps,
        VoltageV,
    },
};

/// A velocity in the plane, in the robot's frame (ROS Twist: linear x, linear y, angular z).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Twist {
    /// Forward (Mecanum's V_x).
    pub vx: SpeedMps,
    /// To the left (V_y).
    pub vy: SpeedMps,
    /// Counter-clockwise (V_z).
    pub wz: TurnRateRadps,
}

/// Where a robot is and where it looks, in the frame in which the chassis started.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Pose {
    /// Forward of the start.
    pub x: CoordinateM,
    /// Left of the start.
    pub y: CoordinateM,
    /// Counter-clockwise from the start.
    pub yaw: AngleRad,
}

/// The covariance of a [`Pose`]: the upper half of a symmetric matrix, in m², m rad and rad².
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PoseCovariance {
    /// Of x with itself.
    pub xx: Covariance,
    /// Of x with y.
    pub xy: Covariance,
    /// Of x with yaw.
    pub xyaw: Covariance,
    /// Of y with itself.
    pub yy: Covariance,
    /// Of y with yaw.
    pub yyaw: Covariance,
    /// Of yaw with itself.
    pub yawyaw: Covariance,
}

/// The variances of a measured [`Twist`], in m²/s² and rad²/s².
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TwistVariance {
    /// Of the speed forward.
    pub vx: Covariance,
    /// Of the speed to the left.
    pub vy: Covariance,
    /// Of the turn rate.
    pub wz: Covariance,
}

/// Drive like this until told otherwise, but no longer than `ttl` from the arrival: then the
/// chassis ramps to a stop. Who drives on sends the next one in time.
///
/// Numbers of commands grow within a start of their sender. The newest command again is a repeat:
/// it is answered again, and does not extend its time; one before it comes too late.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Drive {
    /// Against repeats.
    pub command: CommandId,
    /// For how long; [`limits::DRIVE_TTL`] is a good choice.
    pub ttl: DurationMs,
    /// How.
    pub twist: Twist,
}

/// Stop. A chassis obeys an emergency stop whatever the number of its command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Stop {
    /// Against repeats.
    pub command: CommandId,
    /// Brake at once and stay braked until [`Release`], rather than ramp down.
    pub emergency: bool,
}

/// Ends an emergency stop or the stop after a fault, if its cause is gone and the wheels stand
/// still. Nothing moves until the next [`Drive`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Release {
    /// Against repeats.
    pub command: CommandId,
}

/// From now on the robot works on this task, and no longer on the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Task {
    /// Against repeats.
    pub command: CommandId,
    /// Which; none when the robot idles.
    pub task: Option<TaskId>,
}

/// What the task that has just ended took from the battery (Access eqs. 1, 2).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TaskEnergy {
    /// Which.
    pub task: TaskId,
    /// How often it was done since the chassis started (eq. 2's m).
    pub runs: u32,
    /// What it took this time (eq. 1, P_t).
    pub last: EnergyJ,
    /// What it took in the mean of all runs (eq. 2, P_E).
    pub mean: EnergyJ,
}

/// A chassis' report on its motion, every [`limits::ODOMETRY_INTERVAL`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Odometry {
    /// The control tick's time, by the chassis' clock.
    pub stamp: Millis,
    /// Where the robot is.
    pub pose: Pose,
    /// How sure that is.
    pub pose_covariance: PoseCovariance,
    /// How it moves.
    pub measured: Twist,
    /// How sure that is.
    pub measured_variance: TwistVariance,
    /// How it is to move at this tick; zero while the brakes are on.
    pub ramped: Twist,
    /// How it is to move in the end: the command in force, scaled to what the wheels can do;
    /// zero without one.
    pub commanded: Twist,
}

/// A chassis' report on itself, at every change of mode, stop or faults and at least every
/// [`limits::STATE_INTERVAL`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ChassisState {
    /// What it does.
    pub mode: ChassisMode,
    /// Why it does not drive; none while it does.
    pub stop: Option<StopReason>,
    /// What is wrong with it.
    pub faults: Vec<ChassisFault, { limits::CHASSIS_FAULTS }>,
    /// The battery, once it was measured.
    pub battery: Option<BatteryState>,
    /// Frames that arrived damaged or were no message, since its start.
    pub discarded: u32,
}

/// What a chassis does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ChassisMode {
    /// The motors brake: it stands, or soon will.
    Braked,
    /// It follows a command.
    Driving,
    /// It ramps to a stop.
    Stopping,
}

/// Why a chassis does not drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StopReason {
    /// It has just started and was not told to drive.
    Started,
    /// Its watchdog has restarted it: something in it had hung.
    Watchdog,
    /// It was told to stop.
    Commanded,
    /// The last command has outlived its time, and nothing has arrived since.
    LinkSilent,
    /// The last command has outlived its time, and what has arrived since was damaged.
    LinkCorrupted,
    /// It was told to brake at once. Held until released.
    Emergency,
    /// A motor's driver reports a fault. Held until released.
    DriverFault,
    /// A wheel is driven, draws no more than a turning one, and its encoder does not count. Held
    /// until released.
    EncoderStuck,
    /// A wheel is driven and does not turn. Held until released.
    WheelStalled,
}

/// Why a chassis refuses a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ChassisRefusal {
    /// The speed forward or backward is beyond the chassis' own limit.
    ForwardSpeed,
    /// The speed to a side is beyond the chassis' own limit.
    SidewaysSpeed,
    /// The turn rate is beyond the chassis' own limit.
    TurnRate,
    /// The time to live is zero or beyond the chassis' own limit.
    TimeToLive,
    /// A stop is held until it is released.
    Stopped {
        /// Why it stopped.
        by: StopReason,
    },
    /// The wheels have to stand still for this.
    Moving,
    /// The cause of the stop is still there.
    NotCleared,
    /// There is no room for another kind of task.
    TooManyTasks,
}

/// A wheel, in the paper's order: A, B, C, D of Mecanum eq. 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Wheel {
    /// A.
    RearLeft,
    /// B.
    FrontLeft,
    /// C.
    FrontRight,
    /// D.
    RearRight,
}

/// What can be wrong with a chassis. The first three stop it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ChassisFault {
    /// A motor's driver reports a fault.
    Driver {
        /// Whose.
        wheel: Wheel,
    },
    /// A wheel turns and its encoder does not count.
    EncoderStuck {
        /// Whose.
        wheel: Wheel,
    },
    /// A wheel is driven and does not turn.
    Stalled {
        /// Which.
        wheel: Wheel,
    },
    /// The wheels contradict each other or the gyroscope: one slips. Odometry is less sure.
    Slipping,
    /// The gyroscope does not answer: the heading comes from the wheels alone.
    GyroSilent,
    /// The battery is not measured: what it holds is unknown or old.
    BatterySilent,
}

/// A battery.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BatteryState {
    /// At its terminals.
    pub voltage: VoltageV,
    /// What flows out of it.
    pub current: CurrentA,
    /// What it still holds (g_real).
    pub energy: EnergyJ,
}
