//! A flash as an STM32F407 has it, whose power can be cut in the middle of any word and any erase.
//!
//! Erased bits are 1. Programming clears bits, a word at a time, and an erase sets all bits of a
//! sector. A word that was programmed must be erased before it is programmed again. After a cut the
//! word or the sector under way holds anything.

use std::cell::RefCell;
use std::rc::Rc;

use embedded_storage_async::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};

/// Bytes of a sector.
pub const SECTOR: usize = 16 * 1024;
const SECTORS: usize = 2;
const WORD: usize = 4;

/// What a cut leaves of the word or the sector under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tear {
    /// Nothing was done yet.
    Before,
    /// Everything was done, and nobody learned of it.
    After,
    /// Bits by chance: of a word some are not cleared, of a sector some are not set.
    Noise,
    /// The first half is done.
    FirstHalf,
    /// The second half is done.
    SecondHalf,
    /// All bits are cleared: a flash does so before it erases.
    Cleared,
}

/// Every one of them.
pub const TEARS: [Tear; 6] =
    [Tear::Before, Tear::After, Tear::Noise, Tear::FirstHalf, Tear::SecondHalf, Tear::Cleared];

/// The flash has no power.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoPower;

impl NorFlashError for NoPower {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

struct Cells {
    bytes: Vec<u8>,
    /// Words that a cut has left in any state, and that may be programmed once more.
    torn: Vec<bool>,
    /// Words and erases since the flash was made.
    operations: u64,
    erases: [u64; SECTORS],
    cut: Option<(u64, Tear)>,
    powered: bool,
    may_erase: bool,
    chance: u32,
}

/// A handle to the flash: all clones are the same one.
#[derive(Clone)]
pub struct Flash(Rc<RefCell<Cells>>);

impl Flash {
    /// An erased flash.
    pub fn new() -> Self {
        Self::holding(vec![0xFF; SECTORS * SECTOR])
    }

    /// A flash with something in it.
    pub fn holding(bytes: Vec<u8>) -> Self {
        assert_eq!(bytes.len(), SECTORS * SECTOR);
        let torn = vec![false; bytes.len() / WORD];
        Self(Rc::new(RefCell::new(Cells {
            bytes,
            torn,
            operations: 0,
            erases: [0; SECTORS],
            cut: None,
            powered: true,
            may_erase: true,
            chance: 0x9E37_79B9,
        })))
    }

    /// A flash that somebody else has left like this: any word of it may be torn.
    pub fn left_with(bytes: Vec<u8>) -> Self {
        let flash = Self::holding(bytes);
        flash.0.borrow_mut().torn.fill(true);
        flash
    }

    /// Cuts the power in the operation with this number, counted from the next, which is 0.
    pub fn cut_at(&self, operation: u64, tear: Tear) {
        let mut cells = self.0.borrow_mut();
        cells.cut = Some((cells.operations + operation, tear));
        // Another noise for every cut.
        cells.chance ^= u32::try_from(operation & 0xFFFF).unwrap().wrapping_mul(0x85EB_CA6B) | 1;
    }

    /// Whether there is power.
    pub fn powered(&self) -> bool {
        self.0.borrow().powered
    }

    /// The power is back, and stays.
    pub fn repower(&self) {
        let mut cells = self.0.borrow_mut();
        cells.powered = true;
        cells.cut = None;
    }

    /// Words and erases so far.
    pub fn operations(&self) -> u64 {
        self.0.borrow().operations
    }

    /// Erases of each sector so far.
    pub fn erases(&self) -> [u64; SECTORS] {
        self.0.borrow().erases
    }

    /// From now on an erase is a failure of the test, or is none again.
    pub fn allow_erase(&self, may_erase: bool) {
        self.0.borrow_mut().may_erase = may_erase;
    }

