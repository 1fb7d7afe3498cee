//! A contactor that can only be seen in the log.

use crate::Contactor;
use crate::tasks::Contacts;

/// The emulated contactor: it does what it is told at once.
pub struct LoggedContactor {
    told: Contactor,
}

impl LoggedContactor {
    /// An open contactor.
    pub(super) const fn new() -> Self {
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
