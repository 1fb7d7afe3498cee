//! The board that is flashed: an STM32F407VG with four motor drivers of the DRV8874's kind (PWM and
//! direction; PWM low brakes), four quadrature encoders, an ICM-20948 and a battery meter.
//!
//! TIM12 is the time driver. Whatever ends the program, a panic or a fault, opens the motors first;
//! the watchdog then restarts the board.

mod body;
mod pins;

pub use body::HardwareBody;

use embassy_stm32::usart::{self, BufferedUart, BufferedUartRx, BufferedUartTx};
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_stm32::{Config, bind_interrupts, pac, peripherals, rcc, time::Hertz};
use firmware_common::{supervisor, tasks::Watchdog};
use protocol::BootEpoch;

use crate::Start;
use pins::Pins;

use cortex_m_rt::{ExceptionFrame, exception};
use defmt_rtt as _;

bind_interrupts!(struct Interrupts {
    USART1 => usart::BufferedInterruptHandler<peripherals::USART1>;
    USART2 => usart::BufferedInterruptHandler<peripherals::USART2>;
});

/// Bit rates of the two lines.
const LINK_BAUD: u32 = 921_600;
const READER_BAUD: u32 = 115_200;
/// Bytes of a line's ring: the link carries 92 a millisecond.
const RING: usize = 2_048;
const WATCHDOG_US: u32 = 3_000 * supervisor::PERIOD.0;

/// The board's parts, ready to use; its watchdog runs.
pub struct Board {
    /// From the robot's computer.
    pub link_rx: BufferedUartRx<'static>,
    /// To the robot's computer.
    pub link_tx: BufferedUartTx<'static>,
    /// To and from the RFID reader.
    pub reader: BufferedUart<'static>,
    /// Wheels, gyroscope, battery meter.
    pub body: HardwareBody,
    /// The watchdog.
    pub watchdog: HardwareWatchdog,
    /// Why the board has just started.
    pub start: Start,
    /// The number of this start.
    pub boot: BootEpoch,
}

impl Board {
    /// Starts clocks and peripherals. `None` when the board has been taken before, or a baud rate
    /// cannot be had.
    pub fn take() -> Option<Self> {
        let link_ring = cortex_m::singleton!(: [[u8; RING]; 2] = [[0; RING]; 2])?;
        let reader_ring = cortex_m::singleton!(: [[u8; RING]; 2] = [[0; RING]; 2])?;
        let pins = Pins::take(embassy_stm32::init(clocks()));
        let start = why_started();
        let boot = count_start();
        let mut watchdog = IndependentWatchdog::new(pins.watchdog, WATCHDOG_US);
        watchdog.unleash();
        let [sent, received] = link_ring;
        let link = BufferedUart::new(
            pins.link,
            pins.link_rx,
            pins.link_tx,
            sent,
            received,
            Interrupts,
            line(LINK_BAUD),
        );
        let [sent, received] = reader_ring;
        let reader = BufferedUart::new(
            pins.reader,
            pins.reader_rx,
            pins.reader_tx,
            sent,
            received,
            Interrupts,
            line(READER_BAUD),
        );
        let (link_tx, link_rx) = link.ok()?.split();
        let body = HardwareBody::new(
            body::Motors {
                timer: pins.pwm,
                pwm: (pins.pwm_a, pins.pwm_b, pins.pwm_c, pins.pwm_d),
                directions: [
                    pins.direction_a.into(),
                    pins.direction_b.into(),
                    pins.direction_c.into(),
                    pins.direction_d.into(),
                ],
                faults: [pins.fault_a.into(), pins.fault_b.into(), pins.fault_c.into(), pins.fault_d.into()],
                awake: pins.drivers_awake.into(),
            },
            body::Encoders {
                a: (pins.counter_a, pins.encoder_a1, pins.encoder_a2),
                b: (pins.counter_b, pins.encoder_b1, pins.encoder_b2),
                c: (pins.counter_c, pins.encoder_c1, pins.encoder_c2),
                d: (pins.counter_d, pins.encoder_d1, pins.encoder_d2),
            },
            body::GyroPins {
                spi: pins.gyro,
                clock: pins.gyro_clock,
                mosi: pins.gyro_mosi,
                miso: pins.gyro_miso,
                select: pins.gyro_select.into(),
            },
            body::MeterPins { adc: pins.meter, voltage: pins.battery_voltage, current: pins.battery_current },
        );
        let watchdog = HardwareWatchdog(watchdog);
        Some(Self { link_rx, link_tx, reader: reader.ok()?, body, watchdog, start, boot })
    }
}

/// The independent watchdog.
pub struct HardwareWatchdog(IndependentWatchdog<'static, peripherals::IWDG>);

impl Watchdog for HardwareWatchdog {
    fn feed(&mut self) {
        self.0.pet();
    }
}

/// 168 MHz from the crystal of 8 MHz.
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

fn line(baud: u32) -> usart::Config {
    let mut config = usart::Config::default();
    config.baudrate = baud;
    // Otherwise a reader is only woken when the ring is half full or the line idle.
    config.eager_reads = Some(1);
    config
}

/// Reads and clears the cause of the last reset.
fn why_started() -> Start {
    let was_watchdog = pac::RCC.csr().read().wdgrstf();
    pac::RCC.csr().modify(|w| w.set_rmvf(true));
    if was_watchdog { Start::Watchdog } else { Start::PowerOn }
}

/// Counts starts in a backup register, which lasts as long as the supply or the cell at VBAT does.
fn count_start() -> BootEpoch {
    pac::RCC.apb1enr().modify(|w| w.set_pwren(true));
    pac::PWR.cr1().modify(|w| w.set_dbp(true));
    let count = pac::RTC.bkpr(0).read().bkp().wrapping_add(1);
    pac::RTC.bkpr(0).write(|w| w.set_bkp(count));
    BootEpoch(count)
}

/// Opens all motors, whatever state the program is in: the drivers sleep, the PWM ends.
fn open_motors() {
    cortex_m::interrupt::disable();
    pac::GPIOE.bsrr().write(|w| w.set_br(15, true));
    pac::TIM1.bdtr().modify(|w| w.set_moe(false));
}

/// Until the watchdog resets the board.
fn wait_for_watchdog() -> ! {
    loop {
        cortex_m::asm::nop();
    }
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    open_motors();
    defmt::error!("{}", defmt::Display2Format(info));
    wait_for_watchdog()
}

#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    open_motors();
    defmt::error!("hard fault at {=u32:#010x}", frame.pc());
    wait_for_watchdog()
}

defmt::timestamp!("{=u64:tms}", embassy_time::Instant::now().as_millis());
