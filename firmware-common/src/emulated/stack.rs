//! How deep the stack has been: what is free of it is painted at the start.

use core::sync::atomic::{AtomicUsize, Ordering};

/// What an untouched word holds.
const PAINT: u32 = 0xA5A5_5A5A;
/// Words below the painter's own frame that it leaves alone.
const MARGIN: usize = 64;

unsafe extern "C" {
    /// The end of the variables, by cortex-m-rt.
    static mut __sheap: u32;
    /// Where the stack begins, growing down.
    static _stack_start: u32;
}

fn end_of_variables() -> *mut u32 {
    &raw mut __sheap
}

/// Paints what is free. Call it before anything else runs.
pub(super) fn paint() {
    let mut here = 0_u32;
    let mut word = end_of_variables();
    // Safety: between the variables and the painter's own frame lies RAM that nobody uses yet.
    unsafe {
        let end = (&raw mut here).sub(MARGIN);
        while word < end {
            word.write_volatile(PAINT);
            word = word.add(1);
        }
    }
}

/// The most bytes the stack has had so far, interrupts included.
pub fn deepest_stack() -> usize {
    let top = &raw const _stack_start;
    let mut word = end_of_variables().cast_const();
    // Safety: all of this is RAM; words of the stack may be read as numbers.
    unsafe {
        while word < top && word.read_volatile() == PAINT {
            word = word.add(1);
        }
    }
    top.addr() - word.addr()
}

/// Says in the log how deep the stack has been, if it was never deeper.
pub(super) fn tell() {
    static TOLD: AtomicUsize = AtomicUsize::new(0);
    let deepest = deepest_stack();
    if TOLD.fetch_max(deepest, Ordering::Relaxed) < deepest {
        defmt::info!("stack: {} bytes at the deepest so far", deepest);
    }
}
