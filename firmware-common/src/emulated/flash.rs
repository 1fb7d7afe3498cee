//! Two sectors of flash in a file of the computer that runs the emulator.
//!
//! The file outlives the emulator, as flash outlives a loss of power. It has to be there, erased: as
//! many bytes `FF` as the two sectors have. Without one the flash is as volatile as the machine.

use core::ffi::CStr;
use core::mem::MaybeUninit;

use embedded_storage_async::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use semihosting::fs::File;
use semihosting::io::{Read, Seek, SeekFrom, Write};

/// Bytes of a sector, as the STM32F407's smallest have.
const SECTOR: usize = 16 * 1024;
const SIZE: usize = 2 * SECTOR;
const WORD: usize = 4;

/// The flash cannot do that.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlashError {
    /// Not whole words or sectors, or beyond the end.
    Misplaced,
    /// A word that is not erased would have to be set.
    NotErased,
    /// The file cannot be written.
    File,
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

/// The flash. Reads come from memory, writes go to the file too.
pub struct EmulatedFlash {
    cells: &'static mut [u8],
    file: Option<File>,
}

impl EmulatedFlash {
    /// The flash in the file `path`, or one that forgets. `None` when it has been taken before, or the
    /// file cannot be read.
    pub fn take(path: Option<&CStr>) -> Option<Self> {
        // Filled where it is: on its way there it would not fit the stack.
        let cells =
            cortex_m::singleton!(: [MaybeUninit<u8>; SIZE] = [const { MaybeUninit::uninit() }; SIZE])?;
        cells.fill(MaybeUninit::new(0xFF));
        // Safety: all of it was just filled.
        let cells: &'static mut [u8] = unsafe { cells.assume_init_mut() };
        let file = match path {
            None => None,
            Some(path) => {
                let mut file = File::options().read(true).write(true).open(path).ok()?;
                file.read_exact(cells).ok()?;
                Some(file)
            }
        };
        Some(Self { cells, file })
    }

    fn save(&mut self, from: usize, to: usize) -> Result<(), FlashError> {
        let (Some(file), Some(bytes)) = (&mut self.file, self.cells.get(from..to)) else { return Ok(()) };
        let written = file.seek(SeekFrom::Start(from as u64)).and_then(|_| file.write_all(bytes));
        written.map_err(|_| FlashError::File)
    }
}

impl ErrorType for EmulatedFlash {
    type Error = FlashError;
}

impl ReadNorFlash for EmulatedFlash {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        let start = offset as usize;
        let cells = self.cells.get(start..start + bytes.len()).ok_or(FlashError::Misplaced)?;
        bytes.copy_from_slice(cells);
        Ok(())
    }

    fn capacity(&self) -> usize {
        SIZE
    }
}

impl NorFlash for EmulatedFlash {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        let (from, to) = (from as usize, to as usize);
        if !from.is_multiple_of(SECTOR) || !to.is_multiple_of(SECTOR) {
            return Err(FlashError::Misplaced);
        }
        self.cells.get_mut(from..to).ok_or(FlashError::Misplaced)?.fill(0xFF);
        self.save(from, to)
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        let from = offset as usize;
        let to = from + bytes.len();
        if !from.is_multiple_of(WORD) || !to.is_multiple_of(WORD) {
            return Err(FlashError::Misplaced);
        }
        let cells = self.cells.get_mut(from..to).ok_or(FlashError::Misplaced)?;
        for (cell, byte) in cells.iter_mut().zip(bytes) {
            *cell &= *byte;
            if *cell != *byte {
                return Err(FlashError::NotErased);
            }
        }
        self.save(from, to)
    }
}
