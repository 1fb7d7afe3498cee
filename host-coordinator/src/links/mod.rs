//! Frames to and from piles and robots, by UDP and TCP.
//!
//! A device has no address of its own: it is where its last authentic frame came from that was neither
//! gossip nor a claim, which can be recorded and sent again. To where a frame
//! came from that says it is of a device and does not authenticate, nothing but Hello is sent. Devices
//! that are not of the site are refused with a warning that names them and their address. Whatever a peer does,
//! the coordinator does not wait for it: every connection has a bounded queue, and what does not
//! fit is dropped, because everything worth saying is said again.
//!
//! Piles gossip about their states (LMPP Figs. 1 to 3). Those on UDP reach each other; a pile at
//! the end of a TCP connection hears them, and is heard by them, through here.

mod tcp;
mod udp;

use std::{
    collections::{BTreeMap, BTreeSet},
    io,
    net::SocketAddr,
    sync::{Arc, Mutex, PoisonError},
};

use protocol::{DeviceId, FrameBytes, FrameError, Message, Packet, PileId, Recipient, Session, Sessions};
use tokio::{
    net::{TcpListener, UdpSocket},
    sync::mpsc,
    task::JoinSet,
};

use crate::{core::Input, daemon::warnings::Warnings};

/// The sockets of a coordinator, bound.
#[derive(Debug)]
pub struct Sockets {
    /// For datagrams of one frame each.
    pub udp: UdpSocket,
    /// For streams of frames.
    pub tcp: TcpListener,
}

/// The way out: sends to every device that was heard.
#[derive(Debug)]
pub struct Links {
    peers: Mutex<BTreeMap<DeviceId, Peer>>,
    /// Where frames came from that did not authenticate, until they are answered.
    claims: Mutex<BTreeMap<DeviceId, Peer>>,
    sessions: Mutex<Sessions<Vec<Session>>>,
    udp: UdpSocket,
    warnings: Warnings,
}

/// The way in: what the tasks that read have in common.
#[derive(Clone, Debug)]
struct Inbound {
    links: Arc<Links>,
    known: Arc<BTreeSet<DeviceId>>,
    inputs: mpsc::Sender<Input>,
}

/// Where a device is.
#[derive(Clone, Debug)]
enum Peer {
    Udp(SocketAddr),
    Tcp(tcp::Connection),
}

/// Starts to listen, and to call the piles in `connect`. Frames of the `known` devices go to
/// `inputs`. The tasks end with the set, and with them
/// the last sender of `inputs` that is here.
pub fn start(
    sockets: Sockets,
    known: BTreeSet<DeviceId>,
    sessions: Sessions<Vec<Session>>,
    connect: &[(PileId, SocketAddr)],
    inputs: mpsc::Sender<Input>,
    warnings: Warnings,
) -> (Arc<Links>, JoinSet<()>) {
    let links = Arc::new(Links {
        peers: Mutex::default(),
        claims: Mutex::default(),
        sessions: Mutex::new(sessions),
        udp: sockets.udp,
        warnings,
    });
    let inbound = Inbound { links: Arc::clone(&links), known: Arc::new(known), inputs };
    let mut tasks = JoinSet::new();
    tasks.spawn(udp::receive(inbound.clone()));
    tasks.spawn(tcp::listen(inbound.clone(), sockets.tcp));
    for &(pile, address) in connect {
        tasks.spawn(tcp::call(inbound.clone(), pile, address));
    }
    (links, tasks)
}

impl Links {
    /// Sends a message if the device was heard since the start. Never waits.
    pub fn send(&self, to: DeviceId, message: &Message) {
        let peer = lock(&self.peers).get(&to).cloned();
        let claim = match message {
            Message::Hello(_) => lock(&self.claims).remove(&to),
            _ => None,
        };
        for peer in peer.into_iter().chain(claim) {
            self.transmit(to, peer, Recipient::Device(to), message);
        }
    }

    fn transmit(&self, to: DeviceId, peer: Peer, sealed_for: Recipient, message: &Message) {
        // To who was not heard yet nothing is said but Hello; it comes again.
        let Ok(bytes) = lock(&self.sessions).seal(sealed_for, message) else { return };
        match peer {
            Peer::Udp(address) => self.send_datagram(to, address, &bytes),
            Peer::Tcp(connection) => {
                if !connection.send(bytes) {
                    self.warnings.note(format!("{to} does not read its TCP connection; frames are dropped"));
                }
            }
        }
    }

    fn send_datagram(&self, to: DeviceId, address: SocketAddr, bytes: &FrameBytes) {
        match self.udp.try_send_to(bytes, address) {
            Ok(_) => {}
            // A full buffer is like a loss on the way.
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
            Err(error) => self.warnings.note(format!("cannot send to {to} at {address}: {error}")),
        }
    }

    /// Passes gossip on to the piles that cannot hear it themselves.
    fn forward(&self, sender: DeviceId, from: &Peer, gossip: &Message) {
        let hears = |(device, peer): &(&DeviceId, &Peer)| {
            matches!(device, DeviceId::Pile(_))
                && **device != sender
                && !matches!((from, peer), (Peer::Udp(_), Peer::Udp(_)))
        };
        let others: Vec<_> =
            lock(&self.peers).iter().filter(hears).map(|(pile, peer)| (*pile, peer.clone())).collect();
        for (pile, peer) in others {
            self.transmit(pile, peer, Recipient::Piles, gossip);
        }
    }
}

impl Inbound {
    /// Takes a packet, or what was none, from a peer. Gives it back if the coordinator is busy.
    fn take(&self, from: &Peer, address: SocketAddr, found: Result<Packet<'_>, FrameError>) -> Option<Input> {
        match found.and_then(|packet| self.open(from, address, packet)) {
            Ok(input) => match self.inputs.try_send(input?) {
                Err(mpsc::error::TrySendError::Full(input)) => Some(input),
                _ => None,
            },
            // Networks repeat frames.
            Err(FrameError::Replayed { .. }) => None,
            Err(error) => {
                self.links.warnings.note(format!("from {address}: {error}"));
                None
            }
        }
    }

    /// What the coordinator is to be told of a packet, if anything.
    fn open(
        &self,
        from: &Peer,
        address: SocketAddr,
        packet: Packet<'_>,
    ) -> Result<Option<Input>, FrameError> {
        let sender = packet.header().sender;
        if !self.known.contains(&sender) {
            self.links.warnings.note(format!(
                "{sender} at {address} is not of this site and is refused; \
                 add it to the site or the configuration if it should be"
            ));
            return Ok(None);
        }
        // On its own, so that the sessions are not locked below.
        let opened = lock(&self.links.sessions).open(packet);
        let frame = match opened {
            Err(FrameError::Unauthentic { sender }) => {
                lock(&self.links.claims).insert(sender, from.clone());
                return Ok(Some(Input::Distrusted(sender)));
            }
            opened => opened?,
        };
        // What goes under the site's key says nothing of where its sender is: it may have been recorded.
        if frame.message.is_of_site() {
            if let Message::PileTable(_) = frame.message {
                self.links.forward(sender, from, &frame.message);
            }
            return Ok(None);
        }
        lock(&self.links.peers).insert(sender, from.clone());
        Ok(Some(Input::Frame(frame)))
    }
}

/// A lock whose holder panicked protects data that is whole: no holder leaves it half changed.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
