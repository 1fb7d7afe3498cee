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
pub(super) struct Receiver {
    ring: Pipe<CriticalSectionRawMutex, RING_BYTES>,
    overruns: AtomicU32,
}

pub(super) static LINK: Receiver = Receiver::new();
pub(super) static READER: Receiver = Receiver::new();

impl Receiver {
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

/// Both directions of a USART.
pub struct Uart {
    /// What arrives.
    pub reader: UartReader,
    /// What leaves.
    pub writer: UartWriter,
}

impl Uart {
    pub(super) fn start(usart: Usart, receiver: &'static Receiver) -> Self {
        usart.cr1().write(|w| {
            w.set_ue(true);
            w.set_te(true);
            w.set_re(true);
            w.set_rxneie(true);
        });
        Self { reader: UartReader { receiver }, writer: UartWriter { usart } }
    }
}

/// The receiving half of a USART.
pub struct UartReader {
    receiver: &'static Receiver,
}

impl UartReader {
    /// Bytes lost so far, because they came faster than they were read.
    pub fn overruns(&self) -> u32 {
        self.receiver.overruns.load(Ordering::Relaxed)
    }
}

impl ErrorType for UartReader {
    type Error = Infallible;
}

impl Read for UartReader {
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        Ok(self.receiver.ring.read(buffer).await)
    }
}

/// The sending half of a USART.
pub struct UartWriter {
    usart: Usart,
}

impl ErrorType for UartWriter {
    type Error = Infallible;
}

impl Write for UartWriter {
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
