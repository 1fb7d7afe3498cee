//! What control ticks cost: the core's cycles from the sensors' values to its command, whatever
//! interrupts in between.
//!
//! Under `-icount shift=0` an instruction takes one nanosecond, 0.168 of a cycle.

use core::sync::atomic::{AtomicU32, Ordering};

/// Instructions of a class of ticks that are counted together.
const CLASS: u32 = 32;
/// Classes; the last takes all ticks that cost more.
const CLASSES: usize = 512;

static TICKS: [AtomicU32; CLASSES] = [const { AtomicU32::new(0) }; CLASSES];
static WORST: AtomicU32 = AtomicU32::new(0);

/// The costs of all ticks since they were asked for last, in instructions.
pub(super) struct Costs {
    pub ticks: u32,
    pub median: u32,
    pub worst: u32,
}

/// The instructions that take so many cycles.
#[must_use]
pub const fn instructions(cycles: u32) -> u32 {
    cycles.saturating_mul(1_000) / 168
}

/// A tick has cost so many cycles.
pub fn record(cycles: u32) {
    let instructions = instructions(cycles);
    WORST.fetch_max(instructions, Ordering::Relaxed);
    let class = usize::try_from(instructions / CLASS).unwrap_or(CLASSES).min(CLASSES - 1);
    if let Some(ticks) = TICKS.get(class) {
        ticks.fetch_add(1, Ordering::Relaxed);
    }
}

/// Takes the costs; counting begins anew.
pub(super) fn take() -> Costs {
    let counts = TICKS.each_ref().map(|ticks| ticks.swap(0, Ordering::Relaxed));
    let ticks = counts.iter().sum();
    let mut below = 0;
    let median = counts.iter().position(|count| {
        below += count;
        2 * below >= ticks
    });
    let classes = median.and_then(|class| u32::try_from(class).ok()).unwrap_or(0);
    Costs { ticks, median: (classes + 1) * CLASS, worst: WORST.swap(0, Ordering::Relaxed) }
}
