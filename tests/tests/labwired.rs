//! The images that are flashed start in LabWired: clocks, timers, UARTs, converter, watchdog and flash are
//! set up as the STM32F407 wants them.
#![allow(clippy::unwrap_used)]

use std::time::Duration;

use protocol::{DeviceId, RobotId};
use tests::labwired::{Board, CHASSIS, PILE, boot};

/// A board says Hello by then.
const HELLO_BY: Duration = Duration::from_millis(200);
/// Until then nothing resets it: longer than the chassis' watchdog waits.
const WATCHED_FOR: Duration = Duration::from_millis(400);

fn says_hello_and_goes_on(board: Board, who: DeviceId) {
    let boot = boot(board, WATCHED_FOR).unwrap();
    let hello_at = boot.hello_at();
    assert!(hello_at.is_some_and(|at| at <= HELLO_BY), "Hello at {hello_at:?} of {boot:#?}");
    assert!(boot.is_one_start(), "a reset: {boot:#?}");
    assert!(boot.frames.iter().all(|sent| sent.header.sender == who), "{boot:#?}");
}

#[test]
fn the_pile_says_hello_and_is_not_reset() {
    // Its flash is empty.
    says_hello_and_goes_on(PILE, DeviceId::Factory);
}

#[test]
fn the_chassis_says_hello_and_is_not_reset() {
    says_hello_and_goes_on(CHASSIS, DeviceId::Chassis(RobotId(1)));
}
