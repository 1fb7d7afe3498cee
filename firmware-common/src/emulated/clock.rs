//! SysTick as embassy's clock, since QEMU's timers raise no compare interrupts.

use core::cell::RefCell;
use core::task::Waker;

use cortex_m::peripheral::SYST;
use cortex_m_rt::exception;
use critical_section::Mutex;
use embassy_time_driver::{Driver, TICK_HZ};
use embassy_time_queue_utils::Queue;
use protocol::DurationMs;
use systick_timer::Timer;

use super::watchdog;

/// SysTick's frequency in QEMU's machine: that of the F407's core clock.
const SYSTICK_HZ: u32 = 168_000_000;

/// SysTick periods a second; timers are late by one period at most. As long as the control loop of
/// a chassis allows: a period that passes while the host does not run the emulator is lost to the
/// clock.
const PERIODS_HZ: u32 = 100;

struct SysTickClock {
    counter: Timer,
    /// The crate's own driver keeps one slot for every wake-up time that was ever asked for and
    /// panics when they run out; this queue keeps one entry a task.
    wakers: Mutex<RefCell<Queue>>,
}

embassy_time_driver::time_driver_impl!(static CLOCK: SysTickClock = SysTickClock {
    counter: Timer::new(TICK_HZ, SYSTICK_HZ / PERIODS_HZ - 1, SYSTICK_HZ as u64),
    wakers: Mutex::new(RefCell::new(Queue::new())),
});

impl Driver for SysTickClock {
    fn now(&self) -> u64 {
        self.counter.now()
    }

    fn schedule_wake(&self, at: u64, waker: &Waker) {
        critical_section::with(|token| {
            // SysTick fires in every period anyway: there is no alarm to move.
            let _ = self.wakers.borrow_ref_mut(token).schedule_wake(at, waker);
        });
    }
}

/// Starts the clock.
pub(super) fn start(syst: &mut SYST) {
    CLOCK.counter.start(syst);
}

/// Cycles of the core since `start`, which [`SYST::get_current`] gave, if they are fewer than a
/// period's. Under `-icount shift=0` an instruction takes a nanosecond: 0.168 of a cycle.
pub fn elapsed_cycles(start: u32) -> u32 {
    let now = SYST::get_current();
    // It counts down.
    start.checked_sub(now).unwrap_or(start + SYST::get_reload() + 1 - now)
}

#[exception]
fn SysTick() {
    CLOCK.counter.systick_handler();
    watchdog::tick(DurationMs(1_000 / PERIODS_HZ));
    let now = CLOCK.now();
    critical_section::with(|token| {
        let _ = CLOCK.wakers.borrow_ref_mut(token).next_expiration(now);
    });
}
