//! Voltages at pins, by ADC1.

use embassy_stm32::adc::{Adc, AnyAdcChannel, SampleTime};
use embassy_stm32::pac;
use embassy_stm32::{Peri, peripherals::ADC1};

/// Conversions of a pin whose mean is taken: their last bits are never still, so that a mean that does
/// not change is not measured.
const CONVERSIONS: u16 = 16;
/// A conversion takes 4.6 microseconds (84 and 12 cycles of 21 MHz); a converter that is not done after
/// looking this often, some 50 microseconds, never will be.
const LOOKS: u32 = 1_000;

/// ADC1 and some of its channels. embassy's own driver waits for a conversion without a limit, which
/// has no place in a control tick.
pub struct Meter<const CHANNELS: usize> {
    channels: [u8; CHANNELS],
    _owned: (Adc<'static, ADC1>, [AnyAdcChannel<'static, ADC1>; CHANNELS]),
}

impl<const CHANNELS: usize> Meter<CHANNELS> {
    /// The converter, started, for these pins.
    #[must_use]
    pub fn new(adc: Peri<'static, ADC1>, pins: [AnyAdcChannel<'static, ADC1>; CHANNELS]) -> Self {
        let adc = Adc::new(adc);
        let channels = pins.each_ref().map(AnyAdcChannel::get_hw_channel);
        for &channel in &channels {
            let channel = usize::from(channel);
            match channel.checked_sub(10) {
                Some(index) => pac::ADC1.smpr1().modify(|w| w.set_smp(index, SampleTime::CYCLES84)),
                None => pac::ADC1.smpr2().modify(|w| w.set_smp(channel, SampleTime::CYCLES84)),
            }
        }
        // One channel at a time.
        pac::ADC1.sqr1().modify(|w| w.set_l(0));
        Self { channels, _owned: (adc, pins) }
    }

    /// What is at the pins, in the order they were given, 80 microseconds each: 0 to 4095 for 0 V to
    /// the reference, not rounded. `None` if the converter does not answer.
    pub fn read(&mut self) -> Option<[f32; CHANNELS]> {
        let mut means = [0.0; CHANNELS];
        for (mean, channel) in means.iter_mut().zip(self.channels) {
            let mut sum: u16 = 0;
            for _ in 0..CONVERSIONS {
                // It fits: 16 times 12 bits.
                sum = sum.wrapping_add(convert(channel)?);
            }
            *mean = f32::from(sum) / f32::from(CONVERSIONS);
        }
        Some(means)
    }
}

fn convert(channel: u8) -> Option<u16> {
    pac::ADC1.sqr3().modify(|w| w.set_sq(0, channel));
    pac::ADC1.sr().modify(|w| w.set_eoc(false));
    pac::ADC1.cr2().modify(|w| w.set_swstart(true));
    (0..LOOKS).any(|_| pac::ADC1.sr().read().eoc()).then(|| pac::ADC1.dr().read().data())
}
