//! A stream of any bytes: every packet in it is found, and nothing else.

use protocol::auth::Sessions;
use protocol::frame::DELIMITER;
use protocol::packet::Packet;
use protocol::{BootEpoch, Deframer, DeviceId, FrameError, Header, limits};

use crate::tried::Tried;

/// Compares the deframer with a split at the delimiters, and opens what it finds.
pub fn run(stream: &[u8]) -> Tried {
    let mut found: Vec<Result<Header, FrameError>> = Vec::new();
    let mut tried = Tried::default();
    let mut sessions = Sessions::insecure(DeviceId::Coordinator, BootEpoch(1));
    Deframer::new().feed(stream, |packet| {
        found.push(packet.map(|packet| packet.header()));
        tried.add(packet.and_then(|packet| sessions.open(packet)).is_ok());
    });
    assert_eq!(found, split(stream));
    tried
}

/// What stands between two delimiters, or before the first.
fn split(stream: &[u8]) -> Vec<Result<Header, FrameError>> {
    let Some(last) = stream.iter().rposition(|&byte| byte == DELIMITER) else { return Vec::new() };
    let pieces = stream[..last].split(|&byte| byte == DELIMITER).filter(|piece| !piece.is_empty());
    pieces
        .map(|piece| {
            if piece.len() > limits::ENCODED {
                Err(FrameError::Oversize)
            } else {
                Packet::decode(&mut piece.to_vec()).map(|packet| packet.header())
            }
        })
        .collect()
}
