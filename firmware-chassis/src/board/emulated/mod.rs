//! What QEMU's machine does not have: wheels, gyroscope and battery, which are a [`Plant`] here, and
//! a test bench that breaks them. The machine itself is [`firmware_common::emulated`].

mod bench;
mod cost;

pub use bench::serve;

use cortex_m::peripheral::SYST;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use firmware_common::emulated::elapsed_cycles;

use crate::plant::Plant;
use crate::tasks::Body;
use crate::{Motors, Parameters, Sensors};
use bench::Order;

/// Orders of the test bench that wait for the next tick.
static ORDERS: Channel<CriticalSectionRawMutex, Order, 4> = Channel::new();

/// The counters start close to where they wrap, so that every run wraps them.
const COUNTERS: [u16; 4] = [0, u16::MAX, 65_000, 500];

/// A robot that is a model.
pub struct ModelledBody {
    plant: Plant,
    motors: Motors,
    /// When the tick began that is not over.
    tick: Option<u32>,
}

impl ModelledBody {
    /// The robot of these parameters, at rest and full.
    #[must_use]
    pub fn new(parameters: &Parameters) -> Self {
        Self { plant: Plant::new(parameters, COUNTERS), motors: Motors::Brake, tick: None }
    }
}

impl Body for ModelledBody {
    fn sense(&mut self) -> Sensors {
        while let Ok(order) = ORDERS.try_receive() {
            bench::obey(order, &mut self.plant);
        }
        let sensors = self.plant.advance(self.motors);
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
