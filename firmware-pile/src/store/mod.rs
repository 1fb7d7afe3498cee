//! What a pile must not forget: who it is, which start this is, the highest epoch, latched faults,
//! and reports that nobody has acknowledged.
//!
//! # Layout
//! One map of [`sequential_storage`] over two sectors of 16 KiB, which is the least it takes: one
//! sector is written, record after record, the other is empty. When the first is full, the newest
//! record of every key moves over and the first is erased. A queue for the journal would need two
//! sectors of its own, and would mark what is read by writing a word a second time. So the journal
//! is [`JOURNAL`] keys of the map: a report waits under one of them, and its acknowledgement is an
//! empty value under the same key. [`sectors`] keeps an erase that loses its power from costing the
//! other sector.
//!
//! # Time and power
//! Writing a record programs tens of words at 16 µs each and may happen under live contacts. An
//! erase stops the processor for up to half a second, because it runs from the same flash, and so
//! happens only while the contacts are dead: [`Store::make_room`] erases, [`Store::append`] never
//! does. A record that was appended was also read back: it is there after any loss of power. One
//! whose append was interrupted is there or not, and nothing else is touched.
//!
//! # Use
//! ```
//! # use embedded_storage_async::nor_flash::NorFlash;
//! use firmware_pile::store::{Record, Store, StoreError};
//! use protocol::Epoch;
//!
//! # async fn example<F: NorFlash>(flash: F) -> Result<(), StoreError<F::Error>> {
//! // Sectors 1 and 2 of an STM32F407, in its flash as a whole; this counts the start.
//! let (mut store, kept) = Store::load(flash, 0x4000).await?;
//! assert!(kept.identity.is_none(), "a board from the factory");
//! store.append(&Record::Epoch(Epoch(7))).await?;
//! // Once the contacts are dead:
//! store.make_room().await?;
//! # Ok(())
//! # }
//! ```

use embedded_storage_async::nor_flash::NorFlash;
use protocol::BootEpoch;
use sequential_storage::cache::{
    Cache, CacheImpl, key_pointers::ArrayKeyPointers, page_pointers::ArrayPagePointers,
    page_states::ArrayPageStates,
};
use sequential_storage::map::{MapConfig, MapStorage};

mod record;
pub mod sectors;

pub use record::{Counters, Identity, JOURNAL, Journal, Kept, Record, Report, Slot};
use record::{VALUE, Value, key, put};
use sectors::{Sectors, WORD};

/// Bytes that are free when a charge begins: more than the most that one writes. A test measures
/// that.
pub const ROOM: usize = 1024;

/// How often a record is written that does not read back.
const ATTEMPTS: usize = 3;
/// Bytes of a record besides its value: the map's, and its key.
const ITEM: usize = 8;
const KEY: usize = 1;
/// Bytes of the shortest record.
const SHORTEST: usize = ITEM + WORD;

/// Why something is not kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StoreError<E> {
    /// The flash does not do as it is told.
    #[error("the flash fails ({0:?}): replace the board")]
    Flash(E),
    /// There is no room without an erase.
    #[error("the store is full: it makes room once the contacts are dead")]
    Full,
    /// What was written reads as something else.
    #[error("the flash does not keep what is written: replace the board")]
    Unreadable,
    /// What is stored is nothing that this software writes.
    #[error("the store holds what this software cannot read: flash the software that wrote it")]
    Foreign,
    /// The map is beyond repair.
    #[error("the store is damaged: erase its two sectors and provision the board again")]
    Damaged,
}

impl<E> From<sequential_storage::Error<E>> for StoreError<E> {
    fn from(error: sequential_storage::Error<E>) -> Self {
        match error {
            sequential_storage::Error::Storage { value } => Self::Flash(value),
            sequential_storage::Error::FullStorage => Self::Full,
            sequential_storage::Error::SerializationError(_) => Self::Foreign,
            _ => Self::Damaged,
        }
    }
}

/// Where the map finds records without reading all of them.
type Index = Cache<ArrayPageStates<2>, ArrayPagePointers<2>, ArrayKeyPointers<u8, { key::ALL }>, u8>;

/// What the map works in: a key and a value, rounded up to words.
#[repr(align(4))]
struct Buffer([u8; (KEY + VALUE).next_multiple_of(WORD)]);

/// The store in a flash.
pub struct Store<F: NorFlash> {
    map: MapStorage<u8, Sectors<F>, Index>,
    buffer: Buffer,
}

