//! The turn rate, its bias taken out.
//!
//! A gyroscope at rest shows a rate of its own, which drifts slowly. While the wheels stand still
//! it is averaged; while they turn it is taken out. Until it is known, no rate is given: the wheels
//! alone are better than a rate with an unknown bias.

/// The wheels must have stood still for so many ticks before a sample counts as the bias.
const SETTLING_TICKS: u16 = 20;
/// So many samples make a bias known.
pub const KNOWN_AFTER: u16 = 50;
/// The bias is the mean of about so many samples: later ones weigh as the last of these.
const WINDOW: u16 = 500;
/// No gyroscope has more bias: a higher rate at rest is a robot being turned by hand, in rad/s.
const LARGEST_BIAS_RADPS: f32 = 0.2;
/// A known bias does not jump by more, in rad/s.
const LARGEST_DRIFT_RADPS: f32 = 0.03;
/// More is no rate of this sensor (2000 degrees a second), in rad/s.
const RANGE_RADPS: f32 = 35.0;
/// So many ticks without a rate are a fault.
const SILENT_TICKS: u16 = 20;

/// A gyroscope's bias, and whether it is heard.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gyro {
    bias_radps: f32,
    samples: u16,
    still: u16,
    unheard: u16,
}

impl Gyro {
    /// A gyroscope whose bias is not known.
    #[must_use]
    pub const fn new() -> Self {
        Self { bias_radps: 0.0, samples: 0, still: 0, unheard: 0 }
    }

    /// The bias, once it is known, in rad/s.
    #[must_use]
    pub fn bias_radps(&self) -> Option<f32> {
        (self.samples >= KNOWN_AFTER).then_some(self.bias_radps)
    }

    /// Whether it has not answered, or nonsense, for 0.2 s.
    #[must_use]
    pub const fn is_silent(&self) -> bool {
        self.unheard >= SILENT_TICKS
    }

    /// Takes a tick's sample and whether the wheels `rest`. Answers the rate without its bias.
    pub fn update(&mut self, rate_radps: Option<f32>, rest: bool) -> Option<f32> {
        self.still = if rest { self.still.saturating_add(1) } else { 0 };
        let Some(rate) = rate_radps.filter(|rate| rate.abs() <= RANGE_RADPS) else {
            self.unheard = self.unheard.saturating_add(1);
            return None;
        };
        self.unheard = 0;
        let is_bias = match self.bias_radps() {
            Some(bias) => (rate - bias).abs() <= LARGEST_DRIFT_RADPS,
            None => rate.abs() <= LARGEST_BIAS_RADPS,
        };
        if self.still > SETTLING_TICKS && is_bias {
            self.samples = (self.samples + 1).min(WINDOW);
            self.bias_radps += (rate - self.bias_radps) / f32::from(self.samples);
        }
        self.bias_radps().map(|bias| rate - bias)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rested(bias: f32) -> Gyro {
        let mut gyro = Gyro::new();
        for tick in 0..100 {
            let ripple = if tick % 2 == 0 { 0.002 } else { -0.002 };
            gyro.update(Some(bias + ripple), true);
        }
        gyro
    }

    #[test]
    fn the_bias_is_learned_at_rest_and_taken_out() {
        let mut gyro = rested(0.05);
        assert!((gyro.bias_radps().unwrap() - 0.05).abs() < 1e-4);
        assert!((gyro.update(Some(1.05), false).unwrap() - 1.0).abs() < 1e-4);
    }

    #[test]
    fn nothing_is_learned_while_the_wheels_turn_or_have_just_stopped() {
        let mut gyro = Gyro::new();
        for tick in 0..1_000 {
            assert_eq!(gyro.update(Some(0.05), tick % 21 != 0), None);
        }
    }

    #[test]
    fn a_robot_turned_by_hand_is_not_a_bias() {
        let mut gyro = rested(0.05);
        for _ in 0..200 {
            gyro.update(Some(0.15), true);
        }
        assert!((gyro.bias_radps().unwrap() - 0.05).abs() < 1e-3);
    }

    #[test]
    fn nonsense_is_silence() {
        let mut gyro = rested(0.0);
        for nonsense in [f32::NAN, f32::INFINITY, -40.0] {
            for _ in 0..SILENT_TICKS {
                assert_eq!(gyro.update(Some(nonsense), false), None);
            }
            assert!(gyro.is_silent());
            assert!(gyro.update(Some(0.5), false).is_some());
            assert!(!gyro.is_silent());
        }
    }
}
