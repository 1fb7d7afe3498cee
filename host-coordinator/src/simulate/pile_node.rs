//! A simulated pile: the real firmware core between its own socket and the world's reader field
//! and contacts.

use std::{io, net::SocketAddr, slice};

use firmware_pile::{ChargingPile, Contactor, Input, Outputs, Parameters, TagRead, To};
use protocol::{DeviceId, Message, Millis, PileState, TagId};

use super::link::Link;

/// A pile on the wire.
#[derive(Debug)]
pub struct PileNode {
    core: ChargingPile,
    link: Link,
    coordinator: SocketAddr,
    peers: Vec<SocketAddr>,
    contactor: Contactor,
    said: Option<PileState>,
}

impl PileNode {
    /// A pile that speaks to `coordinator`.
    ///
    /// # Errors
    /// Its socket cannot be opened.
    pub async fn start(parameters: Parameters, coordinator: SocketAddr) -> io::Result<Self> {
        let link = Link::bind(DeviceId::Pile(parameters.pile)).await?;
        let core = ChargingPile::new(parameters);
        Ok(Self { core, link, coordinator, peers: Vec::new(), contactor: Contactor::Open, said: None })
    }

    /// Where the other piles reach this one.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.link.address()
    }

    /// Tells the pile where the others are.
    pub fn meet(&mut self, peers: Vec<SocketAddr>) {
        self.peers = peers;
    }

    /// One poll of the reader, of the contactor's feedback and of the socket.
    pub fn step(&mut self, now: Millis, reads: &[(TagId, i8)]) {
        for frame in self.link.received() {
            self.input(now, Input::Frame(&frame));
        }
        if reads.is_empty() {
            self.input(now, Input::ReaderIdle);
        }
        for &(tag, rssi_dbm) in reads {
            self.input(now, Input::Tag(TagRead { tag, rssi_dbm }));
        }
        let closed = self.closed();
        self.input(now, Input::ContactorFeedback { closed });
    }

    /// Whether the contactor is closed.
    #[must_use]
    pub fn closed(&self) -> bool {
        self.contactor == Contactor::Closed
    }

    /// What the pile last said of itself.
    #[must_use]
    pub const fn said(&self) -> Option<PileState> {
        self.said
    }

    fn input(&mut self, now: Millis, input: Input<'_>) {
        // The simulated pile never loses its memory, so there is no epoch to store.
        let Outputs { contactor, messages, .. } = self.core.step(now, input);
        self.contactor = contactor;
        for outgoing in messages {
            if let Message::PileState(state) = &outgoing.message {
                self.said = Some(*state);
            }
            let addresses = match outgoing.to {
                To::Coordinator => slice::from_ref(&self.coordinator),
                To::Peers => &self.peers,
            };
            self.link.send(outgoing.to.into(), &outgoing.message, addresses.iter().copied());
        }
    }
}
