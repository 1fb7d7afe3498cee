//! What a robot is seen to take for a metre, its mean and its spread, and for a second of standing and of work:
//! from its own reports.
//!
//! A configuration says what a robot takes; a worn battery, a load or a ramp say otherwise. Reports in
//! which the robot has moved are summed over stretches of `STRETCH_M`, each of which is one sample. The
//! configured value counts as `BELIEF` samples with a spread of `DOUBT`, and samples are forgotten
//! slowly, so that the estimate follows a robot that ages. What standing and working take is learned in the same
//! way, over `STAND_S` while the robot waits and over `WORK_S` while it works.

use protocol::{Activity, DurationMs, RobotState};

/// A sample is taken over this distance, in metres: over less, a battery meter's steps are seen.
const STRETCH_M: f64 = 10.0;
/// Between two reports a robot moves at least so far, in metres, or it counts as standing: what its work
/// takes is not what its way takes.
const MOVED_M: f64 = 0.05;
/// And no farther than this: else it was carried, or not heard for long.
const JUMP_M: f64 = 20.0;
/// How many samples the configured consumption counts for.
const BELIEF: f64 = 4.0;
/// The spread of the configured consumption, as a share of it.
const DOUBT: f64 = 0.15;
/// A sample of standing is taken over this time, in seconds.
const STAND_S: f64 = 10.0;
/// A sample of what its work takes, its ways included, is taken over this time, in seconds.
const WORK_S: f64 = 60.0;
/// Before it was seen to work, a robot is believed to take this share of what driving takes.
const WORKING: f64 = 0.8;
/// So many samples of its work count.
const WORKED: f64 = 10.0;
/// Before it was seen to stand, a robot is believed to take this share of what driving takes.
const STANDING: f64 = 0.5;
/// No more samples count: those before are forgotten little by little.
const REMEMBERED: f64 = 50.0;

/// What was seen of one robot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Consumption {
    samples: f64,
    mean: f64,
    /// The sum of the squared differences from the mean.
    squares: f64,
    stretch_m: f64,
    stretch_j: f64,
    standing: Power,
    working: Power,
}

/// What something takes for a second: the mean of samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Power {
    samples: f64,
    mean_w: f64,
    /// The sample that is being taken.
    passed_s: f64,
    taken_j: f64,
}

impl Power {
    /// So much was taken in so long; a sample is taken over `over_s`, and the last `remembered` count.
    fn learn(&mut self, passed: DurationMs, taken_j: f64, over_s: f64, remembered: f64) {
        self.passed_s += f64::from(passed.as_seconds());
        self.taken_j += taken_j;
        if self.passed_s >= over_s {
            self.samples = (self.samples + 1.0).min(remembered);
            self.mean_w += (self.taken_j / self.passed_s - self.mean_w) / self.samples;
            (self.passed_s, self.taken_j) = (0.0, 0.0);
        }
    }

    /// The estimate in watts, where `believed_w` counts as [`BELIEF`] samples.
    fn estimate_w(&self, believed_w: f64) -> f64 {
        (BELIEF * believed_w + self.samples * self.mean_w) / (BELIEF + self.samples)
    }
}

impl Consumption {
    /// Takes two reports of which the second came so much later.
    pub fn learn(&mut self, before: &RobotState, after: &RobotState, passed: DurationMs) {
        let metres = |one: protocol::CoordinateM, other: protocol::CoordinateM| {
            f64::from(other.get()) - f64::from(one.get())
        };
        let (from, to) = (before.position, after.position);
        let moved_m = metres(from.x, to.x).hypot(metres(from.y, to.y));
        let taken_j = f64::from(before.energy.get()) - f64::from(after.energy.get());
        let both = |activity| [before, after].iter().all(|report| report.activity == activity);
        if both(Activity::Working) && taken_j >= 0.0 && moved_m <= JUMP_M {
            self.working.learn(passed, taken_j, WORK_S, WORKED);
        }
        if moved_m < MOVED_M {
            if both(Activity::Waiting) && taken_j >= 0.0 {
                self.standing.learn(passed, taken_j, STAND_S, REMEMBERED);
            }
            return;
        }
        if moved_m > JUMP_M || taken_j < 0.0 {
            // It was charged or carried.
            (self.stretch_m, self.stretch_j) = (0.0, 0.0);
            return;
        }
        self.stretch_m += moved_m;
        self.stretch_j += taken_j;
        if self.stretch_m >= STRETCH_M {
            self.add(self.stretch_j / self.stretch_m);
            (self.stretch_m, self.stretch_j) = (0.0, 0.0);
        }
    }

    /// What its work takes with all ways to it, in watts, of a robot whose configuration says what a metre
    /// takes and how fast it drives.
    #[must_use]
    pub fn working_w(&self, configured: f32, speed_mps: f32) -> f64 {
        self.working.estimate_w(WORKING * f64::from(configured) * f64::from(speed_mps))
    }

