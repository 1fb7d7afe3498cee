//! The STM32F407VG's memories and flash sectors, as probe-rs knows them.

use std::ops::Range;

use probe_rs::Target;
use probe_rs::config::{MemoryRegion, NvmRegion, Registry};

/// The boards' chip, by probe-rs' name.
pub const NAME: &str = "STM32F407VGTx";

/// Where things are in the chip.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chip {
    /// Where programs are flashed and the core starts from.
    pub flash: Range<u64>,
    /// What is erased at a time, in order.
    pub sectors: Vec<Range<u64>>,
    /// Memories for variables and the stack, in order; none touches another.
    pub rams: Vec<Range<u64>>,
}

/// Why the chip's map is not to be had.
#[derive(Debug, thiserror::Error)]
pub enum ChipError {
    /// This probe-rs does not know the chip.
    #[error("probe-rs does not know the {NAME}: {0}; update it")]
    Unknown(#[from] probe_rs::config::RegistryError),
    /// It knows it, but not its flash.
    #[error("probe-rs knows no flash of the {NAME} that it can start from; update it")]
    NoFlash,
}

/// The chip as probe-rs describes it.
///
/// # Errors
/// [`ChipError::Unknown`].
pub fn target() -> Result<Target, ChipError> {
    Ok(Registry::from_builtin_families().get_target_by_name(NAME)?)
}

impl Chip {
    /// The map of the chip.
    ///
    /// # Errors
    /// [`ChipError::NoFlash`].
    pub fn of(target: &Target) -> Result<Self, ChipError> {
        let boots = |region: &&MemoryRegion| region.as_nvm_region().is_some_and(NvmRegion::is_boot_memory);
        let flash = target
            .memory_map
            .iter()
            .find(boots)
            .map(MemoryRegion::address_range)
            .ok_or(ChipError::NoFlash)?;
        let properties = target
            .flash_algorithms
            .iter()
            .map(|algorithm| &algorithm.flash_properties)
            .find(|properties| properties.address_range == flash)
            .ok_or(ChipError::NoFlash)?;
        let mut sectors = Vec::new();
        let mut start = flash.start;
        while start < flash.end {
            let offset = start - flash.start;
            let size = properties
                .sectors
                .iter()
                .rev()
                .find(|sector| sector.address <= offset)
                .map(|sector| sector.size)
                .filter(|size| *size > 0)
                .ok_or(ChipError::NoFlash)?;
            sectors.push(start..start + size);
            start += size;
        }
        let rams = target.memory_map.iter().filter(|region| region.is_ram()).map(MemoryRegion::address_range);
        Ok(Self { flash, sectors, rams: merged(rams.collect()) })
    }
}

/// Ranges that touch become one.
fn merged(mut ranges: Vec<Range<u64>>) -> Vec<Range<u64>> {
    ranges.sort_by_key(|range| range.start);
    let mut merged: Vec<Range<u64>> = Vec::new();
    for range in ranges {
        match merged.last_mut() {
            Some(last) if last.end >= range.start => last.end = last.end.max(range.end),
            _ => merged.push(range),
        }
    }
    merged
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_chip_is_the_one_that_the_memory_map_describes() {
        let chip = Chip::of(&target().unwrap()).unwrap();
        assert_eq!(chip.flash, 0x0800_0000..0x0810_0000);
        assert_eq!(chip.rams, [0x1000_0000..0x1001_0000, 0x2000_0000..0x2002_0000]);
        let kib: Vec<u64> = chip.sectors.iter().map(|sector| (sector.end - sector.start) / 1024).collect();
        assert_eq!(kib, [16, 16, 16, 16, 64, 128, 128, 128, 128, 128, 128, 128]);
    }
}
