//! What the boards that are flashed have in common: an STM32F407VG with a crystal of 8 MHz, lines to
//! the computer and the RFID reader, a watchdog, and how a program ends.

mod meter;
mod pins;

pub use meter::Meter;

use defmt_rtt as _;
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_stm32::{Config, Peri, Peripherals, pac, peripherals, rcc, time::Hertz, usart};
use protocol::DurationMs;

use crate::tasks::Watchdog;

/// Bit rate of the RFID reader's line.
pub const READER_BAUD: u32 = 115_200;

/// Starts the clocks and gives all there is. To be called once.
#[must_use]
pub fn start() -> Peripherals {
    let all = embassy_stm32::init(clocks());
    // Flash takes six cycles to read; embassy leaves the accelerator off. Not its data cache: that
    // would have to be emptied whenever a sector was erased.
    pac::FLASH.acr().modify(|w| {
        w.set_prften(true);
        w.set_icen(true);
    });
    all
}

/// 168 MHz from the crystal of 8 MHz; 84 MHz for timers and USART1, 42 MHz for USART2.
fn clocks() -> Config {
    let mut config = Config::default();
    config.rcc.hse = Some(rcc::Hse { freq: Hertz(8_000_000), mode: rcc::HseMode::Oscillator });
    config.rcc.pll_src = rcc::PllSource::HSE;
    config.rcc.pll = Some(rcc::Pll {
        prediv: rcc::PllPreDiv::DIV4,
        mul: rcc::PllMul::MUL168,
        divp: Some(rcc::PllPDiv::DIV2),
        divq: Some(rcc::PllQDiv::DIV7),
        divr: None,
    });
    config.rcc.ahb_pre = rcc::AHBPrescaler::DIV1;
    config.rcc.apb1_pre = rcc::APBPrescaler::DIV4;
    config.rcc.apb2_pre = rcc::APBPrescaler::DIV2;
    config.rcc.sys = rcc::Sysclk::PLL1_P;
    config
}

/// A serial line of `baud`.
#[must_use]
pub fn line(baud: u32) -> usart::Config {
    let mut config = usart::Config::default();
    config.baudrate = baud;
    // Otherwise a reader is only woken when the ring is half full or the line idle.
    config.eager_reads = Some(1);
    config
}

/// Whether the watchdog caused the last reset; the answer is cleared.
#[must_use]
pub fn reset_by_watchdog() -> bool {
    let was_watchdog = pac::RCC.csr().read().wdgrstf();
    pac::RCC.csr().modify(|w| w.set_rmvf(true));
    was_watchdog
}

/// The independent watchdog. Its own oscillator is off by as much as half: a timeout of 300 ms is one
/// of 200 to 570 ms.
pub struct HardwareWatchdog(IndependentWatchdog<'static, peripherals::IWDG>);

impl HardwareWatchdog {
    /// Starts it: from now on it resets the board unless it is fed within `timeout`.
    #[must_use]
    pub fn start(instance: Peri<'static, peripherals::IWDG>, timeout: DurationMs) -> Self {
        let mut watchdog = IndependentWatchdog::new(instance, timeout.0.saturating_mul(1_000));
        watchdog.unleash();
        Self(watchdog)
    }
}

impl Watchdog for HardwareWatchdog {
    fn feed(&mut self) {
        self.0.pet();
    }
}

/// Does nothing until the watchdog resets the board.
pub fn wait_for_watchdog() -> ! {
    loop {
        cortex_m::asm::nop();
    }
}

/// What a board does first when its program ends by a panic or a hard fault, whatever state it is in:
/// `$make_safe`. Then it says why in its log and waits for the watchdog.
#[macro_export]
macro_rules! last_words {
    ($make_safe:path) => {
        #[panic_handler]
        fn panic(info: &core::panic::PanicInfo) -> ! {
            cortex_m::interrupt::disable();
            $make_safe();
            defmt::error!("{}", defmt::Display2Format(info));
            $crate::stm32::wait_for_watchdog()
        }

        #[cortex_m_rt::exception]
        unsafe fn HardFault(frame: &cortex_m_rt::ExceptionFrame) -> ! {
            cortex_m::interrupt::disable();
            $make_safe();
            defmt::error!("hard fault at {=u32:#010x}", frame.pc());
            $crate::stm32::wait_for_watchdog()
        }
    };
}

defmt::timestamp!("{=u64:tms}", embassy_time::Instant::now().as_millis());