    /// What standing takes, in watts, of a robot whose configuration says what a metre takes and how fast it
    /// drives.
    #[must_use]
    pub fn standing_w(&self, configured: f32, speed_mps: f32) -> f64 {
        self.standing.estimate_w(STANDING * f64::from(configured) * f64::from(speed_mps))
    }

    /// One sample more, in joules a metre (Welford's method).
    fn add(&mut self, sample: f64) {
        if self.samples >= REMEMBERED {
            self.squares *= (REMEMBERED - 1.0) / REMEMBERED;
            self.samples = REMEMBERED - 1.0;
        }
        self.samples += 1.0;
        let off = sample - self.mean;
        self.mean += off / self.samples;
        self.squares += off * (sample - self.mean);
    }

    /// The mean and the spread (one standard deviation) of what a metre takes, in joules, of a robot whose
    /// configuration says `configured`.
    #[must_use]
    pub fn estimate(&self, configured: f32) -> (f64, f64) {
        let believed = f64::from(configured);
        let all = BELIEF + self.samples;
        let mean = (BELIEF * believed + self.samples * self.mean) / all;
        let off = self.mean - believed;
        let doubt = DOUBT * believed;
        let squares = BELIEF * doubt * doubt + self.squares + off * off * BELIEF * self.samples / all;
        (mean, (squares / all).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use protocol::{Activity, CoordinateM, EnergyJ, Position};

    use super::*;

    const SECOND: DurationMs = DurationMs(1_000);

    fn report(x_m: f64, energy_j: f64) -> RobotState {
        let position = Position { x: CoordinateM::clamped(x_m as f32), y: CoordinateM::clamped(0.0) };
        let energy = EnergyJ::clamped(energy_j as f32);
        RobotState { position, energy, activity: Activity::Working, accepted: None }
    }

    fn driven(metres: usize, per_metre_j: impl Fn(usize) -> f64) -> Consumption {
        let mut consumption = Consumption::default();
        let mut energy_j = 400_000.0;
        for metre in 0..metres {
            let before = report(metre as f64, energy_j);
            energy_j -= per_metre_j(metre);
            consumption.learn(&before, &report(metre as f64 + 1.0, energy_j), SECOND);
        }
        consumption
    }

    #[test]
    fn an_unknown_robot_takes_what_its_configuration_says_give_or_take() {
        assert_eq!(Consumption::default().estimate(100.0), (100.0, 15.0));
    }

    #[test]
    fn a_robot_that_takes_more_than_it_should_is_believed_to_after_a_while() {
        let (mean, spread) = driven(300, |_| 130.0).estimate(100.0);
        assert!((126.0..=130.0).contains(&mean) && spread < 13.0, "{mean} {spread}");
        let (longer, surer) = driven(480, |_| 130.0).estimate(100.0);
        assert!(longer > mean && surer < spread);
    }

    #[test]
    fn a_robot_that_takes_now_more_now_less_is_never_sure() {
        let uneven = driven(400, |metre| if metre / 10 % 2 == 0 { 70.0 } else { 130.0 });
        let (mean, spread) = uneven.estimate(100.0);
        assert!((mean - 100.0).abs() < 1.0 && (25.0..35.0).contains(&spread), "{mean} {spread}");
    }

    #[test]
    fn work_charges_and_jumps_are_no_drives() {
        let mut consumption = Consumption::default();
        for (before, after) in
            [((0.0, 900.0), (0.01, 100.0)), ((0.0, 100.0), (5.0, 900.0)), ((0.0, 900.0), (500.0, 100.0))]
        {
            for _ in 0..10 {
                consumption.learn(&report(before.0, before.1), &report(after.0, after.1), SECOND);
            }
        }
        assert_eq!(consumption.estimate(100.0), Consumption::default().estimate(100.0));
    }

    #[test]
    fn what_standing_takes_is_learned_while_a_robot_waits_and_believed_before() {
        let mut consumption = Consumption::default();
        assert_eq!(consumption.standing_w(100.0, 0.5), 25.0);
        let stand = |consumption: &mut Consumption, activity| {
            for second in 0..600 {
                let at = |second: i32| RobotState { activity, ..report(0.0, 9e4 - 10.0 * f64::from(second)) };
                consumption.learn(&at(second), &at(second + 1), SECOND);
            }
        };
        stand(&mut consumption, Activity::Working);
        assert_eq!(consumption.standing_w(100.0, 0.5), 25.0, "its work takes more");
        stand(&mut consumption, Activity::Waiting);
        let standing_w = consumption.standing_w(100.0, 0.5);
        assert!((10.0..12.0).contains(&standing_w), "{standing_w}");
    }

    #[test]
    fn an_old_robot_is_known_as_it_is_now() {
        let aged = driven(2_000, |metre| if metre < 1_000 { 60.0 } else { 30.0 });
        let (mean, _) = aged.estimate(60.0);
        assert!(mean < 37.0, "{mean}");
    }
}
