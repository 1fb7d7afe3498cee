//! The microcontroller's flash as the store wants it.

use core::ops::Range;

use embassy_stm32::Peri;
use embassy_stm32::flash::{Blocking, Error, Flash};
use embassy_stm32::peripherals::FLASH;
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, ReadNorFlash};

/// Where the flash begins.
const FLASH_START: usize = 0x0800_0000;

unsafe extern "C" {
    /// Where the store's two sectors begin and end, by the memory map, which keeps the program out of
    /// them.
    static _store_start: u8;
    static _store_end: u8;
}

/// The store's sectors, from the start of the flash.
fn store() -> Range<u32> {
    let from_start = |symbol: *const u8| (symbol.addr() - FLASH_START) as u32;
    from_start(&raw const _store_start)..from_start(&raw const _store_end)
}

/// The whole flash to read, the store's two sectors to write and erase: nothing else of it can be
/// damaged. Writing takes some 16 microseconds a word and an erase up to half a second, for both of
/// which the processor stops when it runs from flash, as it does.
pub struct StoreFlash(Flash<'static, Blocking>);

impl StoreFlash {
    /// Where the store begins.
    #[must_use]
    pub fn start() -> u32 {
        store().start
    }

    pub(super) fn new(flash: Peri<'static, FLASH>) -> Self {
        Self(Flash::new_blocking(flash))
    }
}

/// Whether all bytes from `from` to before `to` are the store's.
fn checked(from: u32, to: u32) -> Result<(), Error> {
    let store = store();
    if from >= store.start && from <= to && to <= store.end { Ok(()) } else { Err(Error::Protected) }
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
        store().end as usize
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
