//! The pile on the board that QEMU emulates. `cargo xtask emulate` builds and boots it.
#![no_std]
#![no_main]

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
compile_error!("this image runs on an ARM core: build it with `cargo xtask firmware`");

use embassy_executor::Spawner;
use embedded_io_async::{Read, Write};
use firmware_pile::board::emulated::{Board, Uart};

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let Some(board) = Board::take() else {
        defmt::panic!("the board has been taken before");
    };
    defmt::info!("pile up");
    spawner.spawn(defmt::unwrap!(echo(board.reader)));
    spawner.spawn(defmt::unwrap!(echo(board.link)));
    let mut ticker = embassy_time::Ticker::every(embassy_time::Duration::from_secs(1));
    loop {
        ticker.next().await;
        defmt::info!("alive at {} ms", embassy_time::Instant::now().as_millis());
    }
}

#[embassy_executor::task(pool_size = 2)]
async fn echo(mut uart: Uart) {
    let mut buffer = [0; 64];
    loop {
        let Ok(n) = uart.reader.read(&mut buffer).await;
        let Ok(()) = uart.writer.write_all(&buffer[..n]).await;
    }
}
