//! A damaged frame is never taken for another message and never costs the next one.
//!
//! COBS can turn one flipped bit into several, so no bound on the number of flips is proven: what is
//! left is the one chance in 2³² of any CRC-32. For the frames below every flip was tried.

use proptest::{prelude::*, sample::Index};
use protocol::{
    Ack, BootEpoch, CommandId, DeviceId, Frame, FrameError, Header, Message, PileId, Reference, Sequence,
    Unassigned, UnassignedReason,
};

use crate::{
    bytes::{body, header, packet, read, wire},
    largest,
    strategies::frame,
};

fn frame_of(message: Message) -> Frame {
    Frame { header: Header::new(DeviceId::Pile(PileId(7)), BootEpoch(3), Sequence(1)), message }
}

/// A good frame to come after the damaged one.
fn next() -> Frame {
    frame_of(Message::Unassigned(Unassigned {
        request: protocol::RequestId(9),
        reason: UnassignedReason::AllTaken,
    }))
}

fn flip(stream: &mut [u8], bit: usize) {
    stream[bit / 8] ^= 1 << (bit % 8);
}

/// Whether nothing but `sent` is found in the damaged frame, and the good frame after it.
fn only_costs_itself(damaged: &[u8], sent: &Frame) -> bool {
    let next = next();
    let stream = [damaged, &next.encode().unwrap()].concat();
    let mut found: Vec<Frame> = read(&stream).into_iter().flatten().collect();
    found.pop() == Some(next) && found.iter().all(|frame| frame == sent)
}

#[test]
fn every_bit_of_a_packet_is_checked() {
    for (message, name, _) in largest::messages() {
        let mut packet = packet(&header(1), &body(&message));
        for bit in 0..8 * packet.len() {
            flip(&mut packet, bit);
            assert_eq!(read(&wire(&packet)), [Err(FrameError::Crc)], "{name}, bit {bit}");
            flip(&mut packet, bit);
        }
    }
}

#[test]
fn every_single_flip_in_the_largest_frame_of_every_message_costs_that_frame_only() {
    for (message, name, _) in largest::messages() {
        let sent = frame_of(message);
        let mut damaged = sent.encode().unwrap();
        for bit in 0..8 * damaged.len() {
            flip(&mut damaged, bit);
            assert!(only_costs_itself(&damaged, &sent), "{name}, bit {bit}");
            flip(&mut damaged, bit);
        }
    }
}

#[test]
fn every_two_and_three_flips_in_a_short_frame_cost_that_frame_only() {
    let sent = frame_of(Message::Ack(Ack { of: Reference::Command(CommandId(5)) }));
    let mut damaged = sent.encode().unwrap();
    let bits = 8 * damaged.len();
    for first in 0..bits {
        flip(&mut damaged, first);
        for second in first + 1..bits {
            flip(&mut damaged, second);
            assert!(only_costs_itself(&damaged, &sent), "bits {first}, {second}");
            for third in second + 1..bits {
                flip(&mut damaged, third);
                assert!(only_costs_itself(&damaged, &sent), "bits {first}, {second}, {third}");
                flip(&mut damaged, third);
            }
            flip(&mut damaged, second);
        }
        flip(&mut damaged, first);
    }
}

proptest! {
    #[test]
    fn a_few_flips_anywhere_cost_that_frame_only(
        sent in frame(), bits: [Index; 3], flips in 1..=3_usize,
    ) {
        let mut damaged = sent.encode().unwrap();
        for bit in &bits[..flips] {
            let bit = bit.index(8 * damaged.len());
            flip(&mut damaged, bit);
        }
        prop_assert!(only_costs_itself(&damaged, &sent));
    }

    #[test]
    fn a_burst_costs_the_frame_it_hits_only(sent in frame(), start: Index, pattern: u64) {
        let mut damaged = sent.encode().unwrap();
        let bits = 8 * damaged.len();
        let start = start.index(bits);
        for bit in (start..bits.min(start + 64)).filter(|bit| pattern >> (bit - start) & 1 == 1) {
            flip(&mut damaged, bit);
        }
        prop_assert!(only_costs_itself(&damaged, &sent));
    }

    #[test]
    fn lost_and_doubled_bytes_cost_the_frame_they_hit_only(sent in frame(), lost: Index, doubled: Index) {
        let mut damaged = sent.encode().unwrap().to_vec();
        damaged.remove(lost.index(damaged.len()));
        let doubled = doubled.index(damaged.len());
        damaged.insert(doubled, damaged[doubled]);
        prop_assert!(only_costs_itself(&damaged, &sent));
    }
}
