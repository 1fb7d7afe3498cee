//! Motors, encoders, gyroscope and battery meter.

use embassy_stm32::adc::AdcChannel;
use embassy_stm32::gpio::{AnyPin, Input, Level, Output, OutputType, Pull, Speed};
use embassy_stm32::mode::Blocking;
use embassy_stm32::spi::{self, Spi, mode::Master};
use embassy_stm32::time::{Hertz, khz};
use embassy_stm32::timer::low_level::CountingMode;
use embassy_stm32::timer::qei::{self, Qei};
use embassy_stm32::timer::simple_pwm::{PwmPin, SimplePwm, SimplePwmChannel};
use embassy_stm32::{Peri, peripherals as p};
use firmware_common::stm32::Meter;
use protocol::Millis;

use crate::icm20948::{Bus, Icm20948};
use crate::tasks::Body;
use crate::{BatterySample, Sensors};

/// Above what is heard.
const PWM: Hertz = khz(20);
/// What the sensor can do at most is 7 MHz.
const GYRO_CLOCK: Hertz = Hertz(5_250_000);
/// The converter's reference.
const REFERENCE_V: f32 = 3.3;
/// The highest the converter gives; both ends mean a broken line.
const RAIL: f32 = 4095.0;
/// 47 and 10 kilo-ohm.
const DIVIDER: f32 = 5.7;
/// The current meter's, about half the reference.
const VOLTS_PER_AMPERE: f32 = 0.1;

type Pin = Peri<'static, AnyPin>;
type Counter<T, P1, P2> = (Peri<'static, T>, Peri<'static, P1>, Peri<'static, P2>);
type PwmPins =
    (Peri<'static, p::PE9>, Peri<'static, p::PE11>, Peri<'static, p::PE13>, Peri<'static, p::PE14>);

/// What the motors hang on.
pub(super) struct Motors {
    pub timer: Peri<'static, p::TIM1>,
    pub pwm: PwmPins,
    pub directions: [Pin; 4],
    pub faults: [Pin; 4],
    pub awake: Pin,
}

/// What the encoders hang on.
pub(super) struct Encoders {
    pub a: Counter<p::TIM2, p::PA15, p::PB3>,
    pub b: Counter<p::TIM3, p::PB4, p::PB5>,
    pub c: Counter<p::TIM4, p::PD12, p::PD13>,
    pub d: Counter<p::TIM5, p::PA0, p::PA1>,
}

/// What the gyroscope hangs on.
pub(super) struct GyroPins {
    pub spi: Peri<'static, p::SPI2>,
    pub clock: Peri<'static, p::PB13>,
    pub mosi: Peri<'static, p::PB15>,
    pub miso: Peri<'static, p::PB14>,
    pub select: Pin,
}

/// What the battery meter hangs on.
pub(super) struct MeterPins {
    pub adc: Peri<'static, p::ADC1>,
    pub voltage: Peri<'static, p::PC4>,
    pub current: Peri<'static, p::PC5>,
}

struct GyroBus {
    spi: Spi<'static, Blocking, Master>,
    select: Output<'static>,
}

impl Bus for GyroBus {
    fn exchange(&mut self, bytes: &mut [u8]) -> bool {
        self.select.set_low();
        let exchanged = self.spi.blocking_transfer_in_place(bytes);
        self.select.set_high();
        exchanged.is_ok()
    }
}

/// The robot.
pub struct HardwareBody {
    pwm: [SimplePwmChannel<'static, p::TIM1>; 4],
    directions: [Output<'static>; 4],
    faults: [Input<'static>; 4],
    _awake: Output<'static>,
    encoders: (Qei<'static, p::TIM2>, Qei<'static, p::TIM3>, Qei<'static, p::TIM4>, Qei<'static, p::TIM5>),
    gyro: Icm20948<GyroBus>,
    meter: Meter<2>,
}

impl HardwareBody {
    /// Everything set up, the motors braked.
    pub(super) fn new(motors: Motors, encoders: Encoders, gyro: GyroPins, meter: MeterPins) -> Self {
        let (a, b, c, d) = motors.pwm;
        let pwm = SimplePwm::new(
            motors.timer,
            Some(PwmPin::new(a, OutputType::PushPull)),
            Some(PwmPin::new(b, OutputType::PushPull)),
            Some(PwmPin::new(c, OutputType::PushPull)),
            Some(PwmPin::new(d, OutputType::PushPull)),
            PWM,
            CountingMode::EdgeAlignedUp,
        )
        .split();
        let mut pwm = [pwm.ch1, pwm.ch2, pwm.ch3, pwm.ch4];
        for channel in &mut pwm {
            channel.set_duty_cycle_fully_off();
            channel.enable();
        }
        let config = qei::Config { ch1_pull: Pull::Up, ch2_pull: Pull::Up, ..qei::Config::default() };
        let mut spi = spi::Config::default();
        spi.frequency = GYRO_CLOCK;
        Self {
            pwm,
            directions: motors.directions.map(|pin| Output::new(pin, Level::Low, Speed::Low)),
            faults: motors.faults.map(|pin| Input::new(pin, Pull::Up)),
            _awake: Output::new(motors.awake, Level::High, Speed::Low),
            encoders: (
                Qei::new(encoders.a.0, encoders.a.1, encoders.a.2, config),
                Qei::new(encoders.b.0, encoders.b.1, encoders.b.2, config),
                Qei::new(encoders.c.0, encoders.c.1, encoders.c.2, config),
                Qei::new(encoders.d.0, encoders.d.1, encoders.d.2, config),
            ),
            gyro: Icm20948::new(GyroBus {
                spi: Spi::new_blocking(gyro.spi, gyro.clock, gyro.mosi, gyro.miso, spi),
                select: Output::new(gyro.select, Level::High, Speed::High),
            }),
            meter: Meter::new(meter.adc, [meter.voltage.degrade_adc(), meter.current.degrade_adc()]),
        }
    }

    fn battery(&mut self) -> Option<BatterySample> {
        let [voltage, current] = self.meter.read()?;
        Some(BatterySample {
            voltage_v: volts(voltage)? * DIVIDER,
            current_a: (volts(current)? - REFERENCE_V / 2.0) / VOLTS_PER_AMPERE,
        })
    }
}

/// None at the rails: no battery of ours reaches them.
fn volts(sample: f32) -> Option<f32> {
    (1.0..RAIL).contains(&sample).then_some(sample * REFERENCE_V / RAIL)
}

impl Body for HardwareBody {
    fn sense(&mut self, _now: Millis) -> Sensors {
        let (a, b, c, d) = &self.encoders;
        Sensors {
            encoders: [a.count(), b.count(), c.count(), d.count()],
            driver_faults: self.faults.each_ref().map(Input::is_low),
            gyro_radps: self.gyro.rate_radps(),
            battery: self.battery(),
        }
    }

    fn drive(&mut self, motors: crate::Motors) {
        // PWM low brakes, in either direction.
        let duties = match motors {
            crate::Motors::Brake => [0.0; 4],
            crate::Motors::Drive(duties) => duties,
        };
        for ((channel, direction), duty) in self.pwm.iter_mut().zip(&mut self.directions).zip(duties) {
            direction.set_level(if duty < 0.0 { Level::Low } else { Level::High });
            let full = channel.max_duty_cycle();
            channel.set_duty_cycle(((duty.abs() * full as f32) as u32).min(full));
        }
    }
}
