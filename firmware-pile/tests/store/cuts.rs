//! The power is cut in every word and every erase.

use embassy_futures::block_on;
use firmware_pile::faults::FaultSet;
use firmware_pile::store::{Counters, Kept, Record};
use proptest::prelude::*;
use protocol::*;

use crate::flash::{Flash, TEARS, Tear};
use crate::samples::{charge, identity, load, passes, with};

/// A life in which every kind of record is written, and the sectors turn.
fn life(records: u32) -> Vec<Record> {
    let latched = FaultSet::of(&[FaultCode::ContactorWelded, FaultCode::OverCurrent]);
    let mut life = vec![Record::Identity(identity())];
    for number in 1..=records {
        let slot = u8::try_from(number % 8).unwrap();
        life.push(match number % 6 {
            0 => Record::Waiting(slot, charge(1, number)),
            1 => Record::Acknowledged(slot),
            2 => Record::Epoch(Epoch(number)),
            3 => Record::Latched(if number % 12 == 3 { latched } else { FaultSet::EMPTY }),
            4 => Record::Counters(Counters { charges: number, live_s: number * 60, claims: number }),
            _ => Record::Waiting(slot, passes(1, number)),
        });
    }
    life
}

/// Lives on from record `from`; how many were kept until the power went, and what that was.
fn live(flash: &Flash, life: &[Record], mut kept: Kept) -> (usize, Kept) {
    let Ok((mut store, found)) = load(flash) else { return (0, kept) };
    kept.boot = found.boot;
    assert_eq!(found, kept, "what was kept is not what was found");
    for (index, record) in life.iter().enumerate() {
        if block_on(store.make_room()).is_err() || block_on(store.append(record)).is_err() {
            return (index, kept);
        }
        kept = with(kept, record);
    }
    (life.len(), kept)
}

/// Starts after a cut: everything that was kept is there, and the record under way is or is not.
fn restart(flash: &Flash, kept: Kept, under_way: Option<&Record>) -> Kept {
    flash.repower();
    let (_, found) = load(flash).unwrap_or_else(|error| panic!("the store does not start: {error}"));
    assert!(found.boot > kept.boot, "a start has the number of an earlier one");
    let without = Kept { boot: found.boot, ..kept };
    let with = under_way.map(|record| with(without.clone(), record));
    assert!(found == without || Some(&found) == with.as_ref(), "found {found:#?}\ninstead of {without:#?}");
    found
}

/// Cuts a life in one operation, and lives on.
fn cut(flash: Flash, kept: &Kept, life: &[Record], operation: u64, tear: Tear) {
    flash.cut_at(operation, tear);
    let (done, known) = live(&flash, life, kept.clone());
    assert!(!flash.powered(), "operation {operation} is one of this life");
    let found = restart(&flash, known, life.get(done));
    let next = &life[done..life.len().min(done + 2)];
    assert_eq!(live(&flash, next, found).0, next.len());
}

/// Cuts a life in every operation and in every way; says how many cuts that were.
fn cut_everywhere(begin: &Flash, kept: &Kept, life: &[Record]) -> usize {
    let whole = Flash::holding(begin.bytes());
    assert_eq!(live(&whole, life, kept.clone()).0, life.len());
    let bytes = begin.bytes();
    std::thread::scope(|scope| {
        for tear in TEARS {
            let (bytes, operations) = (&bytes, whole.operations());
            scope.spawn(move || {
                (0..operations)
                    .for_each(|operation| cut(Flash::holding(bytes.clone()), kept, life, operation, tear))
            });
        }
    });
    TEARS.len() * usize::try_from(whole.operations()).unwrap()
}

#[test]
fn nothing_that_was_kept_is_lost_wherever_the_power_is_cut() {
    let fresh = cut_everywhere(&Flash::new(), &Kept::default(), &life(24));

    let flash = Flash::new();
    let (lived, kept) = live(&flash, &life(308), Kept::default());
    assert_eq!((lived, flash.erases()), (309, [1, 1]), "nearly full");
    let turning = cut_everywhere(&flash, &kept, &life(24));
    live(&flash, &life(24), kept);
    assert!(flash.erases().iter().any(|erases| *erases > 1), "the sectors have not turned");
    println!("{fresh} cuts in a new store, {turning} around a turn of its sectors");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Also while it starts after another cut.
    #[test]
    fn cut_upon_cut_loses_nothing(cuts in prop::collection::vec((0u64..4_000, 0usize..TEARS.len()), 1..30)) {
        let life = life(120);
        let flash = Flash::new();
        let mut kept = Kept::default();
        let mut done = 0;
        for (operation, tear) in cuts {
            // Most cuts come while it starts.
            flash.cut_at(if operation % 3 == 0 { operation } else { operation % 40 }, TEARS[tear]);
            let (lived, known) = live(&flash, &life[done..], kept.clone());
            let lost = !flash.powered();
            done += lived;
            kept = restart(&flash, Kept { boot: kept.boot, ..known }, life.get(done).filter(|_| lost));
            if done == life.len() {
                break;
            }
        }
    }

    /// Whatever another program has left in the two sectors, they become a store.
    #[test]
    fn a_flash_with_anything_in_it_becomes_a_store(seed: u32, fill in prop::option::of(any::<u8>())) {
        let mut noise = seed | 1;
        let bytes = (0..2 * crate::flash::SECTOR).map(|_| {
            noise ^= noise << 13;
            noise ^= noise >> 17;
            noise ^= noise << 5;
            fill.unwrap_or(noise.to_le_bytes()[2])
        });
        let flash = Flash::left_with(bytes.collect());
        let (_, kept) = load(&flash).unwrap();
        prop_assert_eq!(kept, Kept { boot: BootEpoch(1), ..Kept::default() });
    }
}

#[test]
fn starts_are_counted_from_the_floor_that_the_board_was_given() {
    let flash = Flash::new();
    let (mut store, kept) = load(&flash).unwrap();
    assert_eq!(kept.boot, BootEpoch(1));
    let identity = firmware_pile::store::Identity { boot_floor: BootEpoch(40), ..identity() };
    block_on(store.append(&Record::Identity(identity))).unwrap();
    let boots: Vec<_> = (0..3).map(|_| load(&flash).unwrap().1.boot.0).collect();
    assert_eq!(boots, [40, 41, 42]);
}

#[test]
fn a_torn_start_is_not_counted_twice() {
    let flash = Flash::new();
    for boot in 1..20 {
        flash.cut_at(3, Tear::Noise);
        let _ = load(&flash);
        flash.repower();
        let (_, kept) = load(&flash).unwrap();
        assert!(kept.boot.0 >= boot, "start {boot} has the number {}", kept.boot);
    }
}