impl<F: NorFlash> Store<F> {
    /// Opens the store in the two sectors of `flash` that begin at its address `start`, and counts
    /// this start: when it returns, the number is stored. May erase.
    ///
    /// # Errors
    /// [`StoreError`]; the board must then not be used.
    pub async fn load(flash: F, start: u32) -> Result<(Self, Kept), StoreError<F::Error>> {
        let sectors = Sectors::open(flash, start).await.map_err(StoreError::Flash)?;
        let mut buffer = Buffer([0; _]);
        // Nothing that was learned earlier may answer for what is in flash now.
        let mut map = MapStorage::new(sectors, config(), Cache::new_uncached());
        let mut kept = read_all(&mut map, &mut buffer).await?;
        let floor = kept.identity.map_or(BootEpoch(0), |identity| identity.boot_floor);
        kept.boot = BootEpoch(kept.boot.0.saturating_add(1)).max(floor);
        let mut value = Value::new();
        put(&mut value, key::BOOT, &kept.boot).map_err(|_| StoreError::Foreign)?;
        // This is the first record after whatever the loss of power left behind. A torn head and
        // the bytes after it can look like a whole record that hides the one written there
        // (sequential-storage's issue 136): then it does not read back, and goes behind.
        write(&mut map, &mut buffer, key::BOOT, &value, |_| true).await?;
        let (sectors, _) = map.destroy();
        let index = Cache::new(ArrayPageStates::new(), ArrayPagePointers::new(), ArrayKeyPointers::new());
        let map = MapStorage::new(sectors, config(), index);
        Ok((Self { map, buffer }, kept))
    }

    /// Keeps a record: when this returns, it is stored. Never erases.
    ///
    /// # Errors
    /// [`StoreError::Full`] if it does not fit; others if the flash fails. The record may be kept all
    /// the same.
    pub async fn append(&mut self, record: &Record) -> Result<(), StoreError<F::Error>> {
        let (key, value) = record.encode().map_err(|_| StoreError::Foreign)?;
        let fits = |sectors: &Sectors<F>| sectors.room() >= space(value.len());
        write(&mut self.map, &mut self.buffer, key, &value, fits).await
    }

    /// Makes room for the records of a charge, if there is not enough. May erase: the contacts must
    /// be dead.
    ///
    /// # Errors
    /// [`StoreError`] if the flash fails.
    pub async fn make_room(&mut self) -> Result<(), StoreError<F::Error>> {
        if self.room() >= ROOM {
            return Ok(());
        }
        const NOTHING: [u8; VALUE] = [0; VALUE];
        // The map turns to the other sector when a record does not fit: the rest is filled up. The
        // last filler moves over, so it is short.
        loop {
            let room = self.room();
            let length = filler(room);
            let nothing = NOTHING.get(..length).unwrap_or(&NOTHING);
            self.map.store_item(&mut self.buffer.0, &key::FILLER, &nothing).await?;
            if self.room() > room {
                break;
            }
        }
        if self.room() < ROOM { Err(StoreError::Full) } else { Ok(()) }
    }

    /// Bytes that can be written without an erase.
    pub fn room(&mut self) -> usize {
        self.map.flash().room()
    }
}

const fn config<F: NorFlash>() -> MapConfig<Sectors<F>> {
    const { MapConfig::new(Sectors::<F>::RANGE) }
}

/// Bytes that a record takes.
const fn space(value: usize) -> usize {
    ITEM + (KEY + value).next_multiple_of(WORD)
}

/// The length of the next filler's value: as long as possible, but leaving room for a short one, or
/// none.
fn filler(room: usize) -> usize {
    let space = if room < 2 * SHORTEST { room } else { room - SHORTEST };
    space.saturating_sub(ITEM + KEY).min(VALUE - KEY)
}

async fn read_all<F: NorFlash, C: CacheImpl<u8>>(
    map: &mut MapStorage<u8, Sectors<F>, C>,
    buffer: &mut Buffer,
) -> Result<Kept, StoreError<F::Error>> {
    let mut kept = Kept::default();
    let mut items = map.fetch_all_items(&mut buffer.0).await?;
    while let Some((key, value)) = items.next::<&[u8]>(&mut buffer.0).await? {
        kept.take(key, value).map_err(|_| StoreError::Foreign)?;
    }
    Ok(kept)
}

/// Writes a record until it reads back, as long as it fits.
async fn write<F: NorFlash, C: CacheImpl<u8>>(
    map: &mut MapStorage<u8, Sectors<F>, C>,
    buffer: &mut Buffer,
    key: u8,
    value: &Value,
    fits: impl Fn(&Sectors<F>) -> bool,
) -> Result<(), StoreError<F::Error>> {
    for _ in 0..ATTEMPTS {
        if !fits(map.flash()) {
            return Err(StoreError::Full);
        }
        map.store_item(&mut buffer.0, &key, &value.as_slice()).await?;
        if map.fetch_item::<&[u8]>(&mut buffer.0, &key).await? == Some(value.as_slice()) {
            return Ok(());
        }
    }
    Err(StoreError::Unreadable)
}
