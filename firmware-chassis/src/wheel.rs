//! Distance and speed of a wheel, from its encoder's counts.
//!
//! The distance is exact: counts times metres a count, the counter's wrap included. The speed is
//! not counts over time, which at one count a tick would jump between nothing and twice the speed.
//! A [tracking observer](WheelObserver) follows the counts instead.

/// How much of the past the observer keeps each tick: the double pole of its filter. The gains
/// follow (critically damped): [`POSITION_GAIN`], [`SPEED_GAIN`].
///
/// At 0.7 the observer takes 12 ticks to 90 % of a step of speed, and leaves of the encoder's
/// quantisation a standard deviation of 10.5 quanta/s / sqrt(12), a thirteenth of what counts over
/// time would leave: 1.7 mm/s instead of 22 mm/s with the coarse encoder of
/// [`PAPER_LITERAL`](crate::parameters::Geometry::PAPER_LITERAL).
pub const MEMORY: f32 = 0.7;
/// 1 - memory².
pub const POSITION_GAIN: f32 = 1.0 - MEMORY * MEMORY;
/// (1 - memory)².
pub const SPEED_GAIN: f32 = (1.0 - MEMORY) * (1.0 - MEMORY);

/// Follows an encoder: predicts where the wheel is, and corrects place and speed by what the
/// counter says instead (an alpha-beta filter). The prediction knows the step of the set-point, so
/// that the estimate does not lag behind during a ramp.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WheelObserver {
    counter: Option<u16>,
    /// Where the counter says the wheel is, less where it is thought to be, in m.
    ahead_m: f32,
    speed_mps: f32,
}

impl WheelObserver {
    /// A wheel at rest whose counter is not known yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { counter: None, ahead_m: 0.0, speed_mps: 0.0 }
    }

    /// The estimated speed, in m/s.
    #[must_use]
    pub const fn speed_mps(&self) -> f32 {
        self.speed_mps
    }

    /// Takes the counter's value `elapsed_s` after the last one; `step_mps` is by how much the
    /// set-point has changed since. Answers how many counts the wheel has turned: less than half of
    /// the counter's range, or a full one is missed.
    pub fn update(&mut self, counter: u16, metres_per_count: f32, step_mps: f32, elapsed_s: f32) -> i16 {
        let before = self.counter.replace(counter).unwrap_or(counter);
        let counts = counter.wrapping_sub(before) as i16;
        let predicted_m = (self.speed_mps + 0.5 * step_mps) * elapsed_s;
        let ahead_m = self.ahead_m + f32::from(counts) * metres_per_count - predicted_m;
        self.speed_mps += step_mps + SPEED_GAIN * ahead_m / elapsed_s;
        self.ahead_m = (1.0 - POSITION_GAIN) * ahead_m;
        counts
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::{TICK_S, parameters::Geometry};

    /// An encoder on a wheel of any speed, and what the observer makes of it.
    struct Bench {
        observer: WheelObserver,
        metres_per_count: f32,
        position_m: f64,
        counter: u16,
    }

    impl Bench {
        fn new(geometry: Geometry, start: u16) -> Self {
            let metres_per_count = geometry.metres_per_count();
            let mut observer = WheelObserver::new();
            observer.update(start, metres_per_count, 0.0, TICK_S);
            Self { observer, metres_per_count, position_m: 0.0, counter: start }
        }

        /// A tick at `speed`; answers estimate and counts.
        fn roll(&mut self, speed: f32, step: f32) -> (f32, i16) {
            self.position_m += f64::from(speed) * f64::from(TICK_S);
            let count = (self.position_m / f64::from(self.metres_per_count)).floor();
            let counter = self.counter.wrapping_add(count as i64 as u16);
            let counts = self.observer.update(counter, self.metres_per_count, step, TICK_S);
            (self.observer.speed_mps(), counts)
        }

        /// Mean and standard deviation of the estimate and of counts over time, once settled.
        fn at(&mut self, speed: f32) -> [(f32, f32); 2] {
            for _ in 0..100 {
                self.roll(speed, 0.0);
            }
            let rolled: Vec<_> = (0..2_000).map(|_| self.roll(speed, 0.0)).collect();
            let naive = |counts: i16| f32::from(counts) * self.metres_per_count / TICK_S;
            let statistics = |values: Vec<f32>| {
                let mean = values.iter().sum::<f32>() / values.len() as f32;
                let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f32>();
                (mean, (variance / values.len() as f32).sqrt())
            };
            [
                statistics(rolled.iter().map(|(speed, _)| *speed).collect()),
                statistics(rolled.iter().map(|(_, counts)| naive(*counts)).collect()),
            ]
        }
    }

    #[test]
    fn around_one_count_a_tick_the_estimate_is_several_times_steadier_than_counts_over_time() {
        let mut worst = 0.0f32;
        for speed in [0.031, 0.043, 0.054, 0.067, 0.089] {
            let [(mean, deviation), (_, naive)] = Bench::new(Geometry::PAPER_LITERAL, 0).at(speed);
            assert!((mean - speed).abs() < 1e-3, "{speed}: {mean}");
            assert!(deviation <= naive / 3.0, "{speed}: {deviation} against {naive}");
            worst = worst.max(deviation);
        }
        // Derived in the docs of MEMORY for quantisation that is noise; near one count in two
        // ticks it is a rhythm that the filter damps less.
        assert!(worst < 0.006, "{worst}");
    }

    #[test]
    fn a_step_of_speed_is_known_within_12_ticks_by_nine_tenths() {
        let mut bench = Bench::new(Geometry::PAPER, 0);
        let estimates: Vec<f32> = (0..60).map(|_| bench.roll(0.5, 0.0).0).collect();
        let ninety = estimates.iter().position(|&estimate| estimate >= 0.45).unwrap() + 1;
        assert!((8..=12).contains(&ninety), "{ninety}");
        let peak = estimates.iter().fold(0.0f32, |peak, &estimate| peak.max(estimate));
        assert!(peak < 0.5 * 1.15, "{peak}");
        assert!((estimates[50] - 0.5).abs() < 0.002);
    }

    #[test]
    fn during_a_ramp_the_estimate_does_not_lag() {
        for geometry in [Geometry::PAPER, Geometry::PAPER_LITERAL] {
            let mut bench = Bench::new(geometry, 0);
            for tick in 1..=50_u8 {
                let speed = 0.01 * f32::from(tick);
                // The mean over the tick is half a step behind its end.
                let (estimate, _) = bench.roll(speed - 0.005, 0.01);
                assert!((estimate - speed).abs() < 0.012, "tick {tick}: {estimate} for {speed}");
            }
        }
    }

    proptest! {
        #[test]
        fn wherever_the_counter_wraps_nothing_is_seen_of_it(
            start: u16, speeds in prop::collection::vec(-1.5f32..1.5, 1..200),
        ) {
            let mut wrapping = Bench::new(Geometry::PAPER, start);
            let mut plain = Bench::new(Geometry::PAPER, 0x8000);
            for speed in speeds {
                prop_assert_eq!(wrapping.roll(speed, 0.0), plain.roll(speed, 0.0));
            }
        }

        #[test]
        fn no_counter_makes_the_estimate_something_that_is_no_number(
            counters in prop::collection::vec((any::<u16>(), 1..=100u8), 1..500),
        ) {
            let mut observer = WheelObserver::new();
            for (counter, ticks) in counters {
                observer.update(counter, 5.5e-4, 0.01, TICK_S * f32::from(ticks));
                prop_assert!(observer.speed_mps().abs() < 1e5);
            }
        }
    }
}
