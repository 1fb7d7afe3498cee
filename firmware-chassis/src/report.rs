//! The chassis' numbers as the quantities of the wire. They are in range unless the sensors tell
//! nonsense; then the nearest that is goes out, and never something that is no number.

use nalgebra::{Matrix3, Vector3};
use protocol::{
    AngleRad, CoordinateM, Covariance, PoseCovariance, SpeedMps, TurnRateRadps, Twist, TwistVariance,
};

use crate::{
    TICK_S,
    kinematics::Velocity,
    odometry::Pose,
    wheel::{POSITION_GAIN, SPEED_GAIN},
};

/// A velocity.
#[must_use]
pub fn twist(velocity: &Velocity) -> Twist {
    Twist {
        vx: SpeedMps::clamped(velocity.x),
        vy: SpeedMps::clamped(velocity.y),
        wz: TurnRateRadps::clamped(velocity.z),
    }
}

/// A pose.
#[must_use]
pub fn pose(pose: Pose) -> protocol::Pose {
    protocol::Pose {
        x: CoordinateM::clamped(pose.x),
        y: CoordinateM::clamped(pose.y),
        yaw: AngleRad::clamped(pose.yaw),
    }
}

/// The covariance of x, y and yaw.
#[must_use]
pub fn pose_covariance(matrix: &Matrix3<f32>) -> PoseCovariance {
    let at = |row, column| Covariance::clamped(matrix[(row, column)]);
    PoseCovariance {
        xx: at(0, 0),
        xy: at(0, 1),
        xyaw: at(0, 2),
        yy: at(1, 1),
        yyaw: at(1, 2),
        yawyaw: at(2, 2),
    }
}

/// The variances of a velocity.
#[must_use]
pub fn twist_variance(variance: &Vector3<f32>) -> TwistVariance {
    TwistVariance {
        vx: Covariance::clamped(variance.x),
        vy: Covariance::clamped(variance.y),
        wz: Covariance::clamped(variance.z),
    }
}

/// The variance of a wheel's estimated speed that the encoder's quantum leaves behind the observer,
/// in m²/s²: for an alpha-beta filter, 2 b² / (a (4 - 2a - b)) of the position's over the tick
/// squared.
#[must_use]
pub fn speed_variance(metres_per_count: f32) -> f32 {
    const KEPT: f32 =
        2.0 * SPEED_GAIN * SPEED_GAIN / (POSITION_GAIN * (4.0 - 2.0 * POSITION_GAIN - SPEED_GAIN));
    KEPT * metres_per_count * metres_per_count / 12.0 / (TICK_S * TICK_S)
}
