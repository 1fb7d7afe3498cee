//! A watchdog in SysTick, since QEMU's machine has no IWDG that counts. It resets the machine as the
//! real one would; SysTick's interrupt is above all others.

use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicU32, Ordering};

use protocol::DurationMs;

use super::stack;
use crate::{supervisor, tasks::Watchdog};

/// Not fed for this long, it resets the machine.
const TIMEOUT: DurationMs = DurationMs(3 * supervisor::PERIOD.0);

/// What is left until then; nothing before it is fed for the first time.
static LEFT_MS: AtomicU32 = AtomicU32::new(u32::MAX);

/// Survives the reset; random after power-on, so it must hold all of [`RESET_BY_WATCHDOG`].
#[unsafe(link_section = ".uninit.watchdog")]
static mut CAUSE: MaybeUninit<u32> = MaybeUninit::uninit();
const RESET_BY_WATCHDOG: u32 = 0x0D06_B17E;

/// Resets the machine unless it is fed.
pub struct EmulatedWatchdog {
    was_cause: bool,
}

impl EmulatedWatchdog {
    pub(super) fn new() -> Self {
        let cause = &raw mut CAUSE;
        // Safety: a word of RAM that nobody else touches before the clock runs; any value of it is
        // a u32, and volatile reads take it as it is.
        let was_cause = unsafe {
            let was = cause.cast::<u32>().read_volatile() == RESET_BY_WATCHDOG;
            cause.cast::<u32>().write_volatile(0);
            was
        };
        Self { was_cause }
    }

    /// Whether it caused the reset before this start.
    pub const fn was_cause_of_start(&self) -> bool {
        self.was_cause
    }
}

impl Watchdog for EmulatedWatchdog {
    fn feed(&mut self) {
        stack::tell();
        LEFT_MS.store(TIMEOUT.0, Ordering::Release);
    }
}

/// Time has passed.
pub(super) fn tick(passed: DurationMs) {
    let left = LEFT_MS.load(Ordering::Acquire);
    match left {
        u32::MAX => {}
        0 => {
            // Safety: this interrupt is above all others, so nobody else is at it.
            unsafe { (&raw mut CAUSE).cast::<u32>().write_volatile(RESET_BY_WATCHDOG) };
            cortex_m::peripheral::SCB::sys_reset()
        }
        left => LEFT_MS.store(left.saturating_sub(passed.0), Ordering::Release),
    }
}
