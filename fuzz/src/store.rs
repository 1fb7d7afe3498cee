//! What a flash holds, what is kept in it, and the power going at any moment.
//!
//! The first byte of an input says what the flash is like at the start: new, used, or left behind by
//! somebody else, with bytes of the input in it. What follows is done with the store, a few bytes for
//! each step.

use embassy_futures::block_on;
use firmware_pile::faults::FaultSet;
use firmware_pile::store::{Counters, JOURNAL, Kept, Record, Store};
use protocol::Epoch;

use crate::flash::{Flash, SECTOR, TEARS};
use crate::samples::{charge, identity, load, passes, with};
use crate::tried::Tried;

/// Records that a used flash has taken: the sectors are about to turn.
const USED: u32 = 380;
/// Steps of an input that are done.
const STEPS: usize = 60;

/// Does what the input says.
pub fn run(input: &[u8]) -> Tried {
    let mut input = Input(input);
    match input.byte() % 4 {
        0 => live(&Flash::new(), Kept::default(), &mut input),
        1 => {
            let (flash, kept) = used();
            live(&flash, kept, &mut input)
        }
        2 => find(vec![0xFF; 2 * SECTOR], &mut input),
        _ => find(used().0.bytes(), &mut input),
    }
}

/// A store that keeps everything it is given, whenever the power goes.
fn live(flash: &Flash, mut kept: Kept, input: &mut Input<'_>) -> Tried {
    let mut tried = Tried::default();
    let mut under_way = None;
    let mut store = None;
    for _ in 0..STEPS {
        let mut opened = match store.take() {
            Some(store) => store,
            None => match load(flash) {
                Ok((opened, found)) => {
                    assert!(found.boot > kept.boot, "start {} follows start {}", found.boot, kept.boot);
                    let without = Kept { boot: found.boot, ..kept };
                    let with = under_way.take().map(|record| with(without.clone(), &record));
                    assert!(found == without || Some(&found) == with.as_ref(), "{found:#?} for {without:#?}");
                    kept = found;
                    opened
                }
                Err(error) => {
                    assert!(!flash.powered(), "the store does not start: {error}");
                    flash.repower();
                    continue;
                }
            },
        };
        let Some(step) = Step::of(input) else { break };
        match step {
            Step::Restart => continue,
            Step::Cut(operation, tear) => flash.cut_at(operation, TEARS[tear]),
            Step::Keep(record) => {
                let appended = make_room_and_append(&mut opened, &record);
                tried.add(appended);
                if appended {
                    kept = with(kept, &record);
                } else {
                    assert!(!flash.powered(), "a record is refused");
                    flash.repower();
                    under_way = Some(record);
                    continue;
                }
            }
        }
        store = Some(opened);
    }
    tried
}

fn make_room_and_append(store: &mut Store<Flash>, record: &Record) -> bool {
    block_on(store.make_room()).is_ok() && block_on(store.append(record)).is_ok()
}

/// A flash with bytes of the input in it. It may be refused, but in words; what it is
/// given from then on, it keeps.
fn find(mut bytes: Vec<u8>, input: &mut Input<'_>) -> Tried {
    for _ in 0..input.byte() % 16 {
        let at = input.number() % bytes.len();
        let patch = input.bytes();
        let end = bytes.len().min(at + patch.len());
        bytes[at..end].copy_from_slice(&patch[..end - at]);
    }
    let flash = Flash::left_with(bytes);
    let mut tried = Tried::default();
    while let Some(step) = Step::of(input) {
        let Step::Keep(record) = step else { continue };
        let Ok((mut store, before)) = load(&flash) else { break };
        let appended = make_room_and_append(&mut store, &record);
        tried.add(appended);
        if appended {
            let (_, found) = load(&flash).expect("it has just been started");
            // Damage can hide records, and give them back when the sectors turn.
            assert_eq!(found, with(found.clone(), &record));
            assert!(found.boot > before.boot);
        }
    }
    tried
}

/// A flash with many records in it, and what it keeps.
fn used() -> (Flash, Kept) {
    thread_local! {
        static USED_FLASH: (Vec<u8>, Kept) = {
            let flash = Flash::new();
            let (mut store, mut kept) = load(&flash).expect("a new flash");
            for number in 0..USED {
                let record = record((number % 6) as u8, number as u8);
                assert!(make_room_and_append(&mut store, &record));
                kept = with(kept, &record);
            }
            (flash.bytes(), kept)
        };
    }
    USED_FLASH.with(|(bytes, kept)| (Flash::holding(bytes.clone()), kept.clone()))
}

enum Step {
    Keep(Record),
    Restart,
    Cut(u64, usize),
}

impl Step {
    fn of(input: &mut Input<'_>) -> Option<Self> {
        if input.0.is_empty() {
            return None;
        }
        Some(match input.byte() % 8 {
            kind @ 0..6 => Self::Keep(record(kind, input.byte())),
            6 => Self::Restart,
            // Most operations of a start or of a record are its first hundred.
            _ => Self::Cut(input.number() as u64 % 300, usize::from(input.byte()) % TEARS.len()),
        })
    }
}

fn record(kind: u8, value: u8) -> Record {
    let number = u32::from(value);
    let slot = value % JOURNAL as u8;
    match kind {
        0 => Record::Identity(identity()),
        1 => Record::Epoch(Epoch(number)),
        2 => Record::Latched(FaultSet::from_bits(number)),
        3 => Record::Counters(Counters { charges: number, live_s: number, claims: number }),
        4 => Record::Waiting(slot, if value < 0x80 { charge(1, number) } else { passes(1, number) }),
        _ => Record::Acknowledged(slot),
    }
}

/// What is left of an input; zeros follow.
struct Input<'a>(&'a [u8]);

impl<'a> Input<'a> {
    fn byte(&mut self) -> u8 {
        self.0.split_off_first().copied().unwrap_or(0)
    }

    fn number(&mut self) -> usize {
        usize::from(u16::from_le_bytes([self.byte(), self.byte()]))
    }

    /// As many as a byte says.
    fn bytes(&mut self) -> &'a [u8] {
        let length = usize::from(self.byte()).min(self.0.len());
        self.0.split_off(..length).unwrap_or_default()
    }
}
