//! Sine and cosine in f32. Those of libm compute in f64, for which the Cortex-M4F has no
//! instructions: they cost a third of a control tick.
//!
//! The angle is brought to within an eighth of a turn by subtracting a multiple of a quarter, whose
//! constant is split in three. The first two parts have 8 and 11 bits, so that their multiples are
//! exact; on what is left, minimax polynomials are wrong by 2e-9. Rounding adds 2^-25 for each of two
//! subtractions and 2^-24 for the polynomial: [`LARGEST_ERROR`] in all.

use core::f32::consts::FRAC_2_PI;

/// What sine and cosine are wrong by at most, for an angle of up to [`LARGEST_ANGLE_RAD`].
pub const LARGEST_ERROR: f32 = f32::EPSILON;
/// Beyond this, in rad, the multiples of a quarter of a turn are no longer exact.
pub const LARGEST_ANGLE_RAD: f32 = 1e4;

/// A quarter of a turn is the sum of these.
const QUARTER: [f32; 3] = [1.570_312_5, 4.837_513e-4, 7.549_79e-8];
/// (sin(r) - r) / r³ as a polynomial in r².
const SINE: [f32; 3] = [-0.166_666_52, 8.332_035e-3, -1.950_128e-4];
/// (cos(r) - 1 + r² / 2) / r⁴ as a polynomial in r².
const COSINE: [f32; 3] = [0.041_666_653, -1.388_758_7e-3, 2.446_023e-5];

/// Sine and cosine of an angle in rad. Of what is no number they are none.
#[must_use]
pub fn sin_cos(angle: f32) -> (f32, f32) {
    let quarters = (angle * FRAC_2_PI + 0.5_f32.copysign(angle)) as i32;
    let whole = quarters as f32;
    let [high, middle, low] = QUARTER;
    let rest = ((angle - whole * high) - whole * middle) - whole * low;
    let square = rest * rest;
    let series = |[a, b, c]: [f32; 3]| a + square * (b + square * c);
    let sin = rest + rest * square * series(SINE);
    let cos = (1.0 - 0.5 * square) + square * square * series(COSINE);
    match quarters & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn error(angle: f32) -> f64 {
        let (sin, cos) = sin_cos(angle);
        let (true_sin, true_cos) = f64::from(angle).sin_cos();
        (f64::from(sin) - true_sin).abs().max((f64::from(cos) - true_cos).abs())
    }

    #[test]
    fn within_half_a_turn_the_error_is_within_its_bound() {
        // Every 401st number from 0 to pi, and its negative: 2.7 million each.
        let worst = (0..=core::f32::consts::PI.to_bits()).step_by(401).map(|bits| {
            let angle = f32::from_bits(bits);
            error(angle).max(error(-angle))
        });
        let worst = worst.fold(0.0, f64::max);
        println!("sine and cosine are wrong by {worst:e} at most");
        assert!(worst <= LARGEST_ERROR.into(), "{worst}");
    }

    #[test]
    fn the_quarters_are_exact_and_so_is_standing_still() {
        assert_eq!(sin_cos(0.0), (0.0, 1.0));
        for quarters in -6_000..=6_000 {
            let angle = quarters as f32 * core::f32::consts::FRAC_PI_2;
            assert!(error(angle) <= LARGEST_ERROR.into(), "{angle}");
        }
    }

    #[test]
    fn of_no_number_they_are_no_numbers_and_of_a_huge_one_nothing_breaks() {
        for angle in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let (sin, cos) = sin_cos(angle);
            assert!(sin.is_nan() && cos.is_nan());
        }
        let _ = (sin_cos(f32::MAX), sin_cos(f32::MIN));
    }

    proptest! {
        #[test]
        fn after_many_turns_the_error_is_within_its_bound(angle in -LARGEST_ANGLE_RAD..LARGEST_ANGLE_RAD) {
            prop_assert!(error(angle) <= LARGEST_ERROR.into());
        }
    }
}
