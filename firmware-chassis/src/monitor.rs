//! What is wrong with the chassis, and how it is noticed.
//!
//! | fault | noticed when | goes when |
//! |---|---|---|
//! | driver | the motor's driver says so | it no longer does |
//! | wheel stalled | a wheel is pushed for [`PUSHED_TICKS`] without a count, and draws the current of a motor that stands, or the current is not known | released |
//! | encoder stuck | the same, but it draws the current of a motor that turns | released |
//! | slipping | the wheels contradict each other by [`SLIP_MPS`], or the gyroscope by [`TURN_SLIP_MPS`], for [`SLIP_TICKS`] | they agree for [`GRIP_TICKS`] |
//! | gyroscope, battery silent | no sensible sample for 0.2 s, 1 s | the next one |
//!
//! Only the battery's current is measured. What the other wheels draw by the model of their motors is
//! taken from it, and the rest compared with the middle between what this wheel draws if it stands
//! and if it turns, over all ticks in which it is pushed.
//!
//! A wheel is pushed if its duty would surely turn a free one ([`PUSH_DUTY`] above friction). The
//! integral of the control sees to it that a wheel that does not follow is pushed sooner or later.

use heapless::Vec;
use protocol::{ChassisFault, StopReason, Wheel, limits::CHASSIS_FAULTS};

use crate::parameters::{Motor, Pack};

/// A free wheel turns at this duty above what friction eats.
pub const PUSH_DUTY: f32 = 0.2;
/// A pushed wheel has counted by then: 0.25 s, three time constants of its motor.
pub const PUSHED_TICKS: u16 = 25;
/// Wheels that contradict each other by this slip, in m/s: it is above what control leaves between
/// wheels of unlike friction.
pub const SLIP_MPS: f32 = 0.05;
/// So do wheels whose turn, at their lever arm, is by this unlike the gyroscope's, in m/s: a wheel
/// that loses a sixth of 0.5 m/s.
pub const TURN_SLIP_MPS: f32 = 0.02;
/// For so many ticks.
pub const SLIP_TICKS: u16 = 5;
/// So many ticks without one, and the wheels have grip again.
pub const GRIP_TICKS: u16 = 50;

/// The wheels in the order of every array.
pub const WHEELS: [Wheel; 4] = [Wheel::RearLeft, Wheel::FrontLeft, Wheel::FrontRight, Wheel::RearRight];

/// What a tick has to say of a wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelSample {
    /// The duty during the tick.
    pub duty: f32,
    /// Its speed, in m/s.
    pub speed_mps: f32,
    /// Whether its encoder has counted.
    pub counted: bool,
    /// Whether its driver reports a fault.
    pub driver_fault: bool,
}

impl WheelSample {
    /// What it draws from the battery by the model of its motor, in A: a driver passes on the
    /// share of the motor's current that its duty is.
    fn model_a(&self, motor: &Motor) -> f32 {
        (self.duty * (self.duty - self.speed_mps / motor.free_speed_mps) * motor.stall_current_a).max(0.0)
    }
}

/// A wheel that is pushed and does not count.
#[derive(Clone, Copy, Debug, Default)]
struct Pushed {
    ticks: u16,
    /// The sum of the currents that speak for a wheel that stands, less those against, in A.
    for_standing_a: f32,
}

/// What is wrong, and what is about to be.
#[derive(Clone, Debug, Default)]
pub struct Monitor {
    pushed: [Pushed; 4],
    held: [Option<StopReason>; 4],
    driver: [bool; 4],
    contradicted: u16,
    agreed: u16,
    slipping: bool,
}

impl Monitor {
    /// All is well.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes a tick's samples and the battery's current, if known. Answers why the chassis has to
    /// brake, if it has to.
    pub fn check(
        &mut self,
        wheels: [WheelSample; 4],
        current_a: Option<f32>,
        motor: &Motor,
        pack: &Pack,
    ) -> Option<StopReason> {
        let model_a = wheels.map(|wheel| wheel.model_a(motor));
        let all_a: f32 = model_a.iter().sum();
        for (((wheel, model_a), pushed), held) in
            wheels.iter().zip(model_a).zip(&mut self.pushed).zip(&mut self.held)
        {
            if wheel.counted || wheel.duty.abs() < motor.friction_duty + PUSH_DUTY {
                *pushed = Pushed::default();
                continue;
            }
            // What is left of the measured current when the others have theirs.
            let own_a = current_a.map(|current| current - pack.idle_a - (all_a - model_a));
            let turning_a = wheel.duty.abs() * motor.friction_duty * motor.stall_current_a;
            let halfway_a = 0.5 * (model_a + turning_a);
            pushed.ticks = pushed.ticks.saturating_add(1);
            pushed.for_standing_a += own_a.map_or(halfway_a, |own| own - halfway_a);
            if pushed.ticks >= PUSHED_TICKS && held.is_none() {
                let stands = pushed.for_standing_a >= 0.0;
                *held = Some(if stands { StopReason::WheelStalled } else { StopReason::EncoderStuck });
            }
        }
        self.driver = wheels.map(|wheel| wheel.driver_fault);
        self.stop()
    }

    /// Takes by how much the wheels contradict each other, and the gyroscope at their lever arm, in
    /// m/s.
    pub fn check_grip(&mut self, slip_mps: f32, turn_mps: f32) {
        if slip_mps.abs() > SLIP_MPS || turn_mps.abs() > TURN_SLIP_MPS {
            self.contradicted = self.contradicted.saturating_add(1);
            self.agreed = 0;
        } else {
            self.agreed = self.agreed.saturating_add(1);
            self.contradicted = 0;
        }
        self.slipping = match self.slipping {
            true => self.agreed < GRIP_TICKS,
            false => self.contradicted >= SLIP_TICKS,
        };
    }

