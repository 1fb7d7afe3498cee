//! A charger that is a model, with a robot on its contacts.

use protocol::Millis;

use crate::plant::{Battery, Plant};
use crate::tasks::Charger;
use crate::{Contactor, Power, Sensors};

/// Of the robot that stands on the contacts.
const BATTERY: Battery = Battery::new(1.0e6, 0.5e6);

/// The modelled charger. Its contactor's commands show in the log.
pub struct ModelledCharger {
    plant: Plant,
}

#[expect(clippy::new_without_default, reason = "a board has one charger, made on purpose")]
impl ModelledCharger {
    /// A sound charger, its contactor open.
    pub const fn new() -> Self {
        let mut plant = Plant::new();
        plant.battery = Some(BATTERY);
        Self { plant }
    }
}

impl Charger for ModelledCharger {
    fn sense(&mut self, now: Millis) -> Sensors {
        self.plant.sense(now)
    }

    fn command(&mut self, power: Power) {
        if power.contactor != self.plant.power().contactor {
            match power.contactor {
                Contactor::Open => defmt::info!("contactor open"),
                Contactor::Closed => defmt::info!("contactor closed"),
            }
        }
        self.plant.command(power);
    }
}
