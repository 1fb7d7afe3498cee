//! A chip on the bus, register by register, and in front of it a field that replays what was sent and
//! answered.

use core::convert::Infallible;
use core::pin::pin;
use core::task::{Context, Poll, Waker};
use std::collections::VecDeque;
use std::vec::Vec;

use proptest::prelude::*;

use super::*;

/// Registers, as addressed on the bus.
const COM_IRQ: u8 = 0x04;
const DIV_IRQ: u8 = 0x05;
const ERROR: u8 = 0x06;
const FIFO_DATA: u8 = 0x09;
const FIFO_LEVEL: u8 = 0x0A;
const CONTROL: u8 = 0x0C;
const BIT_FRAMING: u8 = 0x0D;
const TX_CONTROL: u8 = 0x14;
const VERSION: u8 = 0x37;

/// Bits of the interrupt register.
const RECEIVED: u8 = 0x20;
const FAILED: u8 = 0x02;
const TIMED_OUT: u8 = 0x01;
/// Bits of the error register.
const COLLISION: u8 = 0x08;
const CHECKSUM: u8 = 0x04;
const PARITY: u8 = 0x02;

/// How the field answers a frame.
#[derive(Clone, Debug)]
enum Answer {
    /// With these bytes, the last of them of so many bits (0 is 8).
    Bytes(Vec<u8>, u8),
    /// So that the chip finds this error.
    Error(u8),
    /// Not.
    Silence,
    /// Nor does the chip ever say so.
    Hang,
}

/// The chip.
struct Chip {
    registers: [u8; 64],
    fifo: VecDeque<u8>,
    /// What is sent and answered, in order; then silence.
    field: VecDeque<(Vec<u8>, Answer)>,
    unexpected: Vec<Vec<u8>>,
    transactions: u32,
}

impl Chip {
    fn new(field: impl IntoIterator<Item = (Vec<u8>, Answer)>) -> Self {
        let mut registers = [0; 64];
        registers[usize::from(VERSION)] = 0x92;
        let field = field.into_iter().collect();
        Self { registers, fifo: VecDeque::new(), field, unexpected: Vec::new(), transactions: 0 }
    }

    fn read(&mut self, register: u8) -> u8 {
        match register {
            FIFO_DATA => self.fifo.pop_front().unwrap_or(0),
            FIFO_LEVEL => self.fifo.len() as u8,
            other => self.registers[usize::from(other)],
        }
    }

    fn write(&mut self, register: u8, value: u8) {
        match register {
            FIFO_DATA => self.fifo.push_back(value),
            FIFO_LEVEL => self.fifo.clear(),
            // Bits are cleared by writing ones.
            COM_IRQ | DIV_IRQ => self.registers[usize::from(register)] &= !value,
            // Bit 7 starts to send what the FIFO holds.
            BIT_FRAMING if value & 0x80 != 0 => self.send(),
            other => self.registers[usize::from(other)] = value,
        }
    }

    fn send(&mut self) {
        let sent: Vec<u8> = self.fifo.drain(..).collect();
        let answer = match self.field.pop_front() {
            Some((expected, answer)) if expected == sent => answer,
            Some(_) => {
                self.unexpected.push(sent);
                Answer::Silence
            }
            None => Answer::Silence,
        };
        let (interrupt, error) = match answer {
            Answer::Bytes(bytes, bits) => {
                self.fifo.extend(bytes);
                self.registers[usize::from(CONTROL)] = bits;
                (RECEIVED, 0)
            }
            Answer::Error(error) => (FAILED | RECEIVED, error),
            Answer::Silence => (TIMED_OUT, 0),
            Answer::Hang => (0, 0),
        };
        self.registers[usize::from(COM_IRQ)] |= interrupt;
        self.registers[usize::from(ERROR)] = error;
    }

