//! Frames that arrive intact, whatever is in them.
//!
//! An input is a header's 12 bytes and a body. First it goes out as it is, with the check that belongs
//! to it: no fuzzer would find that by itself. Then, if the body is a message, a device says it under
//! a seal, and the first bytes of the header say what is done to the frame on its way.

use protocol::auth::{Recipient, Session, Sessions, Trust};
use protocol::{
    BootEpoch, Deframer, DeviceId, Frame, FrameError, Header, Hello, Key, Message, PileId, limits,
};

use crate::tried::Tried;

const CRC: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);
const PILE: DeviceId = DeviceId::Pile(PileId(7));

/// Reads a frame as it is and, if it says something, as another device's.
pub fn run(input: &[u8]) -> Tried {
    let mut tried = Tried::default();
    let Some((header, body)) = input.split_first_chunk::<{ limits::HEADER }>() else { return tried };
    let mut anyone = Sessions::insecure(PILE, BootEpoch(1));
    let read = open(&mut anyone, &with_check(input));
    tried.add(read.is_ok());
    if let Ok(frame) = read {
        comes_back(&frame);
    }
    if let Ok(message) = postcard::from_bytes::<Message>(body) {
        tried += sealed(&message, *header);
    }
    tried
}

/// What was read is written, and read as the same.
fn comes_back(frame: &Frame) {
    let header = Header::new(frame.header.sender, frame.header.boot, frame.header.sequence);
    let written = Frame { header, message: frame.message.clone() };
    let bytes = written.encode().expect("a message that was read fits a frame");
    assert!(bytes.len() <= limits::FRAME);
    assert_eq!(open(&mut Sessions::insecure(PILE, BootEpoch(1)), &bytes), Ok(written));
}

/// The coordinator says it to a pile: it is believed once, and not if anything was changed.
fn sealed(message: &Message, damage: [u8; limits::HEADER]) -> Tried {
    let (mut coordinator, mut pile) = acquainted();
    let bytes = coordinator.seal(Recipient::Device(PILE), message).expect("they have met");
    let mut tried = Tried::default();

    let packet = uncovered(&bytes);
    let mut changed = packet.clone();
    for [at, flip] in damage.as_chunks::<2>().0.iter().take(2) {
        let length = changed.len();
        changed[usize::from(*at) % length] ^= flip;
    }
    // As an attacker does it, who knows how to make a check.
    let changed = with_check(&changed[..changed.len() - limits::CHECK]);
    let same = *changed == *bytes;
    if !same {
        let opened = open(&mut pile, &changed);
        tried.add(opened.is_ok());
        // A pile obeys anyone's provisioning only while somebody holds its button.
        assert!(matches!(opened, Err(_) | Ok(Frame { message: Message::Provision(_), .. })), "{opened:?}");
    }
    let opened = open(&mut pile, &bytes);
    tried.add(opened.is_ok());
    assert_eq!(opened.map(|frame| frame.message), Ok(message.clone()), "what is changed costs nothing else");
    let repeated = open(&mut pile, &bytes);
    tried.add(repeated.is_ok());
    assert_eq!(repeated, Err(FrameError::Replayed { sender: DeviceId::Coordinator }));
    tried
}

/// A coordinator and a pile that have heard each other's Hello.
fn acquainted() -> (Sessions<[Session; 1]>, Sessions<[Session; 1]>) {
    let key = Key::new([0xA5; 32]);
    let end = |own, boot, peer| {
        let trust = Trust::Keys { site: None, peers: [Session::new(peer, key)] };
        Sessions::new(own, BootEpoch(boot), trust)
    };
    let mut coordinator = end(DeviceId::Coordinator, 3, PILE);
    let mut pile = end(PILE, 5, DeviceId::Coordinator);
    let hello = Message::Hello(Hello { min: 1, current: 1, software: [0; 3], epoch: protocol::Epoch(1) });
    let said = coordinator.seal(Recipient::Device(PILE), &hello).unwrap();
    open(&mut pile, &said).unwrap();
    let said = pile.seal(Recipient::Device(DeviceId::Coordinator), &hello).unwrap();
    open(&mut coordinator, &said).unwrap();
    (coordinator, pile)
}

/// Header and body, or with a MAC behind them, as they go over the wire.
fn with_check(content: &[u8]) -> Vec<u8> {
    let packet = [content, &CRC.checksum(content).to_le_bytes()].concat();
    let mut encoded = vec![0; packet.len() + packet.len() / 254 + 3];
    let length = cobs::try_encode_including_sentinels(&packet, &mut encoded).unwrap();
    encoded.truncate(length);
    encoded
}

/// What is between the delimiters, without COBS.
fn uncovered(bytes: &[u8]) -> Vec<u8> {
    let mut between = bytes[1..bytes.len() - 1].to_vec();
    let length = cobs::decode_in_place(&mut between).unwrap();
    between.truncate(length);
    between
}

/// The one frame in `bytes`, if it is one and believed.
fn open<Peers: AsMut<[Session]>>(sessions: &mut Sessions<Peers>, bytes: &[u8]) -> Result<Frame, FrameError> {
    let mut opened = Vec::new();
    Deframer::new().feed(bytes, |packet| opened.push(packet.and_then(|packet| sessions.open(packet))));
    assert_eq!(opened.len(), 1);
    opened.remove(0)
}
