//! The board that is flashed: an STM32F407VG with a power stage and its contactor, meters of voltage,
//! current and temperature, and an RFID reader of either kind.
//!
//! TIM5 is the time driver. Whatever ends the program, a panic or a fault, opens the contactor first;
//! the watchdog then restarts the board.

mod charger;
mod flash;
mod pins;

pub use charger::HardwareCharger;
pub use flash::StoreFlash;

use embassy_stm32::gpio::{Input, Level, Output, Pull, Speed};
use embassy_stm32::mode::Blocking;
use embassy_stm32::spi::{self, Spi, mode::Master};
use embassy_stm32::time::Hertz;
use embassy_stm32::usart::{self, BufferedUart, BufferedUartRx, BufferedUartTx};
use embassy_stm32::{bind_interrupts, pac, peripherals};
use embassy_time::Delay;
use embedded_hal_bus::spi::{ExclusiveDevice, NoDelay};
use firmware_common::reader::mfrc522::{BUS_HZ, Mfrc522};
use firmware_common::reader::r200::R200;
use firmware_common::stm32::{self, HardwareWatchdog, READER_BAUD, line, reset_by_watchdog};
use protocol::DurationMs;

use pins::Pins;

bind_interrupts!(struct Interrupts {
    USART1 => usart::BufferedInterruptHandler<peripherals::USART1>;
    USART2 => usart::BufferedInterruptHandler<peripherals::USART2>;
});

/// Bit rate of the link.
const LINK_BAUD: u32 = 115_200;
/// Bytes of a line's ring: what comes in 90 ms, which is longer than a poll of the MFRC522 keeps the
/// other tasks.
const RING: usize = 1_024;
/// Its oscillator is off by as much as half: 0.7 to 1.9 s. An erase of the store's flash, which happens
/// only while the contacts are dead, may take 0.5 s.
const WATCHDOG_TIMEOUT: DurationMs = DurationMs(1_000);

/// The UHF reader.
pub type UhfReader = R200<BufferedUart<'static>>;
/// The reader of 13.56 MHz tags.
pub type TagReader =
    Mfrc522<ExclusiveDevice<Spi<'static, Blocking, Master>, Output<'static>, NoDelay>, Delay>;

/// The board's parts, ready to use; its watchdog runs.
pub struct Board {
    /// From the coordinator.
    pub link_rx: BufferedUartRx<'static>,
    /// To the coordinator.
    pub link_tx: BufferedUartTx<'static>,
    /// The UHF reader, if the board is fitted with it.
    pub uhf_reader: UhfReader,
    /// The MFRC522, if the board is fitted with it.
    pub tag_reader: TagReader,
    /// Sensors, power stage, contactor, lamps.
    pub charger: HardwareCharger,
    /// Where the store is.
    pub flash: StoreFlash,
    /// Whether the provisioning button is held.
    pub button: Input<'static>,
    /// The watchdog.
    pub watchdog: HardwareWatchdog,
    /// Whether the watchdog caused this start.
    pub reset_by_watchdog: bool,
}

impl Board {
    /// Starts clocks and peripherals. `None` when the board has been taken before, or a baud rate
    /// cannot be had.
    pub fn take() -> Option<Self> {
        let link_ring = cortex_m::singleton!(: [[u8; RING]; 2] = [[0; RING]; 2])?;
        let reader_ring = cortex_m::singleton!(: [[u8; RING]; 2] = [[0; RING]; 2])?;
        let pins = Pins::take(stm32::start());
        // First of all: the contacts are dead.
        let charger = HardwareCharger::new(
            charger::Switches {
                contactor: pins.contactor.into(),
                power_enable: pins.power_enable.into(),
                set_point: pins.set_point,
                power_limit: pins.power_limit,
                led_free: pins.led_free.into(),
                led_taken: pins.led_taken.into(),
                led_fault: pins.led_fault.into(),
                led_live: pins.led_live.into(),
            },
            charger::Senses {
                contactor_feedback: pins.contactor_feedback.into(),
                mated: pins.mated.into(),
                emergency_stop: pins.emergency_stop.into(),
                mains: pins.mains.into(),
                meter: pins.meter,
                output_voltage: pins.output_voltage,
                output_current: pins.output_current,
                contact_temperature: pins.contact_temperature,
            },
        );
        let reset_by_watchdog = reset_by_watchdog();
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
        let mut bus = spi::Config::default();
        bus.frequency = Hertz(BUS_HZ);
        // Where no chip is fitted nobody drives it.
        bus.miso_pull = Pull::Down;
        let bus = Spi::new_blocking(pins.tag_bus, pins.tag_clock, pins.tag_mosi, pins.tag_miso, bus);
        let select = Output::new(pins.tag_select, Level::High, Speed::Low);
        let Ok(device) = ExclusiveDevice::new_no_delay(bus, select);
        Some(Self {
            link_rx,
            link_tx,
            uhf_reader: R200::new(reader.ok()?),
            tag_reader: Mfrc522::new(device, Delay),
            charger,
            flash: StoreFlash::new(pins.flash),
            button: Input::new(pins.button, Pull::Down),
            watchdog,
            reset_by_watchdog,
        })
    }
}

/// Opens the contactor and stops the power stage, whatever state the program is in.
fn open_contactor() {
    pac::GPIOE.bsrr().write(|w| {
        w.set_br(15, true);
        w.set_br(14, true);
    });
}

firmware_common::last_words!(open_contactor);
