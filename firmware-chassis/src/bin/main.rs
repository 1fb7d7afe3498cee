//! The chassis on the board that is flashed. `cargo xtask firmware` builds it.
//!
//! It carries robot 1, unless `CHARGEHAND_ROBOT_ID` was set to another number when it was built.
#![no_std]
#![no_main]

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
compile_error!("this image runs on an ARM core: build it with `cargo xtask firmware`");

use cortex_m_rt::entry;
use embassy_stm32::usart::{BufferedUart, BufferedUartRx, BufferedUartTx};
use firmware_chassis::board::stm32::{Board, HardwareBody};
use firmware_chassis::{Chassis, Parameters, tasks};
use firmware_common::executor::{execute, execute_above};
use firmware_common::reader::r200::R200;
use firmware_common::stm32::HardwareWatchdog;
use firmware_common::supervisor::{Place, Roll};
use firmware_common::tasks::{self as common, Inbox, Outbox, Trusted};
use protocol::{DeviceId, Sessions};

static INBOX: Inbox = Inbox::new();
static OUTBOX: Outbox<{ tasks::OUTBOX }> = Outbox::new();
static ROLL: Roll<4> = Roll::new();

#[entry]
fn main() -> ! {
    let Some(Board { link_rx, link_tx, reader, body, watchdog, start, boot }) = Board::take() else {
        defmt::panic!("the board has been taken before, or cannot have its baud rates");
    };
    let parameters = Parameters { boot, start, ..Parameters::new(tasks::ROBOT) };
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
    let [controlling, listening, speaking, watching] = ROLL.places();
    defmt::info!("chassis of robot {} in its start {}", parameters.robot.0, parameters.boot.0);
    execute_above(|spawner| spawner.spawn(defmt::unwrap!(control(chassis, body, controlling))));
    execute(|spawner| {
        spawner.spawn(defmt::unwrap!(supervise(watchdog)));
        spawner.spawn(defmt::unwrap!(listen(link_rx, trusted, listening)));
        spawner.spawn(defmt::unwrap!(speak(link_tx, trusted, speaking)));
        spawner.spawn(defmt::unwrap!(watch(reader, watching)));
    })
}

#[embassy_executor::task]
async fn control(chassis: Chassis, body: HardwareBody, place: Place) {
    tasks::control(chassis, body, &INBOX, &OUTBOX, place).await
}

#[embassy_executor::task]
async fn supervise(watchdog: HardwareWatchdog) {
    common::supervise(watchdog, &ROLL, ["control", "listen", "speak", "watch"]).await
}

#[embassy_executor::task]
async fn listen(link: BufferedUartRx<'static>, trusted: &'static Trusted<0>, place: Place) {
    common::listen(link, trusted, &INBOX, place).await
}

#[embassy_executor::task]
async fn speak(link: BufferedUartTx<'static>, trusted: &'static Trusted<0>, place: Place) {
    common::speak(link, trusted, &OUTBOX, place).await
}

#[embassy_executor::task]
async fn watch(reader: BufferedUart<'static>, place: Place) {
    common::watch(R200::new(reader), &INBOX, place).await
}
