//! Sensors, power stage, contactor and lamps.

use embassy_stm32::adc::AdcChannel;
use embassy_stm32::dac::{DacChannel, Value};
use embassy_stm32::gpio::{AnyPin, Input, Level, Output, Pull, Speed};
use embassy_stm32::mode::Blocking;
use embassy_stm32::{Peri, peripherals as p};
use firmware_common::stm32::Meter;
use protocol::{Availability, Millis};

use crate::tasks::Charger;
use crate::{Contactor, Power, Sensors, scaling};

type Pin = Peri<'static, AnyPin>;

/// What switches and what shows.
pub(super) struct Switches {
    pub contactor: Pin,
    pub power_enable: Pin,
    pub set_point: Peri<'static, p::DAC1>,
    pub power_limit: Peri<'static, p::PA4>,
    pub led_free: Pin,
    pub led_taken: Pin,
    pub led_fault: Pin,
    pub led_live: Pin,
}

/// What is sensed. The pins are low where all is as it should be, or closed.
pub(super) struct Senses {
    pub contactor_feedback: Pin,
    pub mated: Pin,
    pub emergency_stop: Pin,
    pub mains: Pin,
    pub meter: Peri<'static, p::ADC1>,
    pub output_voltage: Peri<'static, p::PC0>,
    pub output_current: Peri<'static, p::PC1>,
    pub contact_temperature: Peri<'static, p::PC2>,
}

/// The charger.
pub struct HardwareCharger {
    contactor: Output<'static>,
    power_enable: Output<'static>,
    power_limit: DacChannel<'static, Blocking>,
    led_free: Output<'static>,
    led_taken: Output<'static>,
    led_fault: Output<'static>,
    led_live: Output<'static>,
    contactor_feedback: Input<'static>,
    mated: Input<'static>,
    emergency_stop: Input<'static>,
    mains: Input<'static>,
    meter: Meter<3>,
}

impl HardwareCharger {
    /// Everything set up, the contacts dead.
    pub(super) fn new(switches: Switches, senses: Senses) -> Self {
        let off = |pin| Output::new(pin, Level::Low, Speed::Low);
        // A wire that is off reads high: not closed, not mated, stopped, no mains.
        let sense = |pin| Input::new(pin, Pull::Up);
        let mut charger = Self {
            contactor: off(switches.contactor),
            power_enable: off(switches.power_enable),
            power_limit: DacChannel::new_blocking(switches.set_point, switches.power_limit),
            led_free: off(switches.led_free),
            led_taken: off(switches.led_taken),
            led_fault: off(switches.led_fault),
            led_live: off(switches.led_live),
            contactor_feedback: sense(senses.contactor_feedback),
            mated: sense(senses.mated),
            emergency_stop: sense(senses.emergency_stop),
            mains: sense(senses.mains),
            meter: Meter::new(
                senses.meter,
                [
                    senses.output_voltage.degrade_adc(),
                    senses.output_current.degrade_adc(),
                    senses.contact_temperature.degrade_adc(),
                ],
            ),
        };
        charger.command(Power::OFF);
        charger
    }
}

impl Charger for HardwareCharger {
    fn sense(&mut self, _now: Millis) -> Sensors {
        // A converter that does not answer measures nothing.
        let [voltage, current, temperature] = self.meter.read().unwrap_or([f32::NAN; 3]);
        Sensors {
            output_v: scaling::output_v(voltage),
            output_a: scaling::output_a(current),
            contact_c: scaling::contact_c(temperature),
            contactor_closed: self.contactor_feedback.is_low(),
            mated: self.mated.is_low(),
            emergency_stop: self.emergency_stop.is_high(),
            mains: self.mains.is_low(),
        }
    }

    fn command(&mut self, power: Power) {
        let closed = power.contactor == Contactor::Closed;
        let level = if closed { Level::High } else { Level::Low };
        self.contactor.set_level(level);
        let counts = if closed { scaling::set_point(power.current_limit_a) } else { 0 };
        self.power_limit.set(Value::Bit12Right(counts));
        self.power_enable.set_level(if counts > 0 { Level::High } else { Level::Low });
        self.led_live.set_level(level);
    }

    fn show(&mut self, availability: Availability) {
        let (free, taken, fault) = match availability {
            Availability::Free => (true, false, false),
            Availability::Reserved | Availability::Charging | Availability::Done => (false, true, false),
            Availability::Fault => (false, false, true),
        };
        for (led, on) in
            [(&mut self.led_free, free), (&mut self.led_taken, taken), (&mut self.led_fault, fault)]
        {
            led.set_level(if on { Level::High } else { Level::Low });
        }
    }
}
