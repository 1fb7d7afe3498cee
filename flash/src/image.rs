//! An ELF file: what is loaded where, and the store's place.

use std::ops::Range;

use object::elf::{EM_ARM, FileHeader32, PT_LOAD};
use object::read::elf::{ElfFile, FileHeader, ProgramHeader};
use object::{Endianness, Object, ObjectSymbol};

/// Something that is loaded, or takes memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Segment {
    /// Where its bytes are flashed.
    pub flashed_at: u64,
    /// Its bytes; less than it takes if the rest begins as zeros.
    pub data: Vec<u8>,
    /// What it takes when the program runs.
    pub memory: Range<u64>,
}

impl Segment {
    /// Where its bytes are flashed; empty if it has none.
    #[must_use]
    pub fn flashed(&self) -> Range<u64> {
        self.flashed_at..self.flashed_at + self.data.len() as u64
    }
}

/// A program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// In the order of the file.
    pub segments: Vec<Segment>,
    /// What the memory map keeps free for the store, if it says so.
    pub store: Option<Range<u64>>,
}

/// The file is no program for an ARM core.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// It is no ELF file, or a damaged one.
    #[error("it is no sound ELF file of 32 bits: {0}")]
    Elf(#[from] object::Error),
    /// Bytes that it speaks of are not in it.
    #[error("it is cut off")]
    CutOff,
    /// It is for another processor.
    #[error("it is for another processor than an ARM core (ELF machine {0})")]
    Machine(u16),
}

impl Image {
    /// Reads an ELF file.
    ///
    /// # Errors
    /// [`ImageError`].
    pub fn parse(bytes: &[u8]) -> Result<Self, ImageError> {
        let header = FileHeader32::<Endianness>::parse(bytes)?;
        let endian = header.endian()?;
        if header.e_machine(endian) != EM_ARM {
            return Err(ImageError::Machine(header.e_machine(endian)));
        }
        let mut segments = Vec::new();
        for segment in header.program_headers(endian, bytes)? {
            if segment.p_type(endian) != PT_LOAD || segment.p_memsz(endian) == 0 {
                continue;
            }
            let data = segment.data(endian, bytes).map_err(|()| ImageError::CutOff)?;
            let start = u64::from(segment.p_vaddr(endian));
            segments.push(Segment {
                flashed_at: u64::from(segment.p_paddr(endian)),
                data: data.to_vec(),
                memory: start..start + u64::from(segment.p_memsz(endian)),
            });
        }
        let elf = ElfFile::<FileHeader32<Endianness>>::parse(bytes)?;
        let address =
            |name| elf.symbols().find(|symbol| symbol.name() == Ok(name)).map(|symbol| symbol.address());
        let store = address("_store_start").zip(address("_store_end")).map(|(start, end)| start..end);
        Ok(Self { segments, store })
    }
}
