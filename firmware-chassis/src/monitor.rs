//! What is wrong with the chassis, and how it is noticed.
//!
//! | fault | noticed when | goes when |
//! |---|---|---|
//! | driver | the motor's driver says so | it no longer does |
//! | wheel stalled | a wheel is pushed for [`PUSHED_TICKS`] without a count, and draws the current of a motor that stands | released |
//! | encoder stuck | the same, but it draws less than half of that | released |
//! | slipping | the wheels contradict each other, or the gyroscope, by [`SLIP_MPS`] for [`SLIP_TICKS`] | they agree for [`GRIP_TICKS`] |
//! | gyroscope, battery silent | no sensible sample for 0.2 s, 1 s | the next one |
//!
//! A wheel is pushed if its duty would surely turn a free one ([`PUSH_DUTY`] above friction). The
//! integral of the control sees to it that a wheel that does not follow is pushed sooner or later.

use heapless::Vec;
use protocol::{ChassisFault, StopReason, Wheel, limits::CHASSIS_FAULTS};

use crate::parameters::{Motor, Pack};

/// A free wheel turns at this duty above what friction eats.
pub const PUSH_DUTY: f32 = 0.1;
/// A pushed wheel has counted by then: 0.25 s, three time constants of its motor.
pub const PUSHED_TICKS: u16 = 25;
/// A contradiction between wheels, or between them and the gyroscope at the wheels, that
/// is a slip, in m/s: above what control leaves between wheels of unlike friction.
pub const SLIP_MPS: f32 = 0.05;
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
    /// Whether its encoder has counted.
    pub counted: bool,
    /// Whether its driver reports a fault.
    pub driver_fault: bool,
}

/// What is wrong, and what is about to be.
#[derive(Clone, Debug, Default)]
pub struct Monitor {
    pushed: [u16; 4],
    held: [Option<StopReason>; 4],
    driver: [bool; 4],
    contradicted: u16,
    agreed: u16,
    slipping: bool,
}

impl Monitor {
    /// All is well.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            pushed: [0; 4],
            held: [None; 4],
            driver: [false; 4],
            contradicted: 0,
            agreed: 0,
            slipping: false,
        }
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
        let samples = wheels.iter().zip(&mut self.pushed).zip(&mut self.held);
        for ((wheel, pushed), held) in samples {
            let is_pushed = wheel.duty.abs() >= motor.friction_duty + PUSH_DUTY;
            *pushed = if is_pushed && !wheel.counted { pushed.saturating_add(1) } else { 0 };
            if *pushed >= PUSHED_TICKS && held.is_none() {
                // Of the supply's current a motor takes its own times the duty.
                let standing_a = wheel.duty * wheel.duty * motor.stall_current_a;
                let turns = current_a.is_some_and(|current| current - pack.idle_a < 0.5 * standing_a);
                *held = Some(if turns { StopReason::EncoderStuck } else { StopReason::WheelStalled });
            }
        }
        self.driver = wheels.map(|wheel| wheel.driver_fault);
        self.stop()
    }

    /// Takes by how much the wheels contradict each other and the gyroscope, in m/s at the wheels.
    pub fn check_grip(&mut self, contradiction_mps: f32) {
        if contradiction_mps > SLIP_MPS {
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
        self.pushed = [0; 4];
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
    const ROLLING: WheelSample = WheelSample { duty: 0.5, counted: true, driver_fault: false };
    const STILL: WheelSample = WheelSample { counted: false, ..ROLLING };

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
        // Half the duty of 3.2 A: a standing motor takes 0.8 A from the battery, beside 0.5 A.
        assert_eq!(pushed_in_vain(Some(1.3)), Some(StopReason::WheelStalled));
        assert_eq!(pushed_in_vain(Some(0.7)), Some(StopReason::EncoderStuck));
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
            assert_eq!(check(&mut monitor, WheelSample { duty: 0.15, ..STILL }, None), None);
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
            monitor.check_grip(0.06);
            assert!(!monitor.is_slipping());
        }
        monitor.check_grip(0.06);
        assert!(monitor.is_slipping());
        for _ in 1..GRIP_TICKS {
            monitor.check_grip(0.0);
            assert!(monitor.is_slipping());
        }
        monitor.check_grip(0.0);
        assert!(!monitor.is_slipping());
    }
}
