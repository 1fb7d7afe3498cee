//! What is kept, and how it looks in flash: a key of one byte, and a value in postcard.

use heapless::Vec;
use protocol::{
    BootEpoch, ChargeReport, DurationMs, Epoch, Key, Message, PassReport, PileId, PileParameters, Provision,
    ReportId,
};
use serde::{Deserialize, Serialize};

use crate::faults::FaultSet;

/// Reports that can wait for their acknowledgement.
pub const JOURNAL: usize = 8;

/// The most bytes of a value. A test knows the largest.
pub(super) const VALUE: usize = 220;

/// Who a board is: what [`protocol::Provision`] made of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Identity {
    /// Which pile.
    pub pile: PileId,
    /// The key that it shares with the coordinator.
    pub device_key: Key,
    /// The key that all piles of the site share.
    pub site_key: Key,
    /// No start has a lower number.
    pub boot_floor: BootEpoch,
    /// How it charges and what it bears.
    pub parameters: PileParameters,
}

impl Identity {
    /// Whether both are one pile with one key, whatever else they say.
    #[must_use]
    pub fn is_same_device(&self, other: &Self) -> bool {
        (self.pile, self.device_key, self.site_key) == (other.pile, other.device_key, other.site_key)
    }
}

impl From<&Provision> for Identity {
    fn from(provision: &Provision) -> Self {
        let Provision { command: _, pile, device_key, site_key, boot_floor, parameters } = *provision;
        Self { pile, device_key, site_key, boot_floor, parameters }
    }
}

/// What the pile did in its life.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counters {
    /// Charges that ended.
    pub charges: u32,
    /// For how long the contacts were live, in seconds.
    pub live_s: u32,
    /// Leases that the pile has made for itself: the number of the last.
    pub claims: u32,
}

impl Counters {
    /// Of a pile that has done nothing yet.
    pub const NONE: Self = Self { charges: 0, live_s: 0, claims: 0 };

    /// Another charge is over, under which the contacts were live for `live`.
    pub const fn count(&mut self, live: DurationMs) {
        self.charges = self.charges.saturating_add(1);
        self.live_s = self.live_s.saturating_add(live.0 / 1_000);
    }
}

/// A report that must reach the coordinator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Report {
    /// Of a charge.
    Charge(ChargeReport),
    /// Of robots that passed.
    Passes(PassReport),
}

impl Report {
    /// Its name.
    #[must_use]
    pub const fn id(&self) -> ReportId {
        match self {
            Self::Charge(report) => report.report,
            Self::Passes(report) => report.report,
        }
    }

    /// What is sent.
    #[must_use]
    pub fn message(&self) -> Message {
        match self {
            Self::Charge(report) => Message::ChargeReport(*report),
            Self::Passes(report) => Message::PassReport(report.clone()),
        }
    }
}

/// A place in the journal, from 0 to [`JOURNAL`] - 1.
pub type Slot = u8;

/// One change of what is kept. Each takes the place of the last of its kind.
#[derive(Clone, Debug, PartialEq)]
pub enum Record {
    /// Who the board is.
    Identity(Identity),
    /// The highest epoch seen.
    Epoch(Epoch),
    /// All latched faults.
    Latched(FaultSet),
    /// The counters.
    Counters(Counters),
    /// A report waits for its acknowledgement.
    Waiting(Slot, Report),
    /// The report in this place was acknowledged.
    Acknowledged(Slot),
}

/// Reports without acknowledgement, by their places.
pub type Journal = [Option<Report>; JOURNAL];

/// Everything that was kept.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Kept {
    /// Who the board is, if it is anybody.
    pub identity: Option<Identity>,
    /// Which of its starts this is.
    pub boot: BootEpoch,
    /// The highest epoch seen.
    pub epoch: Epoch,
    /// Faults that were not cleared.
    pub latched: FaultSet,
    /// The counters.
    pub counters: Counters,
    /// Reports without acknowledgement.
    pub journal: Journal,
}

/// The keys. A report's is [`FIRST_SLOT`] and its place.
pub(super) mod key {
    pub const BOOT: u8 = 0;
    pub const IDENTITY: u8 = 1;
    pub const EPOCH: u8 = 2;
    pub const LATCHED: u8 = 3;
    pub const COUNTERS: u8 = 4;
    /// Says nothing, and takes room.
    pub const FILLER: u8 = 5;
    pub const FIRST_SLOT: u8 = 16;
    /// How many there are.
    pub const ALL: usize = 6 + super::JOURNAL;
}

/// A value as it is in flash.
pub(super) type Value = Vec<u8, VALUE>;

impl Record {
    /// The key and the value.
    ///
    /// # Errors
    /// None: every record fits [`VALUE`].
    pub(super) fn encode(&self) -> postcard::Result<(u8, Value)> {
        let mut value = Value::new();
        let key = match self {
            Self::Identity(identity) => put(&mut value, key::IDENTITY, identity)?,
            Self::Epoch(epoch) => put(&mut value, key::EPOCH, epoch)?,
            Self::Latched(latched) => put(&mut value, key::LATCHED, &latched.bits())?,
            Self::Counters(counters) => put(&mut value, key::COUNTERS, counters)?,
            Self::Waiting(slot, report) => put(&mut value, key::FIRST_SLOT.saturating_add(*slot), report)?,
            Self::Acknowledged(slot) => key::FIRST_SLOT.saturating_add(*slot),
        };
        Ok((key, value))
    }
}

pub(super) fn put<T: Serialize>(value: &mut Value, key: u8, of: &T) -> postcard::Result<u8> {
    let mut bytes = [0; VALUE];
    let bytes = postcard::to_slice(of, &mut bytes)?;
    // It fits: both have the same size.
    value.extend_from_slice(bytes).map_err(|_| postcard::Error::SerializeBufferFull)?;
    Ok(key)
}

impl Kept {
    /// Takes a record in; a later one takes the place of an earlier one. Keys of a newer layout mean
    /// nothing here.
    ///
    /// # Errors
    /// The value is none of its kind.
    pub(super) fn take(&mut self, key: u8, value: &[u8]) -> postcard::Result<()> {
        match key {
            key::BOOT => self.boot = postcard::from_bytes(value)?,
            key::IDENTITY => self.identity = Some(postcard::from_bytes(value)?),
            key::EPOCH => self.epoch = postcard::from_bytes(value)?,
            key::LATCHED => self.latched = FaultSet::from_bits(postcard::from_bytes(value)?),
            key::COUNTERS => self.counters = postcard::from_bytes(value)?,
            _ => {
                let slot =
                    key.checked_sub(key::FIRST_SLOT).and_then(|slot| self.journal.get_mut(usize::from(slot)));
                if let Some(slot) = slot {
                    *slot = if value.is_empty() { None } else { Some(postcard::from_bytes(value)?) };
                }
            }
        }
        Ok(())
    }
}
