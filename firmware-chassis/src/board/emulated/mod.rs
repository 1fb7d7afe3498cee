//! What QEMU's machine does not have: wheels, gyroscope and battery, which are a [`Plant`] here, and
//! a test bench that breaks them. The machine itself is [`firmware_common::emulated`].

mod bench;

pub use bench::serve;

use cortex_m::peripheral::SYST;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use firmware_common::emulated::{cost, elapsed_cycles};
use protocol::Millis;

use crate::plant::Plant;
use crate::tasks::Body;
use crate::{Motors, Parameters, Sensors, TICK};
use bench::Order;

/// Orders of the test bench that wait for the next tick.
static ORDERS: Channel<CriticalSectionRawMutex, Order, 4> = Channel::new();

/// The counters start close to where they wrap, so that every run wraps them.
const COUNTERS: [u16; 4] = [0, u16::MAX, 65_000, 500];

/// The most ticks a late one is taken for, as by the core.
const MOST_TICKS: u32 = 100;

/// A robot that is a model.
pub struct ModelledBody {
    plant: Plant,
    motors: Motors,
    sensed_at: Option<Millis>,
    /// When the tick began that is not over.
    tick: Option<u32>,
}

impl ModelledBody {
    /// The robot of these parameters, at rest and full.
    #[must_use]
    pub fn new(parameters: &Parameters) -> Self {
        Self { plant: Plant::new(parameters, COUNTERS), motors: Motors::Brake, sensed_at: None, tick: None }
    }
}

impl Body for ModelledBody {
    fn sense(&mut self, now: Millis) -> Sensors {
        while let Ok(order) = ORDERS.try_receive() {
            bench::obey(order, &mut self.plant);
        }
        // A tick that comes late finds that the robot has rolled on.
        let passed = self.sensed_at.replace(now).map_or(TICK.0, |before| now.since(before).0);
        let ticks = ((passed + TICK.0 / 2) / TICK.0).clamp(1, MOST_TICKS);
        let mut sensors = self.plant.advance(self.motors);
        for _ in 1..ticks {
            sensors = self.plant.advance(self.motors);
        }
        bench::publish(&self.plant);
        self.tick = Some(SYST::get_current());
        sensors
    }

    fn drive(&mut self, motors: Motors) {
        if let Some(start) = self.tick.take() {
            cost::record(elapsed_cycles(start));
        }
        self.motors = motors;
    }
}