    /// The first byte is an address; reading and writing go by its upper bit.
    fn exchange(&mut self, sent: &[u8]) -> Vec<u8> {
        let Some((&first, rest)) = sent.split_first() else { return Vec::new() };
        let mut answer = vec![0];
        if first & 0x80 == 0 {
            rest.iter().for_each(|&value| self.write(first >> 1, value));
            answer.resize(sent.len(), 0);
        } else {
            // Each byte sent while reading is the address of the next.
            let addresses: Vec<u8> = sent[..sent.len() - 1].to_vec();
            answer.extend(addresses.into_iter().map(|address| self.read((address & 0x7F) >> 1)));
        }
        answer
    }
}

impl ErrorType for Chip {
    type Error = Infallible;
}

impl SpiDevice for Chip {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        self.transactions += 1;
        let mut sent = Vec::new();
        for operation in operations.iter() {
            match operation {
                Operation::Write(bytes) => sent.extend_from_slice(bytes),
                Operation::TransferInPlace(bytes) => sent.extend_from_slice(bytes),
                other => panic!("{other:?} is not what the driver does"),
            }
        }
        let mut answer = self.exchange(&sent).into_iter();
        for operation in operations {
            match operation {
                Operation::TransferInPlace(bytes) => bytes.fill_with(|| answer.next().unwrap()),
                Operation::Write(bytes) => drop(answer.by_ref().take(bytes.len()).count()),
                _ => {}
            }
        }
        Ok(())
    }
}

struct NoDelay;

impl DelayNs for NoDelay {
    async fn delay_ns(&mut self, _: u32) {}
}

fn poll(chip: &mut Chip) -> Vec<Result<Seen, PollError>> {
    let mut found = Vec::new();
    let mut reader = Mfrc522::new(chip, NoDelay);
    let polled = pin!(reader.poll(|seen| found.push(seen))).poll(&mut Context::from_waker(Waker::noop()));
    assert_eq!(polled, Poll::Ready(()));
    found
}

fn seen(uid: &[u8]) -> Vec<Result<Seen, PollError>> {
    let tag = tag_of(&Uid::from_slice(uid).unwrap());
    vec![Ok(Seen::Tag(TagRead { tag, rssi_dbm: RSSI_DBM }))]
}

/// The wake-up every poll begins with, and a tag's answer to it.
fn wake() -> (Vec<u8>, Answer) {
    (vec![0x52], Answer::Bytes(vec![0x44, 0x00], 0))
}

/// One level of a UID with its selection.
fn level(command: u8, part: [u8; 4], acknowledge: u8) -> [(Vec<u8>, Answer); 2] {
    let crc = crc::Crc::<u16>::new(&crc::CRC_16_ISO_IEC_14443_3_A);
    let check = part.iter().fold(0, |check, byte| check ^ byte);
    let mut whole = vec![command, 0x70, part[0], part[1], part[2], part[3], check];
    whole.extend(crc.checksum(&whole).to_le_bytes());
    let mut acknowledged = vec![acknowledge];
    acknowledged.extend(crc.checksum(&acknowledged).to_le_bytes());
    let uid = [&part[..], &[check]].concat();
    [(vec![command, 0x20], Answer::Bytes(uid, 0)), (whole, Answer::Bytes(acknowledged, 0))]
}

/// Exchanges with real tags, byte by byte, as the documentation of libnfc's `nfc-anticol` shows them.
fn recorded<const FRAMES: usize>(frames: [(&[u8], &[u8]); FRAMES]) -> Vec<(Vec<u8>, Answer)> {
    frames.into_iter().map(|(sent, answered)| (sent.to_vec(), Answer::Bytes(answered.to_vec(), 0))).collect()
}

/// A MIFARE Classic.
fn classic() -> Vec<(Vec<u8>, Answer)> {
    recorded([
        (&[0x52], &[0x04, 0x00]),
        (&[0x93, 0x20], &[0x0C, 0x5C, 0xEE, 0x0D, 0xB3]),
        (&[0x93, 0x70, 0x0C, 0x5C, 0xEE, 0x0D, 0xB3, 0x5C, 0xC2], &[0x08, 0xB6, 0xDD]),
    ])
}

