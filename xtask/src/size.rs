//! How much of the microcontroller's memory an image needs.

use std::fs;
use std::path::Path;

use object::elf::FileHeader32;
use object::read::elf::ElfFile;
use object::{Endianness, Object, ObjectSegment};
use serde::Deserialize;

use crate::command::{Failure, cargo};
use crate::firmware::{self, IMAGES};
use crate::setup;

/// Bytes of the STM32F407VG's flash.
const FLASH: u64 = 1024 * 1024;
/// Bytes of its RAM, without the core-coupled memory.
const RAM: u64 = 128 * 1024;
/// Where that RAM starts.
const RAM_START: u64 = 0x2000_0000;

/// What an image occupies, in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Code, constants, and the first values of variables.
    pub flash: u64,
    /// Variables; the stack takes what is left.
    pub ram: u64,
}

/// Prints the size of every image.
pub fn print() -> Result<(), Failure> {
    for (package, board) in IMAGES {
        let path = firmware::path(package, board);
        let size = of_file(&path)?;
        println!("{package} ({board}): {}", describe(size));
        if size.flash > FLASH || size.ram > RAM {
            return Err(Failure::new(
                format!("{} does not fit the STM32F407VG", path.display()),
                "make it smaller",
            ));
        }
    }
    Ok(())
}

/// The deepest stacks, in bytes, that the emulated images of both boards were seen to need.
#[derive(Deserialize)]
struct Stacks {
    #[serde(rename = "firmware-pile")]
    pile: u64,
    #[serde(rename = "firmware-chassis")]
    chassis: u64,
}

/// Builds every image and prints its size, and how deep the stacks get, which is measured in QEMU.
pub fn measure() -> Result<(), Failure> {
    let toolchain = setup::all()?;
    firmware::build(&toolchain)?;
    let printed = cargo("run --quiet --package tests --bin stack").output()?;
    let Stacks { pile, chassis } = serde_json::from_str(&printed).map_err(|error| {
        Failure::new(format!("the gauge printed {printed:?} ({error})"), "report this as a defect of xtask")
    })?;
    for (package, stack) in [("firmware-pile", pile), ("firmware-chassis", chassis)] {
        println!("{package}: stack {stack} bytes at the deepest, measured on the emulated image");
        for (_, board) in IMAGES.into_iter().filter(|(other, _)| *other == package) {
            let size = of_file(&firmware::path(package, board))?;
            if size.ram + stack > RAM {
                return Err(Failure::new(
                    format!("{package} ({board}) has only {} bytes for its stack", RAM - size.ram),
                    "make its variables or its stack smaller",
                ));
            }
        }
    }
    Ok(())
}

/// A size for a person.
pub fn describe(Size { flash, ram }: Size) -> String {
    let percent = |used: u64, whole: u64| used as f64 * 100.0 / whole as f64;
    format!(
        "flash {flash} bytes ({:.1} % of 1 MiB), RAM {ram} bytes ({:.1} % of 128 KiB, stack apart)",
        percent(flash, FLASH),
        percent(ram, RAM)
    )
}

/// The size of an image.
pub fn of_file(path: &Path) -> Result<Size, Failure> {
    let next = "build it with `cargo xtask firmware`";
    let elf = fs::read(path)
        .map_err(|error| Failure::new(format!("cannot read the image {}: {error}", path.display()), next))?;
    of_elf(&elf).map_err(|error| Failure::new(format!("{} is no ARM image: {error}", path.display()), next))
}

/// What is loaded: flash holds every byte that the file has, RAM every byte that lies there.
fn of_elf(elf: &[u8]) -> object::Result<Size> {
    let elf = ElfFile::<FileHeader32<Endianness>>::parse(elf)?;
    let mut size = Size { flash: 0, ram: 0 };
    for segment in elf.segments() {
        size.flash += segment.file_range().1;
        if (RAM_START..RAM_START + RAM).contains(&segment.address()) {
            size.ram += segment.size();
        }
    }
    Ok(size)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An ELF file of nothing but program headers: (address, bytes in the file, bytes in memory).
    fn elf(segments: &[(u32, u32, u32)]) -> Vec<u8> {
        let header: [&[u8]; 5] = [
            b"\x7fELF\x01\x01\x01\0\0\0\0\0\0\0\0\0\x02\0\x28\0\x01\0\0\0",
            &[0; 4],
            &52_u32.to_le_bytes(),
            &[0; 8],
            b"\x34\0\x20\0",
        ];
        let mut elf = header.concat();
        elf.extend([segments.len() as u8, 0, 0, 0, 0, 0, 0, 0]);
        for &(address, file, memory) in segments {
            for field in [1, 0, address, address, file, memory, 6, 4] {
                elf.extend(u32::to_le_bytes(field));
            }
        }
        elf
    }

    #[test]
    fn initialised_variables_count_in_flash_and_in_ram() {
        let elf = elf(&[(0x0800_0000, 1000, 1000), (0x2000_0000, 16, 16), (0x2000_0010, 0, 300)]);
        assert_eq!(of_elf(&elf).unwrap(), Size { flash: 1016, ram: 316 });
    }

    #[test]
    fn a_file_that_is_no_image_is_an_error() {
        assert!(of_elf(b"not an ELF file").is_err());
    }
}
