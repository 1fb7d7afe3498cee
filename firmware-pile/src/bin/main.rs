//! The pile on the board that is flashed. `cargo xtask firmware` builds it.
#![no_std]
#![no_main]

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
compile_error!("this image runs on an ARM core: build it with `cargo xtask firmware`");

use cortex_m_rt::entry;
use embassy_futures::block_on;
use embassy_stm32::gpio::Input;
use embassy_stm32::usart::{BufferedUartRx, BufferedUartTx};
use firmware_common::executor::{execute, execute_above};
use firmware_common::stm32::HardwareWatchdog;
use firmware_common::supervisor::{Place, Roll};
use firmware_common::tasks::{self as common, Inbox, Outbox, Trusted};
use firmware_pile::board::stm32::{Board, HardwareCharger, StoreFlash, TagReader, UhfReader};
use firmware_pile::device::Device;
use firmware_pile::store::Store;
use firmware_pile::tasks;
use firmware_pile::trust::{PEERS, sessions};

static INBOX: Inbox = Inbox::new();
static OUTBOX: Outbox<{ tasks::OUTBOX }> = Outbox::new();
static ROLL: Roll<5> = Roll::new();

#[entry]
fn main() -> ! {
    let Some(board) = Board::take() else {
        defmt::panic!("the board has been taken before, or cannot have its baud rates");
    };
    let Board { link_rx, link_tx, uhf_reader, tag_reader, charger, flash, button, watchdog, .. } = board;
    if board.reset_by_watchdog {
        defmt::warn!("the watchdog restarted the board");
    }
    // The contacts are dead: the store may erase.
    let (store, kept) = match block_on(Store::load(flash, StoreFlash::start())) {
        Ok(loaded) => loaded,
        Err(error) => defmt::panic!("{}", defmt::Display2Format(&error)),
    };
    defmt::info!(
        "{} in its start {}: {} charges, {} s of live contacts before it",
        kept.identity.map(|identity| identity.pile.0),
        kept.boot.0,
        kept.counters.charges,
        kept.counters.live_s
    );
    let sessions = sessions(kept.identity.as_ref(), kept.boot);
    let Some(trusted) = cortex_m::singleton!(: Trusted<PEERS> = Trusted::new(sessions)) else {
        defmt::panic!("the board has been taken before");
    };
    let trusted: &'static Trusted<PEERS> = trusted;
    let Some(device) = cortex_m::singleton!(: Device = Device::new(kept)) else {
        defmt::panic!("the board has been taken before");
    };
    let [running, listening, speaking, watching_uhf, watching_tags] = ROLL.places();
    execute_above(|spawner| spawner.spawn(defmt::unwrap!(run(device, charger, store, button, running))));
    execute(|spawner| {
        spawner.spawn(defmt::unwrap!(supervise(watchdog)));
        spawner.spawn(defmt::unwrap!(listen(link_rx, trusted, listening)));
        spawner.spawn(defmt::unwrap!(speak(link_tx, trusted, speaking)));
        spawner.spawn(defmt::unwrap!(watch_uhf(uhf_reader, watching_uhf)));
        spawner.spawn(defmt::unwrap!(watch_tags(tag_reader, watching_tags)));
    })
}

#[embassy_executor::task]
async fn run(
    device: &'static mut Device,
    charger: HardwareCharger,
    store: Store<StoreFlash>,
    button: Input<'static>,
    place: Place,
) {
    tasks::run(device, charger, store, move || button.is_high(), &INBOX, &OUTBOX, place).await
}

#[embassy_executor::task]
async fn supervise(watchdog: HardwareWatchdog) {
    let names = ["run", "listen", "speak", "watch UHF", "watch tags"];
    common::supervise(watchdog, &ROLL, names).await
}

#[embassy_executor::task]
async fn listen(link: BufferedUartRx<'static>, trusted: &'static Trusted<PEERS>, place: Place) {
    common::listen(link, trusted, &INBOX, place).await
}

#[embassy_executor::task]
async fn speak(link: BufferedUartTx<'static>, trusted: &'static Trusted<PEERS>, place: Place) {
    common::speak(link, trusted, &OUTBOX, place).await
}

#[embassy_executor::task]
async fn watch_uhf(reader: UhfReader, place: Place) {
    common::watch(reader, &INBOX, place).await
}

#[embassy_executor::task]
async fn watch_tags(reader: TagReader, place: Place) {
    common::watch(reader, &INBOX, place).await
}
