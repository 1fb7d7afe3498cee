//! The images that `cargo xtask firmware` built are fit to be flashed; spoiled in any way, they are not.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use flash::check::{check, erased};
use flash::image::Segment;
use flash::{Chip, Image, Problem, chip, probe};

const IMAGES: [&str; 2] = ["firmware-pile-stm32", "firmware-chassis-stm32"];

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/thumbv7em-none-eabihf/release").join(name)
}

fn bytes(name: &str) -> Vec<u8> {
    let path = path(name);
    fs::read(&path).unwrap_or_else(|error| {
        panic!("cannot read {}: {error}; build it with `cargo xtask firmware`", path.display())
    })
}

fn chip() -> Chip {
    Chip::of(&chip::target().unwrap()).unwrap()
}

/// What is wrong with the pile's image once it is spoiled.
fn spoiled(spoil: impl FnOnce(&mut Image)) -> Vec<Problem> {
    let mut image = Image::parse(&bytes("firmware-pile-stm32")).unwrap();
    spoil(&mut image);
    check(&image, &chip())
}

/// The segment with the vector table.
fn vectors(image: &mut Image) -> &mut Vec<u8> {
    &mut image.segments.iter_mut().find(|segment| segment.flashed_at == 0x0800_0000).unwrap().data
}

fn set_vector(image: &mut Image, index: usize, value: u32) {
    vectors(image)[4 * index..][..4].copy_from_slice(&value.to_le_bytes());
}

fn segment(flashed_at: u64, memory: u64, length: usize) -> Segment {
    Segment { flashed_at, data: vec![0; length], memory: memory..memory + length as u64 }
}

#[test]
fn the_images_are_fit_and_leave_the_stores_sectors_alone() {
    let target = chip::target().unwrap();
    for name in IMAGES {
        let image = Image::parse(&bytes(name)).unwrap();
        assert_eq!(check(&image, &chip()), [], "{name}");
        assert_eq!(image.store, Some(0x0800_4000..0x0800_C000));
        let erased = erased(&image, &chip());
        assert!(erased.iter().any(|sector| sector.start == 0x0800_0000), "the vector table is flashed");
        assert!(erased.iter().all(|sector| !(0x0800_4000..0x0800_C000).contains(&sector.start)));
        // What probe-rs would write is the image, byte by byte.
        let written: usize = probe::loader(&image, &target).unwrap().data().map(|(_, data)| data.len()).sum();
        assert_eq!(written, image.segments.iter().map(|segment| segment.data.len()).sum::<usize>());
    }
}

#[test]
fn a_part_in_the_stores_sectors_is_found() {
    let problems = spoiled(|image| image.segments.push(segment(0x0800_4100, 0x0800_4100, 4)));
    assert_eq!(problems, [Problem::InStore(0x0800_4100)]);
    // A program that is linked right behind the vector table reaches into them.
    let problems = spoiled(|image| image.segments.push(segment(0x0800_0200, 0x0800_0200, 0x4000)));
    assert_eq!(problems, [Problem::InStore(0x0800_4000)]);
}

#[test]
fn a_store_that_is_not_made_of_whole_sectors_behind_the_first_is_found() {
    for store in [0x0800_4000..0x0800_8004, 0x0800_0000..0x0800_4000, 0x0800_4000..0x0800_4000] {
        let problems = spoiled(|image| image.store = Some(store.clone()));
        assert!(problems.contains(&Problem::NoSectors(store)), "{problems:?}");
    }
    assert_eq!(spoiled(|image| image.store = None), [Problem::NoStore]);
}

#[test]
fn a_stack_that_begins_nowhere_is_found() {
    for address in [0, 0x2000_0000, 0x2002_0008, 0x0800_0000, 0x2001_FFFC, 0xFFFF_FFFF] {
        assert_eq!(spoiled(|image| set_vector(image, 0, address)), [Problem::Stack(address.into())]);
    }
}

