//! embassy's executors: one for the tasks, asleep while there is nothing to do, and one in an
//! interrupt above it.
//!
//! embassy's own for this core do the same with other instructions, which the emulators do not know:
//! they sleep by WFE, which QEMU takes for a busy wait (an idle board would keep a whole core of its
//! host busy), and raise the interrupt through the NVIC's STIR, which LabWired ignores. WFI and ISPR
//! do as well on the microcontroller, so that every image of every board has these executors.

use core::sync::atomic::{AtomicBool, AtomicPtr, Ordering};

use cortex_m::peripheral::NVIC;
use embassy_executor::{SendSpawner, Spawner, raw};
use pac::interrupt;
use stm32_metapac as pac;

/// Whether a task of the lower executor was woken since its tasks ran last.
static WOKEN: AtomicBool = AtomicBool::new(false);

/// The executor in the interrupt, null until it is started.
static ABOVE: AtomicPtr<raw::Executor> = AtomicPtr::new(core::ptr::null_mut());

/// Its interrupt: one that no device of the boards raises.
const INTERRUPT: pac::Interrupt = pac::Interrupt::CAN1_TX;

/// Below the clock and the UARTs (0), above the tasks: the upper four bits count.
const PRIORITY: u8 = 0x80;

/// What a waker's context says: which of the two executors.
const LOWER: *mut () = core::ptr::null_mut();
const UPPER: *mut () = core::ptr::without_provenance_mut(1);

/// embassy calls this when a task is woken.
#[unsafe(export_name = "__pender")]
fn on_wake(context: *mut ()) {
    if context == LOWER {
        WOKEN.store(true, Ordering::Release);
    } else {
        NVIC::pend(INTERRUPT);
    }
}

/// Runs the tasks that `start` spawns.
pub fn execute(start: impl FnOnce(Spawner)) -> ! {
    let Some(executor) = cortex_m::singleton!(: raw::Executor = raw::Executor::new(LOWER)) else {
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

/// Starts the executor whose tasks interrupt those of [`execute`].
pub fn execute_above(start: impl FnOnce(SendSpawner)) {
    let Some(executor) = cortex_m::singleton!(: raw::Executor = raw::Executor::new(UPPER)) else {
        defmt::panic!("the executor runs already");
    };
    ABOVE.store(executor, Ordering::Release);
    // Safety: nothing holds a critical section by masking this interrupt.
    unsafe {
        let mut core = cortex_m::Peripherals::steal();
        core.NVIC.set_priority(INTERRUPT, PRIORITY);
        NVIC::unmask(INTERRUPT);
    }
    let executor: &'static raw::Executor = executor;
    start(executor.spawner().make_send());
}

#[interrupt]
fn CAN1_TX() {
    // Safety: the executor is a static that is never moved; this interrupt does not interrupt
    // itself, so this is the only poll at a time.
    if let Some(executor) = unsafe { ABOVE.load(Ordering::Acquire).as_ref() } {
        unsafe { executor.poll() };
    }
}
