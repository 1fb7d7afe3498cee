//! Two sectors of a flash, each known to be whole or not.
//!
//! An erase that loses its power leaves a sector with whatever it likes in it, such as the marks of
//! a full sector and none of its records. Who believes the marks then copies from that sector and
//! erases the other, which had everything. So each sector begins with a head of two words that says
//! whether it can be believed:
//!
//! | first word | second word | the sector |
//! |---|---|---|
//! | the mark `CHP1` | erased | was erased to the end and is in use |
//! | anything else | anything | is being erased, or was never ours |
//!
//! Before an erase the second word is written, after it the first. A sector that is not whole at the
//! start holds nothing that is needed, because it was given up or is foreign: it is erased again.
//!
//! The heads are hidden: [`Sectors`] is a flash with pages that are shorter by them, from address 0.

use core::ops::Range;

use embedded_storage_async::nor_flash::{ErrorType, NorFlash, ReadNorFlash};

/// Bytes of a word: what a flash writes at a time.
pub const WORD: usize = 4;
/// Bytes of a sector's head.
const HEAD: usize = 2 * WORD;
/// How many sectors there are. One is in use, the other is empty but for the moment in which what
/// is still needed moves over.
const SECTORS: usize = 2;
/// Says that a sector is whole, and which layout its records have.
const WHOLE: [u8; WORD] = *b"CHP1";
const ERASED: [u8; WORD] = [0xFF; WORD];
const GIVEN_UP: [u8; WORD] = [0; WORD];

/// The flash behind its heads. `F` writes words of four bytes, and its erase unit is the sector.
#[derive(Debug)]
pub struct Sectors<F> {
    flash: F,
    start: u32,
    in_use: usize,
    /// Where each sector was written last, from its start: behind that it is erased.
    written: [u32; SECTORS],
}

impl<F: NorFlash> Sectors<F> {
    const CHECKED: () = assert!(
        F::WRITE_SIZE == WORD && WORD.is_multiple_of(F::READ_SIZE) && F::ERASE_SIZE > 2 * HEAD,
        "a flash of words of four bytes is needed"
    );
    const SECTOR: u32 = F::ERASE_SIZE as u32;
    /// Bytes of a page: a sector without its head.
    const PAGE: u32 = Self::SECTOR - HEAD as u32;
    /// All of it.
    pub const RANGE: Range<u32> = 0..SECTORS as u32 * Self::PAGE;

    /// The two sectors of `flash` that begin at its address `start`. What is not whole is erased.
    ///
    /// # Errors
    /// Those of the flash.
    pub async fn open(flash: F, start: u32) -> Result<Self, F::Error> {
        let () = Self::CHECKED;
        let mut sectors = Self { flash, start, in_use: 0, written: [0; SECTORS] };
        for sector in 0..SECTORS {
            let mut head = [0; HEAD];
            let address = sectors.start_of(sector);
            sectors.flash.read(address, &mut head).await?;
            if head.split_at(WORD) != (&WHOLE, &ERASED) {
                sectors.renew(sector).await?;
            }
        }
        Ok(sectors)
    }

    /// Bytes that can be written before a sector must be erased; 0 before the first write.
    pub fn room(&self) -> usize {
        // The last word of a page is its mark of being full.
        let end = Self::PAGE - WORD as u32;
        match self.written.get(self.in_use) {
            Some(&written @ 1..) => end.saturating_sub(written) as usize,
            _ => 0,
        }
    }

    fn start_of(&self, sector: usize) -> u32 {
        self.start + sector as u32 * Self::SECTOR
    }

    /// The sector of an address, and the address from the page's start.
    const fn place(address: u32) -> (usize, u32) {
        ((address / Self::PAGE) as usize, address % Self::PAGE)
    }

    fn physical(&self, address: u32) -> u32 {
        let (sector, within) = Self::place(address);
        self.start_of(sector) + HEAD as u32 + within
    }

    /// Gives a sector up, erases it, and declares it whole.
    async fn renew(&mut self, sector: usize) -> Result<(), F::Error> {
        let start = self.start_of(sector);
        let mut second = ERASED;
        self.flash.read(start + WORD as u32, &mut second).await?;
        // No word is written twice: if it is not erased, the sector is not whole already.
        if second == ERASED {
            self.flash.write(start + WORD as u32, &GIVEN_UP).await?;
        }
        self.flash.erase(start, start + Self::SECTOR).await?;
        self.flash.write(start, &WHOLE).await?;
        if let Some(written) = self.written.get_mut(sector) {
            *written = 0;
        }
        Ok(())
    }
}

impl<F: NorFlash> ErrorType for Sectors<F> {
    type Error = F::Error;
}

impl<F: NorFlash> ReadNorFlash for Sectors<F> {
    const READ_SIZE: usize = WORD;

    async fn read(&mut self, address: u32, bytes: &mut [u8]) -> Result<(), F::Error> {
        self.flash.read(self.physical(address), bytes).await
    }

    fn capacity(&self) -> usize {
        Self::RANGE.end as usize
    }
}

impl<F: NorFlash> NorFlash for Sectors<F> {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = Self::PAGE as usize;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), F::Error> {
        for sector in Self::place(from).0..Self::place(to).0 {
            self.renew(sector).await?;
        }
        Ok(())
    }

    async fn write(&mut self, address: u32, bytes: &[u8]) -> Result<(), F::Error> {
        self.flash.write(self.physical(address), bytes).await?;
        let (sector, within) = Self::place(address);
        let end = within + bytes.len() as u32;
        // The mark of being full is no record.
        if end < Self::PAGE
            && let Some(written) = self.written.get_mut(sector)
        {
            self.in_use = sector;
            *written = end.max(*written);
        }
        Ok(())
    }
}
