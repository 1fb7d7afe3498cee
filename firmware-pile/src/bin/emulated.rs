//! The pile on the board that QEMU emulates. `cargo xtask emulate` builds and boots it.
//!
//! Started with the words `flash=PATH`, its flash is that file: it keeps what a board keeps, and is
//! nobody until it is provisioned. The word `button` before that holds its button. Without a file it
//! forgets everything, believes everybody, and is pile 1, unless `CHARGEHAND_PILE_ID` was set to another
//! number when it was built.
#![no_std]
#![no_main]

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
compile_error!("this image runs on an ARM core: build it with `cargo xtask firmware`");

use core::ffi::CStr;

use cortex_m_rt::entry;
use embassy_futures::block_on;
use firmware_common::emulated::{
    EmulatedFlash, EmulatedWatchdog, Machine, Uart, UartReceiver, UartSender, boot_epoch, command_line,
};
use firmware_common::executor::{execute, execute_above};
use firmware_common::reader::r200::R200;
use firmware_common::supervisor::{Place, Roll};
use firmware_common::tasks::{self as common, Inbox, Outbox, Trusted};
use firmware_pile::board::emulated::{self, ModelledCharger, seal_cost, store_cost};
use firmware_pile::device::Device;
use firmware_pile::store::{Kept, Store};
use firmware_pile::tasks;
use firmware_pile::trust::{PEERS, sessions};
use firmware_pile::{ChargingPile, Parameters};
use protocol::{DeviceId, PileId, Sessions, Trust};

const PILE: PileId = PileId(match option_env!("CHARGEHAND_PILE_ID") {
    None => 1,
    Some(text) => match u16::from_str_radix(text, 10) {
        Ok(id) => id,
        Err(_) => panic!("CHARGEHAND_PILE_ID must be a number from 0 to 65535"),
    },
});

/// What the pile gives a robot: as the piles of `sites/lmpp-fig7`.
const POWER_W: f32 = 500.0;

static INBOX: Inbox = Inbox::new();
static OUTBOX: Outbox<{ tasks::OUTBOX }> = Outbox::new();
static ROLL: Roll<5> = Roll::new();

#[entry]
fn main() -> ! {
    let Some(Machine { link, reader, bench, watchdog }) = Machine::take() else {
        defmt::panic!("the machine has been taken before");
    };
    seal_cost::log();
    let (receiver, sender) = link.split();
    let started_with = command_line();
    let path = started_with.split_once("flash=").map(|(_, path)| path);
    let button = started_with.split_whitespace().any(|word| word == "button");
    let Some((mut store, kept)) = remembered(path) else {
        defmt::panic!("the flash cannot be read: its file must have two sectors, erased at first");
    };
    let (boot, sessions) = match path {
        Some(_) => (kept.boot, sessions(kept.identity.as_ref(), kept.boot)),
        None => {
            store_cost::log(&mut store);
            defmt::warn!("INSECURE: without a flash it has no keys and believes whoever can reach its link");
            let boot = boot_epoch();
            (boot, Sessions::new(DeviceId::Pile(PILE), boot, Trust::Insecure))
        }
    };
    let modelled = || Device::Pile(ChargingPile::new(Parameters { boot, ..Parameters::new(PILE, POWER_W) }));
    let device = if path.is_some() {
        cortex_m::singleton!(: Device = Device::new(kept))
    } else {
        cortex_m::singleton!(: Device = modelled())
    };
    let Some(device) = device else {
        defmt::panic!("the machine has been taken before");
    };
    let Some(trusted) = cortex_m::singleton!(: Trusted<PEERS> = Trusted::new(sessions)) else {
        defmt::panic!("the machine has been taken before");
    };
    let trusted: &'static Trusted<PEERS> = trusted;
    let [listening, speaking, watching, running, serving] = ROLL.places();
    execute_above(|spawner| spawner.spawn(defmt::unwrap!(run(device, store, button, running))));
    execute(|spawner| {
        spawner.spawn(defmt::unwrap!(supervise(watchdog)));
        spawner.spawn(defmt::unwrap!(listen(receiver, trusted, listening)));
        spawner.spawn(defmt::unwrap!(speak(sender, trusted, speaking)));
        spawner.spawn(defmt::unwrap!(watch(reader, watching)));
        spawner.spawn(defmt::unwrap!(serve(bench, serving)));
    })
}

#[embassy_executor::task]
async fn supervise(watchdog: EmulatedWatchdog) {
    common::supervise(watchdog, &ROLL, ["listen", "speak", "watch", "run", "bench"]).await
}

#[embassy_executor::task]
async fn listen(link: UartReceiver, trusted: &'static Trusted<PEERS>, place: Place) {
    common::listen(link, trusted, &INBOX, place).await
}

#[embassy_executor::task]
async fn speak(link: UartSender, trusted: &'static Trusted<PEERS>, place: Place) {
    common::speak(link, trusted, &OUTBOX, place).await
}

#[embassy_executor::task]
async fn watch(reader: Uart, place: Place) {
    common::watch(R200::new(reader), &INBOX, place).await
}

#[embassy_executor::task]
async fn run(device: &'static mut Device, store: Store<EmulatedFlash>, button: bool, place: Place) {
    tasks::run(device, ModelledCharger::new(), store, move || button, &INBOX, &OUTBOX, place).await
}

/// The store in the flash of this file, or in one that is erased, and what it keeps.
fn remembered(path: Option<&str>) -> Option<(Store<EmulatedFlash>, Kept)> {
    let mut text = heapless::String::<256>::new();
    let path = match path {
        None => None,
        Some(path) => {
            text.push_str(path).and_then(|()| text.push('\0')).ok()?;
            Some(CStr::from_bytes_until_nul(text.as_bytes()).ok()?)
        }
    };
    let (store, kept) = match block_on(Store::load(EmulatedFlash::take(path)?, 0)) {
        Ok(loaded) => loaded,
        Err(error) => defmt::panic!("{}", defmt::Display2Format(&error)),
    };
    let pile = kept.identity.map(|identity| identity.pile.0);
    defmt::info!("keeps: pile {}, start {}, {} charges", pile, kept.boot.0, kept.counters.charges);
    Some((store, kept))
}

#[embassy_executor::task]
async fn serve(bench: Uart, place: Place) {
    emulated::serve(bench, place).await
}