    /// Whether a wheel slips.
    #[must_use]
    pub const fn is_slipping(&self) -> bool {
        self.slipping
    }

    /// Why the chassis must not drive.
    #[must_use]
    pub fn stop(&self) -> Option<StopReason> {
        if self.driver.contains(&true) {
            return Some(StopReason::DriverFault);
        }
        self.held.iter().flatten().next().copied()
    }

    /// Forgets what only a new try can clear. Whether all is clear now.
    pub fn release(&mut self) -> bool {
        self.pushed = Default::default();
        self.held = [None; 4];
        self.stop().is_none()
    }

    /// What is wrong now.
    #[must_use]
    pub fn faults(&self, gyro_silent: bool, battery_silent: bool) -> Vec<ChassisFault, CHASSIS_FAULTS> {
        let mut faults = Vec::new();
        // It fits: there is room for every fault.
        let mut add = |there: bool, fault| there.then(|| faults.push(fault));
        for ((wheel, driver), held) in WHEELS.into_iter().zip(self.driver).zip(self.held) {
            add(driver, ChassisFault::Driver { wheel });
            add(held == Some(StopReason::EncoderStuck), ChassisFault::EncoderStuck { wheel });
            add(held == Some(StopReason::WheelStalled), ChassisFault::Stalled { wheel });
        }
        add(self.slipping, ChassisFault::Slipping);
        add(gyro_silent, ChassisFault::GyroSilent);
        add(battery_silent, ChassisFault::BatterySilent);
        faults
    }
}

#[cfg(test)]
mod tests {
    use protocol::RobotId;

    use super::*;
    use crate::parameters::Parameters;

    const ROBOT: Parameters = Parameters::new(RobotId(1));
    const ROLLING: WheelSample =
        WheelSample { duty: 0.5, speed_mps: 0.44 * 1.34, counted: true, driver_fault: false };
    const STILL: WheelSample = WheelSample { speed_mps: 0.0, counted: false, ..ROLLING };

    fn check(monitor: &mut Monitor, front_left: WheelSample, current: Option<f32>) -> Option<StopReason> {
        monitor.check([ROLLING, front_left, ROLLING, ROLLING], current, &ROBOT.motor, &ROBOT.pack)
    }

    /// The stop after a wheel was pushed in vain with this current.
    fn pushed_in_vain(current: Option<f32>) -> Option<StopReason> {
        let mut monitor = Monitor::new();
        for _ in 1..PUSHED_TICKS {
            assert_eq!(check(&mut monitor, STILL, current), None);
        }
        check(&mut monitor, STILL, current)
    }

    #[test]
    fn a_pushed_wheel_that_does_not_count_is_stalled_or_its_encoder_stuck_by_its_current() {
        // At half the duty a motor of 3.2 A takes 0.8 A if it stands, 0.096 A if it turns; beside it
        // 0.5 A for all else and three that turn.
        let others = 0.5 + 3.0 * 0.096;
        assert_eq!(pushed_in_vain(Some(others + 0.8)), Some(StopReason::WheelStalled));
        assert_eq!(pushed_in_vain(Some(others + 0.6)), Some(StopReason::WheelStalled));
        assert_eq!(pushed_in_vain(Some(others + 0.3)), Some(StopReason::EncoderStuck));
        assert_eq!(pushed_in_vain(Some(others + 0.096)), Some(StopReason::EncoderStuck));
        // Unknown: the worse of the two.
        assert_eq!(pushed_in_vain(None), Some(StopReason::WheelStalled));
    }

    #[test]
    fn a_count_now_and_then_is_a_slow_wheel_and_no_fault() {
        let mut monitor = Monitor::new();
        for tick in 0..1_000 {
            let wheel = if tick % PUSHED_TICKS == 0 { ROLLING } else { STILL };
            assert_eq!(check(&mut monitor, wheel, None), None);
        }
        for _ in 0..1_000 {
            assert_eq!(check(&mut monitor, WheelSample { duty: 0.25, ..STILL }, None), None);
        }
    }

    #[test]
    fn a_driver_s_fault_stops_at_once_and_clears_only_with_its_cause() {
        let mut monitor = Monitor::new();
        let fault = WheelSample { driver_fault: true, ..ROLLING };
        assert_eq!(check(&mut monitor, fault, None), Some(StopReason::DriverFault));
        assert_eq!(monitor.faults(false, false), [ChassisFault::Driver { wheel: Wheel::FrontLeft }]);
        assert!(!monitor.release());
        assert_eq!(check(&mut monitor, ROLLING, None), None);
        assert!(monitor.release());
    }

    #[test]
    fn a_slip_begins_and_ends_after_its_ticks() {
        let mut monitor = Monitor::new();
        for _ in 1..SLIP_TICKS {
            monitor.check_grip(-0.06, 0.0);
            assert!(!monitor.is_slipping());
        }
        monitor.check_grip(0.0, -0.03);
        assert!(monitor.is_slipping());
        for _ in 1..GRIP_TICKS {
            monitor.check_grip(0.04, 0.01);
            assert!(monitor.is_slipping());
        }
        monitor.check_grip(0.04, 0.01);
        assert!(!monitor.is_slipping());
    }
}