/// A DESFire EV1, whose UID takes two levels.
fn desfire() -> Vec<(Vec<u8>, Answer)> {
    recorded([
        (&[0x52], &[0x44, 0x03]),
        (&[0x93, 0x20], &[0x88, 0x04, 0x34, 0x74, 0xCC]),
        (&[0x93, 0x70, 0x88, 0x04, 0x34, 0x74, 0xCC, 0x0E, 0x05], &[0x24, 0xD8, 0x36]),
        (&[0x95, 0x20], &[0xE1, 0xE3, 0x1C, 0x80, 0x9E]),
        (&[0x95, 0x70, 0xE1, 0xE3, 0x1C, 0x80, 0x9E, 0xB9, 0xE1], &[0x20, 0xFC, 0x70]),
    ])
}

#[test]
fn recorded_exchanges_give_the_uids() {
    for (exchange, uid) in
        [(classic(), &[0x0C, 0x5C, 0xEE, 0x0D][..]), (desfire(), &[0x04, 0x34, 0x74, 0xE1, 0xE3, 0x1C, 0x80])]
    {
        let mut chip = Chip::new(exchange);
        assert_eq!(poll(&mut chip), seen(uid));
        assert_eq!((chip.field.len(), chip.unexpected.len()), (0, 0));
    }
}

#[test]
fn a_uid_of_ten_bytes_is_read() {
    let levels = [
        level(0x93, [0x88, 1, 2, 3], 0x04),
        level(0x95, [0x88, 4, 5, 6], 0x04),
        level(0x97, [7, 8, 9, 10], 0x20),
    ];
    let mut chip = Chip::new([wake()].into_iter().chain(levels.into_iter().flatten()));
    assert_eq!(poll(&mut chip), seen(&[1, 2, 3, 4, 5, 6, 7, 8, 9, 10]));
}

#[test]
fn an_empty_field_is_told_and_the_field_is_off_between_polls() {
    let mut chip = Chip::new([]);
    assert_eq!(poll(&mut chip), [Ok(Seen::Nothing)]);
    assert_eq!(chip.registers[usize::from(TX_CONTROL)] & 0b11, 0, "the antenna is driven");
}

#[test]
fn a_board_without_the_chip_is_silent() {
    for nobody in [0x00, 0xFF] {
        let mut chip = Chip::new([wake()]);
        chip.registers[usize::from(VERSION)] = nobody;
        assert_eq!(poll(&mut chip), []);
    }
}

#[test]
fn a_chip_that_hangs_costs_a_bounded_time() {
    let mut chip = Chip::new([(vec![0x52], Answer::Hang)]);
    assert_eq!(poll(&mut chip), [Err(PollError::Hangs)]);
    assert!(chip.transactions <= MAX_TRANSACTIONS + 1, "{} transactions", chip.transactions);
    // It never comes out of its reset.
    let mut stuck = StuckHigh { transactions: 0 };
    let mut found = Vec::new();
    let mut reader = Mfrc522::new(&mut stuck, NoDelay);
    let polled = pin!(reader.poll(|seen| found.push(seen))).poll(&mut Context::from_waker(Waker::noop()));
    assert_eq!((polled, found.as_slice()), (Poll::Ready(()), &[Err(PollError::Hangs)][..]));
    assert!(stuck.transactions <= MAX_TRANSACTIONS + 1);
}

/// A bus on which every bit reads as one.
struct StuckHigh {
    transactions: u32,
}

impl ErrorType for StuckHigh {
    type Error = Infallible;
}

impl SpiDevice for StuckHigh {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        self.transactions += 1;
        for operation in operations {
            if let Operation::TransferInPlace(bytes) = operation {
                bytes.fill(0xFF);
            }
        }
        Ok(())
    }
}

#[test]
fn several_tags_are_none() {
    let field = [wake(), (vec![0x93, 0x20], Answer::Error(COLLISION))];
    assert_eq!(poll(&mut Chip::new(field)), [Err(PollError::Several)]);
}

#[test]
fn a_tag_without_a_name_of_its_own_is_none() {
    let random = level(0x93, [0x08, 1, 2, 3], 0x20);
    let mut chip = Chip::new([wake()].into_iter().chain(random));
    assert_eq!(poll(&mut chip), [Err(PollError::RandomUid)]);
}

