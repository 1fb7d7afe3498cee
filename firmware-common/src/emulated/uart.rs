//! The machine's USARTs as embedded-io-async readers and writers.
//!
//! A receive interrupt puts every byte into a ring. A byte that finds the ring full is lost and
//! counted: the frame it belonged to fails its checksum and whoever reads goes on with the next.
//! QEMU knows no baud rate, so none is set.

use core::convert::Infallible;
use core::sync::atomic::{AtomicU32, Ordering};

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::pipe::Pipe;
use embedded_io_async::{ErrorType, Read, Write};
use pac::interrupt;
use pac::usart::Usart;
use stm32_metapac as pac;

/// Bytes of a ring: the largest frames of a few senders at once.
const RING_BYTES: usize = 1024;

/// What the receive interrupt of one USART shares with its reader.
pub(super) struct Shared {
    ring: Pipe<CriticalSectionRawMutex, RING_BYTES>,
    overruns: AtomicU32,
}

pub(super) static LINK: Shared = Shared::new();
pub(super) static READER: Shared = Shared::new();
pub(super) static BENCH: Shared = Shared::new();

impl Shared {
    const fn new() -> Self {
        Self { ring: Pipe::new(), overruns: AtomicU32::new(0) }
    }

    /// Takes a byte from the USART, if it has one. Reading the data register clears both the
    /// "not empty" and the overrun flag.
    fn on_interrupt(&self, usart: Usart) {
        let status = usart.sr().read();
        if status.ore() {
            self.count_overrun();
        }
        if status.rxne() || status.ore() {
            let byte = usart.dr().read().dr() as u8;
            if self.ring.try_write(&[byte]).is_err() {
                self.count_overrun();
            }
        }
    }

    fn count_overrun(&self) {
        self.overruns.fetch_add(1, Ordering::Relaxed);
    }
}

#[interrupt]
fn USART1() {
    LINK.on_interrupt(pac::USART1);
}

#[interrupt]
fn USART2() {
    READER.on_interrupt(pac::USART2);
}

#[interrupt]
fn USART6() {
    BENCH.on_interrupt(pac::USART6);
}

/// A USART.
pub struct Uart {
    receiver: UartReceiver,
    sender: UartSender,
}

impl Uart {
    pub(super) fn start(usart: Usart, shared: &'static Shared) -> Self {
        usart.cr1().write(|w| {
            w.set_ue(true);
            w.set_te(true);
            w.set_re(true);
            w.set_rxneie(true);
        });
        Self { receiver: UartReceiver { shared, overruns_told: 0 }, sender: UartSender { usart } }
    }

    /// Its two halves, for two tasks.
    pub fn split(self) -> (UartReceiver, UartSender) {
        (self.receiver, self.sender)
    }
}

impl ErrorType for Uart {
    type Error = Infallible;
}

impl Read for Uart {
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        self.receiver.read(buffer).await
    }
}

impl Write for Uart {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        self.sender.write(bytes).await
    }

    async fn flush(&mut self) -> Result<(), Infallible> {
        self.sender.flush().await
    }
}

/// The receiving half of a USART.
pub struct UartReceiver {
    shared: &'static Shared,
    overruns_told: u32,
}

impl ErrorType for UartReceiver {
    type Error = Infallible;
}

impl Read for UartReceiver {
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        let length = self.shared.ring.read(buffer).await;
        let overruns = self.shared.overruns.load(Ordering::Relaxed);
        if overruns != self.overruns_told {
            defmt::warn!("{} bytes lost since the start: they came too fast", overruns);
            self.overruns_told = overruns;
        }
        Ok(length)
    }
}

/// The sending half of a USART.
pub struct UartSender {
    usart: Usart,
}

impl ErrorType for UartSender {
    type Error = Infallible;
}

impl Write for UartSender {
    /// Sends the first byte of `bytes`. QEMU takes it at once; were the data register still full,
    /// the other tasks would run until it is not.
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        let Some(&byte) = bytes.first() else {
            return Ok(0);
        };
        while !self.usart.sr().read().txe() {
            embassy_futures::yield_now().await;
        }
        self.usart.dr().write(|w| w.set_dr(byte.into()));
        Ok(1)
    }

    async fn flush(&mut self) -> Result<(), Infallible> {
        while !self.usart.sr().read().tc() {
            embassy_futures::yield_now().await;
        }
        Ok(())
    }
}
