//! Room for a charge, made before it begins, and how long the flash lasts.

use embassy_futures::block_on;
use firmware_pile::faults::FaultSet;
use firmware_pile::store::{JOURNAL, ROOM, Record};
use protocol::*;

use crate::flash::Flash;
use crate::samples::{charge, identity, load, passes};

#[test]
fn nothing_is_erased_while_a_charge_writes_its_records() {
    let flash = Flash::new();
    let (mut store, _) = load(&flash).unwrap();
    block_on(store.append(&Record::Identity(identity()))).unwrap();
    for round in 0..200 {
        block_on(store.make_room()).unwrap();
        flash.allow_erase(false);
        assert!(store.room() >= ROOM, "round {round}");
        while block_on(store.append(&Record::Waiting(0, charge(1, round)))).is_ok() {}
        flash.allow_erase(true);
    }
    assert!(flash.erases().iter().all(|erases| *erases > 50));
}

#[test]
fn room_is_made_only_when_there_is_too_little() {
    let flash = Flash::new();
    let (mut store, _) = load(&flash).unwrap();
    let before = flash.operations();
    (0..100).for_each(|_| block_on(store.make_room()).unwrap());
    assert_eq!(flash.operations(), before);
}

#[test]
fn what_all_keys_take_leaves_most_of_a_sector() {
    let flash = Flash::new();
    let (mut store, _) = load(&flash).unwrap();
    block_on(store.append(&Record::Identity(identity()))).unwrap();
    block_on(store.append(&Record::Latched(FaultSet::of(&FaultCode::ALL)))).unwrap();
    for slot in 0..JOURNAL {
        block_on(store.append(&Record::Waiting(u8::try_from(slot).unwrap(), passes(u32::MAX, u32::MAX))))
            .unwrap();
    }
    while store.room() >= ROOM {
        block_on(store.append(&Record::Epoch(Epoch(u32::MAX)))).unwrap();
    }
    block_on(store.make_room()).unwrap();
    println!("{} of 16384 bytes are free after a turn with everything that can be kept", store.room());
    assert!(store.room() > 13 * 1024);
}

/// A report of passes every minute, day and night, each as large as one gets.
#[test]
fn the_flash_lasts_for_years() {
    const MINUTES: u32 = 20_000;
    /// The datasheet's least number of erases of a sector (STM32F407, DS8626, flash endurance).
    const ENDURANCE: f64 = 10_000.0;
    let flash = Flash::new();
    let (mut store, _) = load(&flash).unwrap();
    for number in 0..MINUTES {
        let slot = u8::try_from(number % 8).unwrap();
        block_on(store.append(&Record::Waiting(slot, passes(1, number)))).unwrap();
        block_on(store.append(&Record::Acknowledged(slot))).unwrap();
        block_on(store.make_room()).unwrap();
    }
    let erases = *flash.erases().iter().max().unwrap();
    let years = ENDURANCE / erases as f64 * f64::from(MINUTES) / (60.0 * 24.0 * 365.0);
    println!("{erases} erases of a sector in {MINUTES} minutes: {years:.1} years");
    assert!(years > 2.0);
}
