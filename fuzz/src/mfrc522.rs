//! What an MFRC522 answers, register by register.

use std::convert::Infallible;

use embassy_futures::block_on;
use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
use embedded_hal_async::delay::DelayNs;
use firmware_common::reader::mfrc522::{MAX_TRANSACTIONS, Mfrc522, RSSI_DBM};
use firmware_common::reader::{Seen, TagReader};

use crate::tried::Tried;

/// Polls the chip until it has said all of `input`.
pub fn run(input: &[u8]) -> Tried {
    let mut tried = Tried::default();
    let mut left = input;
    while !left.is_empty() {
        let before = left;
        let mut chip = Chip { left: &mut left, transactions: 0 };
        let mut found = Vec::new();
        block_on(Mfrc522::new(&mut chip, NoDelay).poll(|seen| found.push(seen)));
        assert!(chip.transactions <= MAX_TRANSACTIONS + 1, "{} transactions", chip.transactions);
        assert!(found.len() <= 1, "{found:?}");
        let Some(seen) = found.first() else { continue };
        tried.add(seen.is_ok());
        if let Ok(Seen::Tag(read)) = seen {
            assert_eq!(read.rssi_dbm, RSSI_DBM);
            let [0xFF, length @ (4 | 7 | 10), uid @ ..] = &read.tag.0 else { panic!("{:?}", read.tag) };
            // Each is read from the chip as it stands there, but for what separates the levels.
            let mut said = before[..before.len() - left.len()].iter();
            let uid = &uid[..usize::from(*length)];
            assert!(uid.iter().all(|byte| said.any(|said| said == byte)), "{:?} was not said", read.tag);
        }
    }
    tried
}

/// Answers with the next bytes, then with zeros for ever.
struct Chip<'a, 'b> {
    left: &'a mut &'b [u8],
    transactions: u32,
}

impl ErrorType for Chip<'_, '_> {
    type Error = Infallible;
}

impl SpiDevice for Chip<'_, '_> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        self.transactions += 1;
        for operation in operations {
            if let Operation::TransferInPlace(bytes) = operation {
                bytes.fill_with(|| self.left.split_off_first().copied().unwrap_or(0));
            }
        }
        Ok(())
    }
}

struct NoDelay;

impl DelayNs for NoDelay {
    async fn delay_ns(&mut self, _: u32) {}
}
