//! The board that QEMU emulates (`-M olimex-stm32-h405`): USART1 is the link to the coordinator,
//! USART2 the RFID reader, the contactor shows in the log, SysTick is the clock.
//!
//! The machine has the USARTs, SysTick and NVIC of an STM32F407, but no clock tree: nothing here
//! may wait for the RCC, PWR or FLASH peripherals to become ready.

mod clock;
mod contacts;
mod executor;
mod memory;
mod uart;

pub use contacts::LoggedContactor;
pub use executor::execute;
pub use memory::{VolatileMemory, boot_epoch};
pub use uart::{Uart, UartReceiver, UartSender};

use cortex_m_rt::{ExceptionFrame, exception};
use defmt_semihosting as _;
use semihosting::process;
use stm32_metapac as pac;

/// The board's peripherals, ready to use.
pub struct Board {
    /// USART1, to the coordinator.
    pub link: Uart,
    /// USART2, to the RFID reader.
    pub reader: Uart,
    /// In front of the contacts.
    pub contactor: LoggedContactor,
    /// For the highest epoch.
    pub memory: VolatileMemory,
}

impl Board {
    /// Starts the clock and both UARTs. `None` when the board has been taken before.
    pub fn take() -> Option<Self> {
        let mut core = cortex_m::Peripherals::take()?;
        clock::start(&mut core.SYST);
        let link = Uart::start(pac::USART1, &uart::LINK);
        let reader = Uart::start(pac::USART2, &uart::READER);
        // Safety: nothing holds a critical section by masking these two, and their handlers only
        // touch the rings, which are Sync.
        unsafe {
            cortex_m::peripheral::NVIC::unmask(pac::Interrupt::USART1);
            cortex_m::peripheral::NVIC::unmask(pac::Interrupt::USART2);
        }
        Some(Self { link, reader, contactor: LoggedContactor::new(), memory: VolatileMemory })
    }
}

defmt::timestamp!("{=u64:tms}", embassy_time::Instant::now().as_millis());

/// A panic is a defect: say so in the log and end the emulator with a failure.
#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    defmt::error!("{}", defmt::Display2Format(info));
    process::exit(1)
}

/// As for a panic: without this, a fault would look like a silent pile.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    defmt::error!("hard fault at {=u32:#010x}", frame.pc());
    process::exit(1)
}
