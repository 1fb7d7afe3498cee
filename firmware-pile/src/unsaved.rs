//! What of a pile's state is not in its store yet.
//!
//! The core compares what must outlive a restart with what it has asked to store. If that failed, it
//! does not know what is stored, and asks for all of it again after a while.

use protocol::{DurationMs, Epoch, Millis};

use crate::faults::FaultSet;
use crate::io::Records;
use crate::provisioning::Provisioning;
use crate::reports::Reports;
use crate::store::{Counters, Record};

/// How long after a failure the store is tried again.
const RETRY_INTERVAL: DurationMs = DurationMs(1_000);

/// What outlives a restart besides the journal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lasting {
    /// The highest epoch seen.
    pub epoch: Epoch,
    /// Latched faults.
    pub latched: FaultSet,
    /// The counters.
    pub counters: Counters,
}

/// What was asked to be stored.
#[derive(Clone, Copy, Debug)]
pub struct Unsaved {
    /// None of each if it must be stored whatever it is.
    epoch: Option<Epoch>,
    latched: Option<FaultSet>,
    counters: Option<Counters>,
    failed_at: Option<Millis>,
}

impl Unsaved {
    /// Just this is stored.
    #[must_use]
    pub const fn new(stored: Lasting) -> Self {
        let Lasting { epoch, latched, counters } = stored;
        Self { epoch: Some(epoch), latched: Some(latched), counters: Some(counters), failed_at: None }
    }

    /// The last step's records were not stored, or not all of them.
    pub const fn failed(&mut self, now: Millis) {
        *self = Self { epoch: None, latched: None, counters: None, failed_at: Some(now) };
    }

    /// Whether nobody knows what is stored.
    #[must_use]
    pub const fn has_failed(&self) -> bool {
        self.failed_at.is_some()
    }

    /// Puts what to store now into `records`, which are none yet.
    pub fn take(
        &mut self,
        now: Millis,
        lasting: Lasting,
        provisioning: &mut Provisioning,
        reports: &mut Reports,
        records: &mut Records,
    ) {
        if self.failed_at.is_some_and(|failed_at| now.since(failed_at) < RETRY_INTERVAL) {
            return;
        }
        self.failed_at = None;
        let Lasting { epoch, latched, counters } = lasting;
        let news = [
            provisioning.unsaved().map(Record::Identity),
            changed(&mut self.epoch, epoch).map(Record::Epoch),
            changed(&mut self.latched, latched).map(Record::Latched),
            changed(&mut self.counters, counters).map(Record::Counters),
        ];
        records.extend(news.into_iter().flatten());
        while !records.is_full() {
            let Some(record) = reports.record() else { break };
            // It fits.
            let _ = records.push(record);
        }
    }
}

fn changed<T: Copy + PartialEq>(stored: &mut Option<T>, now: T) -> Option<T> {
    (stored.replace(now) != Some(now)).then_some(now)
}
