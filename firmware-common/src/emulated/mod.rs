//! The machine that QEMU emulates (`-M olimex-stm32-h405`): UARTs, SysTick as the clock, a watchdog.
//!
//! It has the USARTs, SysTick and NVIC of an STM32F407, but no clock tree: nothing here may wait for
//! the RCC, PWR or FLASH peripherals to become ready. A panic or a hard fault ends the emulator with
//! a failure, so that neither looks like a silent board.

pub mod bench;
mod clock;
pub mod cost;
mod flash;
mod stack;
mod uart;
mod watchdog;

pub use clock::elapsed_cycles;
pub use flash::{EmulatedFlash, FlashError};
pub use stack::deepest_stack;
pub use uart::{Uart, UartReceiver, UartSender};
pub use watchdog::EmulatedWatchdog;

use cortex_m_rt::{ExceptionFrame, exception};
use defmt_semihosting as _;
use protocol::BootEpoch;
use semihosting::{
    process,
    sys::arm_compat::{sys_get_cmdline_uninit, sys_time},
};
use stm32_metapac as pac;

/// The machine's peripherals, ready to use.
pub struct Machine {
    /// USART1, `-serial` number 1: the link.
    pub link: Uart,
    /// USART2, `-serial` number 2: the RFID reader.
    pub reader: Uart,
    /// USART6, `-serial` number 6: the test bench.
    pub bench: Uart,
    /// Resets the machine unless it is fed.
    pub watchdog: EmulatedWatchdog,
}

impl Machine {
    /// Starts the clock and the UARTs. `None` when the machine has been taken before.
    pub fn take() -> Option<Self> {
        let mut core = cortex_m::Peripherals::take()?;
        stack::paint();
        let machine = Self {
            link: Uart::start(pac::USART1, &uart::LINK),
            reader: Uart::start(pac::USART2, &uart::READER),
            bench: Uart::start(pac::USART6, &uart::BENCH),
            watchdog: EmulatedWatchdog::new(),
        };
        clock::start(&mut core.SYST);
        for interrupt in [pac::Interrupt::USART1, pac::Interrupt::USART2, pac::Interrupt::USART6] {
            // Safety: nothing holds a critical section by masking these, and their handlers only
            // touch the rings, which are Sync.
            unsafe { cortex_m::peripheral::NVIC::unmask(interrupt) };
        }
        Some(machine)
    }
}

/// What the emulator was started with, after the program's name: the longest that is of use.
pub fn command_line() -> heapless::String<256> {
    let mut line = [core::mem::MaybeUninit::uninit(); 256];
    let text = sys_get_cmdline_uninit(&mut line).ok().and_then(|line| core::str::from_utf8(line).ok());
    text.and_then(|text| heapless::String::try_from(text).ok()).unwrap_or_default()
}

/// The number of this start. With nothing to count in, it is the host's clock in seconds, which
/// grows from start to start as a count would.
pub fn boot_epoch() -> BootEpoch {
    BootEpoch(sys_time().ok().and_then(|seconds| u32::try_from(seconds).ok()).unwrap_or(1))
}

defmt::timestamp!("{=u64:tms}", embassy_time::Instant::now().as_millis());

#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    defmt::error!("{}", defmt::Display2Format(info));
    process::exit(1)
}

#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    defmt::error!("hard fault at {=u32:#010x}", frame.pc());
    process::exit(1)
}
