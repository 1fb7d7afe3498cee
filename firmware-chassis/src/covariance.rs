//! How sure a place in the plane is.
//!
//! A covariance is symmetric, and what carries it on from tick to tick is nearly the identity: both
//! are used here, where products of whole matrices would cost five times as much.

use core::ops::Add;

/// The covariance of x, y and yaw: m², m rad and rad².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlaneCovariance {
    /// Of x with itself.
    pub xx: f32,
    /// Of x with y.
    pub xy: f32,
    /// Of x with yaw.
    pub xyaw: f32,
    /// Of y with itself.
    pub yy: f32,
    /// Of y with yaw.
    pub yyaw: f32,
    /// Of yaw with itself.
    pub yawyaw: f32,
}

impl PlaneCovariance {
    /// That of the same motion, seen from a frame in which its own is turned by an angle with this
    /// sine and cosine.
    #[must_use]
    pub fn turned(self, (sin, cos): (f32, f32)) -> Self {
        let Self { xx, xy, xyaw, yy, yyaw, yawyaw } = self;
        let (sin2, cos2, both) = (sin * sin, cos * cos, sin * cos);
        Self {
            xx: cos2 * xx - 2.0 * both * xy + sin2 * yy,
            xy: both * (xx - yy) + (cos2 - sin2) * xy,
            xyaw: cos * xyaw - sin * yyaw,
            yy: sin2 * xx + 2.0 * both * xy + cos2 * yy,
            yyaw: sin * xyaw + cos * yyaw,
            yawyaw,
        }
    }

    /// That of the place after a known motion by (x, y) m in the map's frame: an error of the yaw
    /// moves it aside by as much times that way.
    #[must_use]
    pub fn carried(self, (x, y): (f32, f32)) -> Self {
        let Self { xx, xy, xyaw, yy, yyaw, yawyaw } = self;
        let (new_xyaw, new_yyaw) = (xyaw - y * yawyaw, yyaw + x * yawyaw);
        Self {
            xx: xx - y * (xyaw + new_xyaw),
            xy: xy - y * new_yyaw + x * xyaw,
            xyaw: new_xyaw,
            yy: yy + x * (yyaw + new_yyaw),
            yyaw: new_yyaw,
            yawyaw,
        }
    }

    /// The same, no part of it beyond `largest`.
    #[must_use]
    pub fn clamped(self, largest: f32) -> Self {
        let Self { xx, xy, xyaw, yy, yyaw, yawyaw } = self;
        let [xx, xy, xyaw, yy, yyaw, yawyaw] =
            [xx, xy, xyaw, yy, yyaw, yawyaw].map(|value| value.clamp(-largest, largest));
        Self { xx, xy, xyaw, yy, yyaw, yawyaw }
    }
}

impl Add for PlaneCovariance {
    type Output = Self;

    /// That of a sum of two that have nothing to do with each other.
    fn add(self, other: Self) -> Self {
        Self {
            xx: self.xx + other.xx,
            xy: self.xy + other.xy,
            xyaw: self.xyaw + other.xyaw,
            yy: self.yy + other.yy,
            yyaw: self.yyaw + other.yyaw,
            yawyaw: self.yawyaw + other.yawyaw,
        }
    }
}

#[cfg(test)]
impl From<PlaneCovariance> for nalgebra::Matrix3<f32> {
    fn from(PlaneCovariance { xx, xy, xyaw, yy, yyaw, yawyaw }: PlaneCovariance) -> Self {
        Self::new(xx, xy, xyaw, xy, yy, yyaw, xyaw, yyaw, yawyaw)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;
    use proptest::prelude::*;

    use super::*;

    fn covariance() -> impl Strategy<Value = PlaneCovariance> {
        // Of any matrix times its transpose.
        prop::array::uniform9(-1.0f32..1.0).prop_map(|values| {
            let matrix = Matrix3::from_row_slice(&values);
            let [xx, xy, xyaw, _, yy, yyaw, _, _, yawyaw] =
                (matrix * matrix.transpose()).transpose().as_slice().try_into().unwrap();
            PlaneCovariance { xx, xy, xyaw, yy, yyaw, yawyaw }
        })
    }

    fn assert_close(by_parts: PlaneCovariance, by_matrices: Matrix3<f32>) -> Result<(), TestCaseError> {
        let difference = (Matrix3::from(by_parts) - by_matrices).amax();
        prop_assert!(difference <= 1e-5 * by_matrices.amax().max(1.0), "{by_parts:?} {by_matrices}");
        Ok(())
    }

    proptest! {
        #[test]
        fn turned_is_what_the_rotation_makes_of_it(before in covariance(), angle in -4.0f32..4.0) {
            let (sin, cos) = angle.sin_cos();
            let rotation = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
            assert_close(before.turned((sin, cos)), rotation * Matrix3::from(before) * rotation.transpose())?;
        }

        #[test]
        fn carried_is_what_the_derivative_of_the_pose_makes_of_it(
            before in covariance(), x in -1.0f32..1.0, y in -1.0f32..1.0,
        ) {
            let by_pose = Matrix3::new(1.0, 0.0, -y, 0.0, 1.0, x, 0.0, 0.0, 1.0);
            assert_close(before.carried((x, y)), by_pose * Matrix3::from(before) * by_pose.transpose())?;
        }
    }
}
