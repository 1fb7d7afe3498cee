//! A simulated device's end of the wire: a UDP socket, frames out of and into datagrams.

use std::{
    io,
    net::{Ipv4Addr, SocketAddr},
};

use protocol::{
    BootEpoch, Deframer, DeviceId, Frame, FrameError, Message, Recipient, Session, Sessions, Trust, limits,
};
use tokio::net::UdpSocket;

/// More frames than this in one step are left for the next.
const FRAMES_PER_STEP: usize = 64;

/// A device's own socket on loopback.
#[derive(Debug)]
pub struct Link {
    socket: UdpSocket,
    sessions: Sessions<Vec<Session>>,
}

impl Link {
    /// A link of `device`, in its first start, at a free port. It believes as `trust` says.
    ///
    /// # Errors
    /// What the operating system says.
    pub async fn bind(device: DeviceId, trust: Trust<Vec<Session>>) -> io::Result<Self> {
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).await?;
        Ok(Self { socket, sessions: Sessions::new(device, BootEpoch(1), trust) })
    }

    /// Where the device can be reached.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.socket.local_addr()
    }

    /// Sends one frame for `to` to each of `addresses`. Like any datagram it may be lost; whoever
    /// sent it repeats what matters.
    pub fn send(
        &mut self,
        to: Recipient,
        message: &Message,
        addresses: impl IntoIterator<Item = SocketAddr>,
    ) {
        // To who was not heard yet nothing is said but Hello.
        let Ok(bytes) = self.sessions.seal(to, message) else { return };
        for address in addresses {
            if let Err(error) = self.socket.try_send_to(&bytes, address) {
                tracing::debug!(%address, %error, "a datagram was not sent");
            }
        }
    }

    /// What has come: frames, and why others are none to be believed.
    pub fn received(&mut self) -> Vec<Result<Frame, FrameError>> {
        let mut frames = Vec::new();
        let mut datagram = [0; 2 * limits::FRAME];
        while frames.len() < FRAMES_PER_STEP {
            // Nothing more, or an error that loopback reports for a peer that is gone.
            let Ok((length, _)) = self.socket.try_recv_from(&mut datagram) else { break };
            let bytes = datagram.get(..length).unwrap_or_default();
            Deframer::new().feed(bytes, |found| {
                frames.push(found.and_then(|packet| self.sessions.open(packet)));
            });
        }
        frames
    }
}
