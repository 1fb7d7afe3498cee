//! The chassis on the board that QEMU emulates. `cargo xtask firmware` builds it.
//!
//! It carries robot 1, unless `CHARGEHAND_ROBOT_ID` was set to another number when it was built.
#![no_std]
#![no_main]

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
compile_error!("this image runs on an ARM core: build it with `cargo xtask firmware`");

use cortex_m_rt::entry;
use firmware_chassis::board::emulated::{self, ModelledBody};
use firmware_chassis::{Chassis, Parameters, Start, tasks};
use firmware_common::emulated::{EmulatedWatchdog, Machine, Uart, UartReceiver, UartSender, boot_epoch};
use firmware_common::executor::{execute, execute_above};
use firmware_common::reader::r200::R200;
use firmware_common::supervisor::{Place, Roll};
use firmware_common::tasks::{self as common, Inbox, Outbox, Trusted};
use protocol::{DeviceId, Sessions};

static INBOX: Inbox = Inbox::new();
static OUTBOX: Outbox<{ tasks::OUTBOX }> = Outbox::new();
static ROLL: Roll<5> = Roll::new();

#[entry]
fn main() -> ! {
    let Some(Machine { link, reader, bench, watchdog }) = Machine::take() else {
        defmt::panic!("the machine has been taken before");
    };
    let (receiver, sender) = link.split();
    let start = if watchdog.was_cause_of_start() { Start::Watchdog } else { Start::PowerOn };
    let parameters = Parameters { boot: boot_epoch(), start, ..Parameters::new(tasks::ROBOT) };
    let chassis = match Chassis::new(parameters) {
        Ok(chassis) => chassis,
        Err(error) => defmt::panic!("{}", defmt::Display2Format(&error)),
    };
    // The line to the robot's computer does not leave the robot.
    let sessions = Sessions::insecure(DeviceId::Chassis(parameters.robot), parameters.boot);
    let Some(trusted) = cortex_m::singleton!(: Trusted<0> = Trusted::new(sessions)) else {
        defmt::panic!("the board has been taken before");
    };
    let trusted: &'static Trusted<0> = trusted;
    let [controlling, listening, speaking, watching, serving] = ROLL.places();
    defmt::info!("chassis of robot {} in its start {}", parameters.robot.0, parameters.boot.0);
    execute_above(|spawner| {
        spawner.spawn(defmt::unwrap!(control(chassis, ModelledBody::new(&parameters), controlling)));
    });
    execute(|spawner| {
        spawner.spawn(defmt::unwrap!(supervise(watchdog)));
        spawner.spawn(defmt::unwrap!(listen(receiver, trusted, listening)));
        spawner.spawn(defmt::unwrap!(speak(sender, trusted, speaking)));
        spawner.spawn(defmt::unwrap!(watch(reader, watching)));
        spawner.spawn(defmt::unwrap!(serve(bench, serving)));
    })
}

#[embassy_executor::task]
async fn control(chassis: Chassis, body: ModelledBody, place: Place) {
    tasks::control(chassis, body, &INBOX, &OUTBOX, place).await
}

#[embassy_executor::task]
async fn supervise(watchdog: EmulatedWatchdog) {
    common::supervise(watchdog, &ROLL, ["control", "listen", "speak", "watch", "bench"]).await
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
async fn serve(bench: Uart, place: Place) {
    emulated::serve(bench, place).await
}
