//! A charger that is a model, with a robot on its contacts until the test bench says otherwise.

use protocol::Millis;

use super::bench::{BATTERY, Ticks};
use crate::plant::Plant;
use crate::tasks::Charger;
use crate::{Contactor, Power, Sensors};

/// The modelled charger. Its contactor's commands show in the log.
pub struct ModelledCharger {
    plant: Plant,
    ticks: Ticks,
}

#[expect(clippy::new_without_default, reason = "a board has one charger, made on purpose")]
impl ModelledCharger {
    /// A sound charger, its contactor open.
    pub const fn new() -> Self {
        let mut plant = Plant::new();
        plant.battery = Some(BATTERY);
        Self { plant, ticks: Ticks::new() }
    }
}

impl Charger for ModelledCharger {
    fn sense(&mut self, now: Millis) -> Sensors {
        self.ticks.begin(&mut self.plant);
        let sensors = self.plant.sense(now);
        self.ticks.sensed();
        sensors
    }

    fn command(&mut self, power: Power) {
        self.ticks.command(&self.plant, power);
        if power.contactor != self.plant.power().contactor {
            match power.contactor {
                Contactor::Open => defmt::info!("contactor open"),
                Contactor::Closed => defmt::info!("contactor closed"),
            }
        }
        self.plant.command(power);
    }
}
