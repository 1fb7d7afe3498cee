//! The microcontroller's flash as the store wants it.

use crate::store::{Record, Store};
use crate::tasks::Memory;
use embassy_stm32::Peri;
use embassy_stm32::flash::{Blocking, Error, Flash};
use embassy_stm32::peripherals::FLASH;
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, ReadNorFlash};

/// Where the store's two sectors begin and end, from the start of the flash. The memory map keeps the
/// program out of them.
const STORE: core::ops::Range<u32> = 0x4000..0xC000;

/// The whole flash to read, the store's two sectors to write and erase: nothing else of it can be
/// damaged. Writing takes some 16 microseconds a word and an erase up to half a second, for both of
/// which the processor stops when it runs from flash, as it does.
pub struct StoreFlash(Flash<'static, Blocking>);

impl StoreFlash {
    /// Where the store begins.
    pub const START: u32 = STORE.start;

    pub(super) fn new(flash: Peri<'static, FLASH>) -> Self {
        Self(Flash::new_blocking(flash))
    }
}

/// Whether all bytes from `from` to before `to` are the store's.
fn checked(from: u32, to: u32) -> Result<(), Error> {
    if from >= STORE.start && from <= to && to <= STORE.end { Ok(()) } else { Err(Error::Protected) }
}

impl ErrorType for StoreFlash {
    type Error = Error;
}

impl ReadNorFlash for StoreFlash {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Error> {
        self.0.blocking_read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        STORE.end as usize
    }
}

impl NorFlash for StoreFlash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = 16 * 1024;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Error> {
        checked(from, to)?;
        self.0.blocking_erase(from, to)
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Error> {
        checked(offset, offset.saturating_add(bytes.len() as u32))?;
        self.0.blocking_write(offset, bytes)
    }
}

impl Memory for Store<StoreFlash> {
    async fn store(&mut self, record: Record) {
        if let Err(error) = self.append(&record).await {
            defmt::error!("store: {}", defmt::Display2Format(&error));
        }
    }
}
