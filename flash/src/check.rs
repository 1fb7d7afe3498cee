//! Whether an image can start, stays in its memories, and leaves the store alone.

use std::ops::Range;

use crate::chip::Chip;
use crate::image::Image;

/// Bytes of a vector.
const VECTOR: usize = 4;
/// The first vector is the stack pointer, the second where the core starts, and 14 more are the core's.
const CORE_VECTORS: usize = 16;
/// The stack pointer must be a multiple of this.
const STACK_ALIGNMENT: u64 = 8;

/// Why an image is not flashed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Problem {
    /// Something would be flashed where no flash is.
    #[error("{} bytes would be flashed to {:#010x}, where there is no flash", .0.end - .0.start, .0.start)]
    OutOfFlash(Range<u64>),
    /// Two parts would be flashed to one place.
    #[error("two parts of the image would be flashed to {0:#010x}")]
    Overlap(u64),
    /// Variables lie where no memory is.
    #[error("what runs at {:#010x} to {:#010x} is not in one memory", .0.start, .0.end)]
    OutOfMemory(Range<u64>),
    /// The image does not say where the store is.
    #[error("the image has no symbols _store_start and _store_end: link it with the repository's memory.x")]
    NoStore,
    /// The store is not made of whole sectors, or has the vector table in one of them.
    #[error("the store, {:#010x} to {:#010x}, is not made of whole flash sectors behind the first", .0.start, .0.end)]
    NoSectors(Range<u64>),
    /// Flashing would erase what the board remembers.
    #[error(
        "the image has something in the store's sectors, at {0:#010x}: flashing it would erase the board's identity"
    )]
    InStore(u64),
    /// The core finds no vector table.
    #[error("there is no whole vector table at {0:#010x}, where the core looks for it")]
    NoVectors(u64),
    /// The stack does not begin at the end of or in a memory.
    #[error("the stack would begin at {0:#010x}, which is not in a memory or no multiple of 8")]
    Stack(u64),
    /// A handler is called that is not there.
    #[error("vector {index} leads to {address:#010x}, where no code of the image is")]
    Vector {
        /// Which: 1 is the reset.
        index: usize,
        /// Where it leads.
        address: u64,
    },
    /// The core would leave Thumb state, which it cannot.
    #[error("vector {index}, {address:#010x}, has no thumb bit: the core would stop at once")]
    NoThumb {
        /// Which: 1 is the reset.
        index: usize,
        /// Where it leads.
        address: u64,
    },
}

/// All that is wrong with the image.
#[must_use]
pub fn check(image: &Image, chip: &Chip) -> Vec<Problem> {
    let mut problems = Vec::new();
    places(image, chip, &mut problems);
    store(image, chip, &mut problems);
    vectors(image, chip, &mut problems);
    problems
}

/// The flash sectors that flashing the image erases.
#[must_use]
pub fn erased(image: &Image, chip: &Chip) -> Vec<Range<u64>> {
    let touched =
        |sector: &&Range<u64>| image.segments.iter().any(|segment| meet(&segment.flashed(), sector));
    chip.sectors.iter().filter(touched).cloned().collect()
}

fn places(image: &Image, chip: &Chip, problems: &mut Vec<Problem>) {
    let mut flashed: Vec<Range<u64>> =
        image.segments.iter().map(|segment| segment.flashed()).filter(|range| !range.is_empty()).collect();
    problems
        .extend(flashed.iter().filter(|range| !within(range, &chip.flash)).cloned().map(Problem::OutOfFlash));
    flashed.sort_by_key(|range| range.start);
    problems.extend(
        flashed
            .windows(2)
            .filter(|pair| matches!(pair, [one, next] if one.end > next.start))
            .filter_map(|pair| pair.last().map(|next| Problem::Overlap(next.start))),
    );
    let is_somewhere =
        |memory: &Range<u64>| within(memory, &chip.flash) || chip.rams.iter().any(|ram| within(memory, ram));
    let memories = image.segments.iter().map(|segment| segment.memory.clone());
    problems.extend(memories.filter(|memory| !is_somewhere(memory)).map(Problem::OutOfMemory));
}

fn store(image: &Image, chip: &Chip, problems: &mut Vec<Problem>) {
    let Some(store) = &image.store else {
        problems.push(Problem::NoStore);
        return;
    };
    let behind_the_first = chip.sectors.get(1..).unwrap_or_default();
    let starts = behind_the_first.iter().any(|sector| sector.start == store.start);
    let ends = behind_the_first.iter().any(|sector| sector.end == store.end);
    if !starts || !ends || store.is_empty() {
        problems.push(Problem::NoSectors(store.clone()));
    }
    let inside = image.segments.iter().map(|segment| segment.flashed()).filter(|range| meet(range, store));
    problems.extend(inside.map(|range| Problem::InStore(range.start.max(store.start))));
}

fn vectors(image: &Image, chip: &Chip, problems: &mut Vec<Problem>) {
    let start = chip.flash.start;
    let table = image.segments.iter().find(|segment| segment.flashed_at == start);
    let Some(table) = table.filter(|table| table.data.len() >= CORE_VECTORS * VECTOR) else {
        problems.push(Problem::NoVectors(start));
        return;
    };
    let words = table.data.as_chunks::<VECTOR>().0.iter().map(|word| u64::from(u32::from_le_bytes(*word)));
    for (index, address) in words.enumerate() {
        match index {
            0 => {
                let fits = chip.rams.iter().any(|ram| ram.start < address && address <= ram.end);
                if !fits || !address.is_multiple_of(STACK_ALIGNMENT) {
                    problems.push(Problem::Stack(address));
                }
            }
            // Unused.
            _ if address == 0 && index > 1 => {}
            _ if address & 1 == 0 => problems.push(Problem::NoThumb { index, address }),
            _ => {
                let code = address & !1;
                if !image
                    .segments
                    .iter()
                    .any(|segment| segment.flashed_at > start && segment.flashed().contains(&code))
                {
                    problems.push(Problem::Vector { index, address });
                }
            }
        }
    }
}

fn within(inner: &Range<u64>, outer: &Range<u64>) -> bool {
    outer.start <= inner.start && inner.end <= outer.end
}

fn meet(one: &Range<u64>, other: &Range<u64>) -> bool {
    one.start < other.end && other.start < one.end
}