#[test]
fn vectors_without_thumb_bit_or_to_nowhere_are_found() {
    assert_eq!(
        spoiled(|image| set_vector(image, 1, 0x0800_C000)),
        [Problem::NoThumb { index: 1, address: 0x0800_C000 }]
    );
    assert_eq!(spoiled(|image| set_vector(image, 1, 0)), [Problem::NoThumb { index: 1, address: 0 }]);
    for address in [0x0800_4001, 0x080F_FFF1, 0x2000_0001, 0x0800_0041] {
        // Of the UART, which is not looked at before the first byte comes.
        let problems = spoiled(|image| set_vector(image, 16 + 37, address));
        assert_eq!(problems, [Problem::Vector { index: 53, address: address.into() }]);
    }
}

#[test]
fn a_missing_or_short_vector_table_is_found() {
    let table = Problem::NoVectors(0x0800_0000);
    assert_eq!(spoiled(|image| vectors(image).truncate(63)).first(), Some(&table));
    assert_eq!(
        spoiled(|image| image.segments.retain(|it| it.flashed_at != 0x0800_0000)).first(),
        Some(&table)
    );
}

#[test]
fn parts_outside_of_the_chips_memories_are_found() {
    let beyond = segment(0x080F_FFF0, 0x080F_FFF0, 32);
    let problems = spoiled(|image| image.segments.push(beyond.clone()));
    assert_eq!(problems, [Problem::OutOfFlash(beyond.flashed()), Problem::OutOfMemory(beyond.memory)]);
    // Variables beyond the end of RAM, which begin as zeros.
    let many = Segment { data: Vec::new(), ..segment(0, 0x2001_0000, 0x1_0001) };
    let problems = spoiled(|image| image.segments.push(many.clone()));
    assert_eq!(problems, [Problem::OutOfMemory(many.memory)]);
    let twice = segment(0x0800_C010, 0x0800_C010, 4);
    assert_eq!(spoiled(|image| image.segments.push(twice)).len(), 1);
}

#[test]
fn a_file_that_is_no_image_is_refused_and_no_cut_of_one_panics() {
    assert!(Image::parse(b"not an ELF file").is_err());
    let whole = bytes("firmware-pile-stm32");
    let mut foreign = whole.clone();
    foreign[18] = 0x3E;
    assert!(matches!(Image::parse(&foreign), Err(flash::ImageError::Machine(0x3E))));
    for length in (0..4096).chain([whole.len() / 2, whole.len() - 1]) {
        assert!(Image::parse(&whole[..length]).is_err(), "cut after {length} bytes");
    }
}

/// The program itself, as `cargo xtask flash pile --dry-run` runs it.
#[test]
fn the_dry_run_says_what_it_would_do_and_what_is_wrong() {
    let dry_run = |image: &Path| {
        Command::new(env!("CARGO_BIN_EXE_flash")).arg(image).arg("--dry-run").output().unwrap()
    };
    let fit = dry_run(&path("firmware-pile-stm32"));
    let said = String::from_utf8(fit.stdout).unwrap();
    assert!(fit.status.success(), "{said}");
    assert!(said.contains("sectors to erase: 0x08000000 0x0800c000"), "{said}");
    assert!(said.contains("nothing was flashed"), "{said}");

    // The reset vector, behind the stack pointer, loses its thumb bit.
    let mut file = bytes("firmware-pile-stm32");
    let header = u32::from_le_bytes(file[28..32].try_into().unwrap()) as usize;
    let table = u32::from_le_bytes(file[header + 4..header + 8].try_into().unwrap()) as usize;
    file[table + 4] &= !1;
    let folder = env::temp_dir().join(format!("spoiled-image-{}", std::process::id()));
    fs::write(&folder, file).unwrap();
    let unfit = dry_run(&folder);
    fs::remove_file(&folder).unwrap();
    let said = String::from_utf8(unfit.stderr).unwrap();
    assert!(!unfit.status.success());
    assert!(said.contains("vector 1, 0x0800c000, has no thumb bit"), "{said}");
}
