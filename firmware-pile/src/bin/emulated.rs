//! The pile on the board that QEMU emulates. `cargo xtask emulate` builds and boots it.
//!
//! It is pile 1, unless `CHARGEHAND_PILE_ID` was set to another number when it was built.
#![no_std]
#![no_main]

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
compile_error!("this image runs on an ARM core: build it with `cargo xtask firmware`");

use cortex_m_rt::entry;
use firmware_pile::board::emulated::{
    Board, LoggedContactor, Uart, UartReceiver, UartSender, VolatileMemory, boot_epoch, execute,
};
use firmware_pile::reader::r200::R200;
use firmware_pile::tasks::{self, Inbox, Outbox};
use firmware_pile::{ChargingPile, Parameters};
use protocol::{DeviceId, FrameWriter, PileId};

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
static OUTBOX: Outbox = Outbox::new();

#[entry]
fn main() -> ! {
    let Some(Board { link, reader, contactor, memory }) = Board::take() else {
        defmt::panic!("the board has been taken before");
    };
    let (receiver, sender) = link.split();
    let parameters = Parameters { boot: boot_epoch(), ..Parameters::new(PILE, POWER_W) };
    defmt::info!("pile {} in its start {}", parameters.pile.0, parameters.boot.0);
    execute(|spawner| {
        spawner.spawn(defmt::unwrap!(listen(receiver)));
        spawner.spawn(defmt::unwrap!(speak(sender)));
        spawner.spawn(defmt::unwrap!(watch(reader)));
        spawner.spawn(defmt::unwrap!(run(parameters, contactor, memory)));
    })
}

#[embassy_executor::task]
async fn listen(link: UartReceiver) {
    tasks::listen(link, &INBOX).await
}

#[embassy_executor::task]
async fn speak(link: UartSender) {
    tasks::speak(link, &OUTBOX).await
}

#[embassy_executor::task]
async fn watch(reader: Uart) {
    tasks::watch(R200::new(reader), &INBOX).await
}

#[embassy_executor::task]
async fn run(parameters: Parameters, contactor: LoggedContactor, memory: VolatileMemory) {
    let writer = FrameWriter::new(DeviceId::Pile(parameters.pile), parameters.boot);
    tasks::run(ChargingPile::new(parameters), writer, contactor, memory, &INBOX, &OUTBOX).await
}
