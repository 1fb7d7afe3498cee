//! Fields as the bytes of a file, so that a restart does not build them again.
//!
//! | bytes | hold |
//! |---|---|
//! | 64 | the header: eight words |
//! | 4 or 8 a cell and target | the distances, cell by cell |
//! | 1 a cell and target | the run table, then zeros up to a whole word |
//! | 8 a 64 cells of a row | the map, as in [`Grid::row`] |
//! | 8 a target | the targets' columns and rows |
//!
//! The words of the header: `CHFIELDS`; the version; a mark that tells the order of bytes; the number of
//! neighbours; width and height; the number of targets; the length of all; the CRC-32 of all but itself.
//! Numbers are in the order of the computer that wrote them, so that the tables can be used where they
//! are, in a file that is mapped into memory. The map and the targets are in the file, not a hash of them:
//! fields of others are never taken for these.

use super::{
    fields::Fields,
    image::{HEADER_BYTES, Image, Layout, Memory},
};
use crate::{
    grid::{Cell, Grid},
    moves::MoveSet,
};

const MAGIC: [u8; 8] = *b"CHFIELDS";
/// Grows with every change of the format, and of which of equally short ways is kept.
const VERSION: u64 = 2;
const ORDER: u64 = 0x0102_0304_0506_0708;

/// Why bytes are not the fields of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FileError {
    /// They are something else.
    #[error("these are no fields: expected a file that begins with `CHFIELDS`")]
    Foreign,
    /// Another version of the format.
    #[error("fields of version {found}: expected {VERSION}; build them again")]
    Version {
        /// The version.
        found: u64,
    },
    /// A computer with another order of bytes wrote them.
    #[error("fields that a computer with another order of bytes wrote: build them again")]
    Order,
    /// The fields of other moves, or of another map or other targets.
    #[error("fields of {what} than asked for: build them again")]
    Others {
        /// What is different.
        what: &'static str,
    },
    /// The end is missing, or something follows it.
    #[error(
        "{found} bytes of fields: expected {expected}; the file was cut off or added to: build them again"
    )]
    Length {
        /// How many there are.
        found: usize,
        /// How many there should be.
        expected: usize,
    },
    /// The checksum is wrong.
    #[error("damaged fields, their checksum is wrong: build them again")]
    Damaged,
}

impl Fields {
    /// The bytes of a file that [`Self::open`] reads.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let inputs = inputs(&self.grid, &self.targets);
        let tables = &self.image.memory.as_ref().as_ref()[HEADER_BYTES..self.image.layout.bytes()];
        let length = HEADER_BYTES + tables.len() + size_of_val(inputs.as_slice());
        let mut bytes = Vec::with_capacity(length);
        let mut header = header(&self.grid, self.moves, &self.targets, length);
        bytes.extend_from_slice(bytemuck::cast_slice(&header));
        bytes.extend_from_slice(tables);
        bytes.extend_from_slice(bytemuck::cast_slice(&inputs));
        header[7] = checksum(&bytes);
        bytes[..HEADER_BYTES].copy_from_slice(bytemuck::cast_slice(&header));
        bytes
    }

    /// The fields of `targets` on `grid` in the bytes of a file, which are used where they are. Whoever
    /// maps a file maps it privately: changes of the map are written to the bytes.
    ///
    /// # Errors
    /// [`FileError`] if they are damaged, or the fields of something else.
    pub fn open(
        grid: Grid,
        moves: MoveSet,
        targets: &[Cell],
        bytes: Box<dyn Memory>,
    ) -> Result<Self, FileError> {
        let layout = Layout::of(moves, grid.len(), targets.len());
        let image = check(&grid, moves, targets, &layout, bytes.as_ref().as_ref())?;
        let image = image.unwrap_or(Image { layout, memory: bytes });
        Ok(Self::over(grid, moves, targets, image))
    }
}

/// Checks the bytes of a file; returns a copy of the tables if they can't be used where they are.
fn check(
    grid: &Grid,
    moves: MoveSet,
    targets: &[Cell],
    layout: &Layout,
    bytes: &[u8],
) -> Result<Option<Image>, FileError> {
    let inputs = inputs(grid, targets);
    let expected = layout.bytes() + size_of_val(inputs.as_slice());
    let head = bytes.get(..HEADER_BYTES).filter(|head| head.starts_with(&MAGIC)).ok_or(FileError::Foreign)?;
    let found: [u64; 8] = bytemuck::pod_read_unaligned(head);
    let wanted = header(grid, moves, targets, expected);
    let [_, version, order, neighbours, sides, count, length, sum] = found;
    if u64::from_le(version) != VERSION {
        return Err(FileError::Version { found: u64::from_le(version) });
    }
    if order != ORDER {
        return Err(FileError::Order);
    }
    for (found, wanted, what) in [
        (neighbours, wanted[3], "other moves"),
        (sides, wanted[4], "another map"),
        (count, wanted[5], "other targets"),
    ] {
        if found != wanted {
            return Err(FileError::Others { what });
        }
    }
    if bytes.len() != expected || length != wanted[6] {
        return Err(FileError::Length { found: bytes.len(), expected });
    }
    if sum != checksum(bytes) {
        return Err(FileError::Damaged);
    }
    let stored = &bytes[layout.bytes()..];
    let wanted: &[u8] = bytemuck::cast_slice(&inputs);
    if stored != wanted {
        let map = size_of_val(grid.row(0)) * grid.height() as usize;
        let what = if stored[..map] == wanted[..map] { "other targets" } else { "another map" };
        return Err(FileError::Others { what });
    }
    let is_aligned = bytes.as_ptr().align_offset(align_of::<u64>()) == 0;
    Ok((!is_aligned).then(|| Image::copy_of(layout.clone(), bytes)))
}

/// The header, but for the checksum.
fn header(grid: &Grid, moves: MoveSet, targets: &[Cell], length: usize) -> [u64; 8] {
    let sides = u64::from(grid.width()) << 32 | u64::from(grid.height());
    let neighbours = moves.steps().len() as u64;
    let magic = u64::from_ne_bytes(MAGIC);
    [magic, VERSION.to_le(), ORDER, neighbours, sides, targets.len() as u64, length as u64, 0]
}

/// What the fields are made of: the map and the targets.
fn inputs(grid: &Grid, targets: &[Cell]) -> Vec<u64> {
    let rows = (0..grid.height() as i32).flat_map(|y| grid.row(y).iter().copied());
    let targets = targets.iter().map(|cell| u64::from(cell.x as u32) << 32 | u64::from(cell.y as u32));
    rows.chain(targets).collect()
}

/// Of all bytes but the last word of the header, which holds it.
fn checksum(bytes: &[u8]) -> u64 {
    let mut sum = crc32fast::Hasher::new();
    sum.update(&bytes[..HEADER_BYTES - 8]);
    sum.update(&bytes[HEADER_BYTES..]);
    sum.finalize().into()
}
