//! The ICM-20948 inertial sensor on SPI: its turn rate about z.
//!
//! A sensor that is missing, resets or comes loose costs its rate and nothing else: every read checks
//! that it is still there, and it is set up anew when it is back. No call waits for it.

/// Its SPI, mode 0 or 3, at most 7 MHz.
pub trait Bus {
    /// Selects the chip, sends `bytes` and puts in their place what it sent. Whether that worked.
    fn exchange(&mut self, bytes: &mut [u8]) -> bool;
}

/// Ticks that a reset takes: 100 ms.
const RESET_TICKS: u8 = 10;
/// In front of a register that is read.
const READ: u8 = 0x80;
const BANK_SELECT: u8 = 0x7F;
const BANK_0: u8 = 0x00;
const BANK_2: u8 = 0x20;
// Bank 0.
const WHO_AM_I: u8 = 0x00;
const ICM_20948: u8 = 0xEA;
const USER_CONTROL: u8 = 0x03;
const SPI_ONLY: u8 = 0x10;
const POWER: u8 = 0x06;
const RESET: u8 = 0x80;
const AWAKE_BEST_CLOCK: u8 = 0x01;
const GYRO_Z: u8 = 0x37;
// Bank 2.
const GYRO_DIVIDER: u8 = 0x00;
/// 1125 Hz by 1 + 4.
const RATE_225_HZ: u8 = 4;
const GYRO_CONFIG: u8 = 0x01;
/// Low-pass at 51 Hz, full scale 500 degrees a second.
const LOW_PASS_51_HZ_500_DPS: u8 = 0x1B;
/// Of that scale.
const COUNTS_PER_DPS: f32 = 65.5;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Absent,
    Resetting { ticks: u8 },
    Ready,
}

/// The sensor.
#[derive(Debug)]
pub struct Icm20948<B> {
    bus: B,
    state: State,
}

impl<B: Bus> Icm20948<B> {
    /// A sensor that nobody has spoken to yet.
    pub const fn new(bus: B) -> Self {
        Self { bus, state: State::Absent }
    }

    /// Once a tick: the rate about z in rad/s, counter-clockwise seen from above the chip; none while
    /// it is missing or being set up.
    pub fn rate_radps(&mut self) -> Option<f32> {
        if !self.is_there() {
            self.state = State::Absent;
            return None;
        }
        match self.state {
            State::Absent => {
                let reset = self.write(POWER, RESET);
                self.state = if reset { State::Resetting { ticks: RESET_TICKS } } else { State::Absent };
                None
            }
            State::Resetting { ticks: 0 } => {
                self.state = if self.set_up() { State::Ready } else { State::Absent };
                None
            }
            State::Resetting { ticks } => {
                self.state = State::Resetting { ticks: ticks - 1 };
                None
            }
            State::Ready => {
                let mut bytes = [READ | GYRO_Z, 0, 0];
                let [_, high, low] = self.bus.exchange(&mut bytes).then_some(bytes)?;
                let counts = f32::from(i16::from_be_bytes([high, low]));
                Some((counts / COUNTS_PER_DPS).to_radians())
            }
        }
    }

    fn is_there(&mut self) -> bool {
        let mut bytes = [READ | WHO_AM_I, 0];
        self.write(BANK_SELECT, BANK_0) && self.bus.exchange(&mut bytes) && bytes[1] == ICM_20948
    }

    fn set_up(&mut self) -> bool {
        self.write(USER_CONTROL, SPI_ONLY)
            && self.write(POWER, AWAKE_BEST_CLOCK)
            && self.write(BANK_SELECT, BANK_2)
            && self.write(GYRO_DIVIDER, RATE_225_HZ)
            && self.write(GYRO_CONFIG, LOW_PASS_51_HZ_500_DPS)
            && self.write(BANK_SELECT, BANK_0)
    }

    fn write(&mut self, register: u8, value: u8) -> bool {
        self.bus.exchange(&mut [register, value])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chip that keeps its registers, in two banks of those we use.
    struct Chip {
        registers: [[u8; 128]; 2],
        bank: usize,
        plugged: bool,
    }

    impl Chip {
        fn new() -> Self {
            let mut registers = [[0; 128]; 2];
            registers[0][usize::from(WHO_AM_I)] = ICM_20948;
            Self { registers, bank: 0, plugged: true }
        }
    }

    impl Bus for &mut Chip {
        fn exchange(&mut self, bytes: &mut [u8]) -> bool {
            let (first, rest) = bytes.split_first_mut().unwrap();
            let register = usize::from(*first & !READ);
            for (index, byte) in rest.iter_mut().enumerate() {
                match (*first & READ != 0, self.plugged) {
                    (_, false) => *byte = 0xFF,
                    (true, true) => *byte = self.registers[self.bank][register + index],
                    (false, true) if register == usize::from(BANK_SELECT) => {
                        self.bank = usize::from(*byte == BANK_2);
                    }
                    (false, true) => self.registers[self.bank][register + index] = *byte,
                }
            }
            true
        }
    }

    fn ticks_until_rate(sensor: &mut Icm20948<&mut Chip>) -> usize {
        (1..100).find(|_| sensor.rate_radps().is_some()).unwrap()
    }

    #[test]
    fn it_is_reset_set_up_and_read() {
        let mut chip = Chip::new();
        chip.registers[0][usize::from(GYRO_Z)..][..2].copy_from_slice(&(-6550_i16).to_be_bytes());
        let mut sensor = Icm20948::new(&mut chip);
        assert_eq!(ticks_until_rate(&mut sensor), usize::from(RESET_TICKS) + 3);
        assert!((sensor.rate_radps().unwrap() + 100_f32.to_radians()).abs() < 1e-5);
        assert_eq!(chip.registers[1][usize::from(GYRO_CONFIG)], LOW_PASS_51_HZ_500_DPS);
        assert_eq!(chip.registers[0][usize::from(POWER)], AWAKE_BEST_CLOCK);
    }

    #[test]
    fn unplugged_it_has_no_rate_and_plugged_in_again_it_is_set_up_anew() {
        let mut chip = Chip::new();
        let mut sensor = Icm20948::new(&mut chip);
        ticks_until_rate(&mut sensor);
        sensor.bus.plugged = false;
        assert_eq!(sensor.rate_radps(), None);
        *sensor.bus = Chip::new();
        assert_eq!(sensor.rate_radps(), None, "an unconfigured sensor has no rate to believe");
        ticks_until_rate(&mut sensor);
        assert_eq!(chip.registers[1][usize::from(GYRO_CONFIG)], LOW_PASS_51_HZ_500_DPS);
    }
}
