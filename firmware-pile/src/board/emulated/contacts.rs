//! A contactor that can only be seen in the log.

use crate::Contactor;
use crate::tasks::Contacts;

/// The emulated contactor: it does what it is told at once.
pub struct LoggedContactor {
    told: Contactor,
}

#[expect(clippy::new_without_default, reason = "a board has one contactor, made on purpose")]
impl LoggedContactor {
    /// An open contactor.
    pub const fn new() -> Self {
        Self { told: Contactor::Open }
    }
}

impl Contacts for LoggedContactor {
    fn command(&mut self, contactor: Contactor) {
        if contactor == self.told {
            return;
        }
        self.told = contactor;
        match contactor {
            Contactor::Open => defmt::info!("contactor open"),
            Contactor::Closed => defmt::info!("contactor closed"),
        }
    }

    fn closed(&self) -> bool {
        self.told == Contactor::Closed
    }
}
