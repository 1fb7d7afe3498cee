//! The chassis' numbers as the quantities of the wire. They are in range unless the sensors tell
//! nonsense; then the nearest that is goes out, and never something that is no number.

use nalgebra::Vector3;
use protocol::{
    AngleRad, CoordinateM, Covariance, PoseCovariance, SpeedMps, TurnRateRadps, Twist, TwistVariance,
};

use crate::{
    TICK_S,
    covariance::PlaneCovariance,
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

/// The covariance of a pose.
#[must_use]
pub fn pose_covariance(covariance: &PlaneCovariance) -> PoseCovariance {
    let PlaneCovariance { xx, xy, xyaw, yy, yyaw, yawyaw } = *covariance;
    PoseCovariance {
        xx: Covariance::clamped(xx),
        xy: Covariance::clamped(xy),
        xyaw: Covariance::clamped(xyaw),
        yy: Covariance::clamped(yy),
        yyaw: Covariance::clamped(yyaw),
        yawyaw: Covariance::clamped(yawyaw),
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
