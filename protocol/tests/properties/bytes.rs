//! Frames made by hand, byte by byte, where [`protocol::Frame`] refuses to make them.

use protocol::{BootEpoch, Deframer, DeviceId, Frame, FrameError, Message, Sessions};

/// A header: this version, pile 7, start 3, frame 1.
pub const fn header(version: u8) -> [u8; 12] {
    [version, 1, 7, 0, 3, 0, 0, 0, 1, 0, 0, 0]
}

/// The postcard body of a message.
pub fn body(message: &Message) -> Vec<u8> {
    let mut buffer = [0; 1024];
    postcard::to_slice(message, &mut buffer).unwrap().to_vec()
}

/// Any header and body with the check that belongs to them.
pub fn packet(header: &[u8], body: &[u8]) -> Vec<u8> {
    let content = [header, body].concat();
    let check = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&content);
    [&content[..], &check.to_le_bytes()].concat()
}

/// A packet as it goes over the wire.
pub fn wire(packet: &[u8]) -> Vec<u8> {
    let mut encoded = vec![0; packet.len() + packet.len() / 254 + 3];
    let length = cobs::try_encode_including_sentinels(packet, &mut encoded).unwrap();
    encoded.truncate(length);
    encoded
}

/// A frame around any header and body, good but for them.
pub fn frame(header: &[u8], body: &[u8]) -> Vec<u8> {
    wire(&packet(header, body))
}

/// What a fresh deframer finds in a stream.
pub fn read(stream: &[u8]) -> Vec<Result<Frame, FrameError>> {
    feed(&mut Deframer::new(), stream)
}

/// What a deframer finds in a portion of a stream, for a receiver that believes everyone.
pub fn feed(deframer: &mut Deframer, stream: &[u8]) -> Vec<Result<Frame, FrameError>> {
    let mut sessions = Sessions::insecure(DeviceId::Coordinator, BootEpoch(1));
    let mut found = Vec::new();
    deframer.feed(stream, |result| found.push(result.and_then(|packet| sessions.open(packet))));
    found
}

/// What it finds in a body of the current version, in a frame that is otherwise good.
pub fn read_body(body: &[u8]) -> Vec<Result<Message, FrameError>> {
    let stream = frame(&header(protocol::version::CURRENT), body);
    read(&stream).into_iter().map(|result| result.map(|frame| frame.message)).collect()
}
