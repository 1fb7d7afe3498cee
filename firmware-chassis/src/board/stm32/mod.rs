//! The board that is flashed: an STM32F407VG with four motor drivers of the DRV8874's kind (PWM and
//! direction; PWM low brakes), four quadrature encoders, an ICM-20948 and a battery meter.
//!
//! TIM12 is the time driver. Whatever ends the program, a panic or a fault, opens the motors first;
//! the watchdog then restarts the board.

mod body;
mod pins;

pub use body::HardwareBody;

use embassy_stm32::usart::{self, BufferedUart, BufferedUartRx, BufferedUartTx};
use embassy_stm32::{bind_interrupts, pac, peripherals};
use firmware_common::stm32::{self, HardwareWatchdog, READER_BAUD, line, reset_by_watchdog};
use firmware_common::supervisor;
use protocol::{BootEpoch, DurationMs};

use crate::Start;
use pins::Pins;

bind_interrupts!(struct Interrupts {
    USART1 => usart::BufferedInterruptHandler<peripherals::USART1>;
    USART2 => usart::BufferedInterruptHandler<peripherals::USART2>;
});

/// Bit rate of the link.
const LINK_BAUD: u32 = 921_600;
/// Bytes of a line's ring: the link carries 92 a millisecond.
const RING: usize = 2_048;
const WATCHDOG_TIMEOUT: DurationMs = DurationMs(3 * supervisor::PERIOD.0);

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
        let pins = Pins::take(stm32::start());
        let start = if reset_by_watchdog() { Start::Watchdog } else { Start::PowerOn };
        let boot = count_start();
        let watchdog = HardwareWatchdog::start(pins.watchdog, WATCHDOG_TIMEOUT);
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
        Some(Self { link_rx, link_tx, reader: reader.ok()?, body, watchdog, start, boot })
    }
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
    pac::GPIOE.bsrr().write(|w| w.set_br(15, true));
    pac::TIM1.bdtr().modify(|w| w.set_moe(false));
}

firmware_common::last_words!(open_motors);
