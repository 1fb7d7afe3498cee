//! The pile on the board that QEMU emulates. `cargo xtask emulate` builds and boots it.
//!
//! It is pile 1, unless `CHARGEHAND_PILE_ID` was set to another number when it was built.
#![no_std]
#![no_main]

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
compile_error!("this image runs on an ARM core: build it with `cargo xtask firmware`");

use cortex_m_rt::entry;
use firmware_common::emulated::{EmulatedWatchdog, Machine, Uart, UartReceiver, UartSender, boot_epoch};
use firmware_common::executor::{execute, execute_above};
use firmware_common::reader::r200::R200;
use firmware_common::supervisor::{Place, Roll};
use firmware_common::tasks::{self as common, Inbox, Outbox, Trusted};
use firmware_pile::board::emulated::{self, ModelledCharger, VolatileMemory, seal_cost};
use firmware_pile::tasks;
use firmware_pile::{ChargingPile, Parameters};
use protocol::{DeviceId, PileId, Sessions};

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
    let parameters = Parameters { boot: boot_epoch(), ..Parameters::new(PILE, POWER_W) };
    defmt::warn!("INSECURE: this image has no keys and believes whoever can reach its link");
    let sessions = Sessions::insecure(DeviceId::Pile(parameters.pile), parameters.boot);
    let Some(trusted) = cortex_m::singleton!(: Trusted<0> = Trusted::new(sessions)) else {
        defmt::panic!("the machine has been taken before");
    };
    let trusted: &'static Trusted<0> = trusted;
    let [listening, speaking, watching, running, serving] = ROLL.places();
    defmt::info!("pile {} in its start {}", parameters.pile.0, parameters.boot.0);
    execute_above(|spawner| spawner.spawn(defmt::unwrap!(run(parameters, running))));
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
async fn listen(link: UartReceiver, trusted: &'static Trusted<0>, place: Place) {
    common::listen(link, trusted, &INBOX, place).await
}

#[embassy_executor::task]
async fn speak(link: UartSender, trusted: &'static Trusted<0>, place: Place) {
    common::speak(link, trusted, &OUTBOX, place).await
}

#[embassy_executor::task]
async fn watch(reader: Uart, place: Place) {
    common::watch(R200::new(reader), &INBOX, place).await
}

#[embassy_executor::task]
async fn run(parameters: Parameters, place: Place) {
    let pile = ChargingPile::new(parameters);
    tasks::run(pile, ModelledCharger::new(), VolatileMemory, &INBOX, &OUTBOX, place).await
}

#[embassy_executor::task]
async fn serve(bench: Uart, place: Place) {
    emulated::serve(bench, place).await
}