#[test]
fn a_tag_whose_uid_never_ends_is_none() {
    let levels = [0x93, 0x95, 0x97].map(|command| level(command, [0x88, 1, 2, 3], 0x04));
    let mut chip = Chip::new([wake()].into_iter().chain(levels.into_iter().flatten()));
    assert_eq!(poll(&mut chip), [Err(PollError::Misread("its UID does not end"))]);
}

#[test]
fn damage_anywhere_in_an_exchange_never_gives_a_tag() {
    let whole = desfire();
    for step in 0..whole.len() {
        let Answer::Bytes(bytes, _) = &whole[step].1 else { continue };
        let flips = (0..bytes.len() * 8).filter(|_| step > 0).map(|bit| {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            Answer::Bytes(damaged, 0)
        });
        let cuts = (0..bytes.len()).map(|length| Answer::Bytes(bytes[..length].to_vec(), 0));
        let partial = (1..8).map(|bits| Answer::Bytes(bytes.clone(), bits));
        let longer = [Answer::Bytes([&bytes[..], &[0; 60]].concat(), 0)];
        let failed = [CHECKSUM, PARITY, COLLISION, 0x01, 0x10].map(Answer::Error);
        for answer in flips.chain(cuts).chain(partial).chain(longer).chain(failed) {
            let mut field = whole.clone();
            field[step].1 = answer.clone();
            let mut chip = Chip::new(field);
            let found = poll(&mut chip);
            assert!(matches!(found[..], [Err(_)]), "{found:?} after {answer:?} in step {step}");
        }
    }
}

#[test]
fn a_tag_that_leaves_in_the_middle_is_misread_and_the_next_is_read() {
    for step in 1..desfire().len() {
        let mut field = desfire();
        field.truncate(step);
        let mut chip = Chip::new(field);
        assert_eq!(poll(&mut chip), [Err(PollError::Misread("it fell silent"))], "gone before step {step}");
        chip.field = desfire().into();
        assert_eq!(poll(&mut chip).len(), 1);
        assert!(matches!(poll(&mut chip)[..], [Ok(Seen::Nothing)]), "the tag has left for good");
    }
}

proptest! {
    #[test]
    fn different_uids_are_different_tags(one in uids(), other in uids()) {
        let (one, other) = (Uid::from_slice(&one).unwrap(), Uid::from_slice(&other).unwrap());
        prop_assert_eq!(one == other, tag_of(&one) == tag_of(&other));
        prop_assert_eq!(tag_of(&one).0[0], MARK);
    }

    #[test]
    fn whatever_a_tag_answers_the_poll_ends(
        answers in prop::collection::vec((prop::collection::vec(any::<u8>(), 0..64), 0u8..8), 7),
    ) {
        // Whatever is sent next is answered with the next.
        let mut chip = Anything { chip: Chip::new([]), answers: answers.into() };
        let mut found = Vec::new();
        let mut reader = Mfrc522::new(&mut chip, NoDelay);
        let polled =
            pin!(reader.poll(|seen| found.push(seen))).poll(&mut Context::from_waker(Waker::noop()));
        prop_assert_eq!(polled, Poll::Ready(()));
        prop_assert!(!found.iter().any(|found| matches!(found, Ok(Seen::Tag(_)))));
    }
}

/// UIDs, many of which begin with each other.
fn uids() -> impl Strategy<Value = Vec<u8>> {
    prop_oneof![Just(4), Just(7), Just(10)].prop_flat_map(|length| prop::collection::vec(0u8..2, length))
}

/// A chip in whose field is something that answers anything.
struct Anything {
    chip: Chip,
    answers: VecDeque<(Vec<u8>, u8)>,
}

impl ErrorType for Anything {
    type Error = Infallible;
}

impl SpiDevice for Anything {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        let starts = matches!(operations, [Operation::Write([address, value])]
            if *address == BIT_FRAMING << 1 && value & 0x80 != 0);
        if starts {
            let sent = self.chip.fifo.iter().copied().collect();
            let (bytes, bits) = self.answers.pop_front().unwrap_or_default();
            self.chip.field = VecDeque::from([(sent, Answer::Bytes(bytes, bits))]);
        }
        self.chip.transaction(operations)
    }
}
