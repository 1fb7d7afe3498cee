//! embassy's executor, asleep while there is nothing to do.
//!
//! embassy's own for this core sleeps by WFE, which QEMU takes for a busy wait: an idle board would
//! keep a whole core of its host busy. QEMU does sleep by WFI.

use core::sync::atomic::{AtomicBool, Ordering};

use embassy_executor::{Spawner, raw};

/// Whether a task was woken since the tasks ran last.
static WOKEN: AtomicBool = AtomicBool::new(false);

/// embassy calls this when a task is woken.
#[unsafe(export_name = "__pender")]
fn on_wake(_context: *mut ()) {
    WOKEN.store(true, Ordering::Release);
}

/// Runs the tasks that `start` spawns.
pub fn execute(start: impl FnOnce(Spawner)) -> ! {
    let Some(executor) = cortex_m::singleton!(: raw::Executor = raw::Executor::new(core::ptr::null_mut()))
    else {
        defmt::panic!("the executor runs already");
    };
    let executor: &'static raw::Executor = executor;
    start(executor.spawner());
    loop {
        // Safety: this is the only call, never from an interrupt nor from a task.
        unsafe { executor.poll() };
        // With interrupts masked none can wake a task between the question and the sleep; a pending
        // one ends the sleep all the same, and is served when they are unmasked.
        cortex_m::interrupt::free(|_| {
            if !WOKEN.swap(false, Ordering::AcqRel) {
                cortex_m::asm::wfi();
            }
        });
    }
}
