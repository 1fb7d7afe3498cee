//! TCP: a stream of frames in both directions, from devices that call and to piles that are
//! called.

use std::{
    net::SocketAddr,
    sync::atomic::{AtomicU64, Ordering},
    time::Duration,
};

use protocol::{Deframer, DeviceId, FrameBytes, PileId};
use tokio::{
    io::{AsyncReadExt, AsyncWriteExt},
    net::{TcpListener, TcpStream, tcp::OwnedWriteHalf},
    sync::mpsc,
    task::JoinSet,
    time,
};

use super::{Inbound, Peer, lock};
use crate::core::Input;

/// Frames that wait for a slow peer.
const QUEUE: usize = 64;
/// A peer that takes no byte for this long is hung up.
const STUCK: Duration = Duration::from_secs(10);
/// How long to wait between calls: at first, and at most.
const BACK_OFF: (Duration, Duration) = (Duration::from_millis(250), Duration::from_secs(8));

/// The sending side of a connection.
#[derive(Clone, Debug)]
pub struct Connection {
    number: u64,
    queue: mpsc::Sender<FrameBytes>,
}

impl Connection {
    /// Queues a frame; `false` if the peer is too slow.
    pub fn send(&self, bytes: FrameBytes) -> bool {
        !matches!(self.queue.try_send(bytes), Err(mpsc::error::TrySendError::Full(_)))
    }
}

/// Accepts connections for ever.
pub async fn listen(inbound: Inbound, listener: TcpListener) {
    let mut connections = JoinSet::new();
    loop {
        tokio::select! {
            accepted = listener.accept() => match accepted {
                Ok((stream, address)) => {
                    connections.spawn(serve(inbound.clone(), stream, address));
                }
                Err(error) => {
                    inbound.links.warnings.note(format!("cannot accept a TCP connection: {error}"));
                    time::sleep(BACK_OFF.0).await;
                }
            },
            Some(_) = connections.join_next() => {}
        }
    }
}

/// Calls a pile, again and again.
pub async fn call(inbound: Inbound, pile: PileId, address: SocketAddr) {
    let mut pause = BACK_OFF.0;
    loop {
        match TcpStream::connect(address).await {
            Ok(stream) => {
                pause = BACK_OFF.0;
                serve(inbound.clone(), stream, address).await;
                inbound
                    .links
                    .warnings
                    .note(format!("pile {pile} at {address} has hung up; calling it again"));
            }
            Err(error) => inbound.links.warnings.note(format!(
                "cannot connect to pile {pile} at {address}: {error}; is it on, and is the address right?"
            )),
        }
        time::sleep(pause).await;
        pause = BACK_OFF.1.min(pause * 2);
    }
}

/// Serves a connection until either side ends it.
async fn serve(inbound: Inbound, stream: TcpStream, address: SocketAddr) {
    static NUMBERS: AtomicU64 = AtomicU64::new(0);
    // Frames are small and wanted now.
    if stream.set_nodelay(true).is_err() {
        return;
    }
    let (mut reader, writer) = stream.into_split();
    let (queue, frames) = mpsc::channel(QUEUE);
    let number = NUMBERS.fetch_add(1, Ordering::Relaxed);
    let peer = Peer::Tcp(Connection { number, queue });
    let read = async {
        let mut deframer = Deframer::new();
        let mut buffer = [0; 2048];
        while let Ok(length @ 1..) = reader.read(&mut buffer).await {
            let mut busy = Vec::new();
            deframer.feed(buffer.get(..length).unwrap_or_default(), |found| {
                busy.extend(inbound.take(&peer, address, found));
            });
            wait_for_room(&inbound, busy).await;
        }
    };
    tokio::select! {
        () = read => {}
        () = write(writer, frames) => {}
    }
    let ours = |peer: &Peer| matches!(peer, Peer::Tcp(connection) if connection.number == number);
    for addresses in [&inbound.links.peers, &inbound.links.claims] {
        lock(addresses).retain(|_: &DeviceId, peer| !ours(peer));
    }
}

/// A stream can wait: frames that the busy coordinator gave back go in when there is room.
async fn wait_for_room(inbound: &Inbound, busy: Vec<Input>) {
    for input in busy {
        // Fails only when the coordinator has stopped.
        let _ = inbound.inputs.send(input).await;
    }
}

async fn write(mut writer: OwnedWriteHalf, mut frames: mpsc::Receiver<FrameBytes>) {
    while let Some(bytes) = frames.recv().await {
        match time::timeout(STUCK, writer.write_all(&bytes)).await {
            Ok(Ok(())) => {}
            Ok(Err(_)) | Err(_) => return,
        }
    }
}