    /// What it holds.
    pub fn bytes(&self) -> Vec<u8> {
        self.0.borrow().bytes.clone()
    }
}

impl Cells {
    /// Counts an operation; how it is torn if it is the one.
    fn begin(&mut self) -> Result<Option<Tear>, NoPower> {
        if !self.powered {
            return Err(NoPower);
        }
        let number = self.operations;
        self.operations += 1;
        let tear = self.cut.filter(|(at, _)| *at == number).map(|(_, tear)| tear);
        self.powered = tear.is_none();
        Ok(tear)
    }

    /// Marsaglia's xorshift.
    fn noise(&mut self) -> u8 {
        self.chance ^= self.chance << 13;
        self.chance ^= self.chance >> 17;
        self.chance ^= self.chance << 5;
        self.chance.to_le_bytes()[1]
    }

    fn program(&mut self, address: usize, word: &[u8]) -> Result<(), NoPower> {
        let tear = self.begin()?;
        let index = address / WORD;
        let range = address..address + WORD;
        let erased = self.bytes[range.clone()].iter().all(|byte| *byte == 0xFF);
        assert!(erased || self.torn[index], "the word at {address:#x} is programmed twice");
        self.torn[index] = tear.is_some();
        for (offset, byte) in word.iter().enumerate() {
            let cleared = match tear {
                None | Some(Tear::After) => *byte,
                Some(Tear::Before) => 0xFF,
                Some(Tear::Noise) => *byte | self.noise(),
                Some(Tear::FirstHalf) => {
                    if offset < WORD / 2 {
                        *byte
                    } else {
                        0xFF
                    }
                }
                Some(Tear::SecondHalf) => {
                    if offset < WORD / 2 {
                        0xFF
                    } else {
                        *byte
                    }
                }
                // One bit of each byte is still missing.
                Some(Tear::Cleared) => *byte | (byte.wrapping_neg() & !*byte) | 0x10,
            };
            self.bytes[range.start + offset] &= cleared;
        }
        if tear.is_some() { Err(NoPower) } else { Ok(()) }
    }

    fn erase(&mut self, sector: usize) -> Result<(), NoPower> {
        assert!(self.may_erase, "an erase where none is allowed");
        let tear = self.begin()?;
        self.erases[sector] += 1;
        let start = sector * SECTOR;
        for offset in 0..SECTOR {
            let set = match tear {
                None | Some(Tear::After) => 0xFF,
                Some(Tear::Before) => 0,
                Some(Tear::Noise) => self.noise(),
                Some(Tear::FirstHalf) => {
                    if offset < SECTOR / 2 {
                        0xFF
                    } else {
                        0
                    }
                }
                Some(Tear::SecondHalf) => {
                    if offset < SECTOR / 2 {
                        0
                    } else {
                        0xFF
                    }
                }
                Some(Tear::Cleared) => {
                    self.bytes[start + offset] = 0;
                    0
                }
            };
            self.bytes[start + offset] |= set;
            self.torn[(start + offset) / WORD] = tear.is_some();
        }
        if tear.is_some() { Err(NoPower) } else { Ok(()) }
    }
}

impl ErrorType for Flash {
    type Error = NoPower;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NoPower> {
        let cells = self.0.borrow();
        if !cells.powered {
            return Err(NoPower);
        }
        let start = usize::try_from(offset).unwrap();
        bytes.copy_from_slice(&cells.bytes[start..start + bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        SECTORS * SECTOR
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), NoPower> {
        let sectors = [from, to].map(|address| usize::try_from(address).unwrap());
        assert!(sectors.iter().all(|address| address % SECTOR == 0), "whole sectors are erased");
        (sectors[0] / SECTOR..sectors[1] / SECTOR).try_for_each(|sector| self.0.borrow_mut().erase(sector))
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NoPower> {
        let start = usize::try_from(offset).unwrap();
        assert!(start.is_multiple_of(WORD) && bytes.len().is_multiple_of(WORD), "whole words are programmed");
        let mut cells = self.0.borrow_mut();
        bytes.chunks(WORD).enumerate().try_for_each(|(index, word)| cells.program(start + index * WORD, word))
    }
}
