//! A simulated pile: the real firmware core between its own socket, the world's reader field, and a
//! modelled charger that the world's robots stand on.

use std::{io, net::SocketAddr, slice};

use firmware_pile::{
    ChargingPile, Input, Outputs, Parameters, TagRead, To,
    plant::{Battery, Plant},
};
use protocol::{DeviceId, Message, Millis, PileState, TagId};

use super::link::Link;
use crate::keys::Keys;

/// A pile on the wire.
#[derive(Debug)]
pub struct PileNode {
    core: ChargingPile,
    link: Link,
    coordinator: SocketAddr,
    peers: Vec<SocketAddr>,
    plant: Plant,
    said: Option<PileState>,
}

impl PileNode {
    /// A pile that speaks to `coordinator`, which believes it and which it believes by `keys`.
    ///
    /// # Errors
    /// Its socket cannot be opened.
    pub async fn start(parameters: Parameters, coordinator: SocketAddr, keys: &Keys) -> io::Result<Self> {
        let device = DeviceId::Pile(parameters.pile);
        let link = Link::bind(device, keys.trust_of(device)).await?;
        let core = ChargingPile::new(parameters);
        Ok(Self { core, link, coordinator, peers: Vec::new(), plant: Plant::new(), said: None })
    }

    /// Where the other piles reach this one.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.link.address()
    }

    /// Tells the pile where the others are that hear its gossip: piles and robots.
    pub fn meet(&mut self, peers: Vec<SocketAddr>) {
        self.peers = peers;
    }

    /// One poll of the socket, of the reader, and of the sensors at contacts on which a robot with
    /// this battery stands.
    pub fn step(&mut self, now: Millis, reads: &[(TagId, i8)], battery: Option<Battery>) {
        for found in self.link.received() {
            match found {
                Ok(frame) => self.input(now, Input::Frame(&frame)),
                Err(error) => self.input(now, Input::Discarded(error)),
            }
        }
        if reads.is_empty() {
            self.input(now, Input::ReaderIdle);
        }
        for &(tag, rssi_dbm) in reads {
            self.input(now, Input::Tag(TagRead { tag, rssi_dbm }));
        }
        self.plant.battery = battery;
        let sensors = self.plant.sense(now);
        self.input(now, Input::Sensors(sensors));
    }

    /// Its charger.
    #[must_use]
    pub const fn plant(&self) -> &Plant {
        &self.plant
    }

    /// What the pile last said of itself.
    #[must_use]
    pub const fn said(&self) -> Option<PileState> {
        self.said
    }

    fn input(&mut self, now: Millis, input: Input<'_>) {
        // The simulated pile never loses its memory, so there is nothing to store.
        let Outputs { power, messages, .. } = self.core.step(now, input);
        self.plant.command(power);
        for outgoing in messages {
            if let Message::PileState(state) = &outgoing.message {
                self.said = Some(*state);
            }
            let addresses = match outgoing.to {
                To::Coordinator => slice::from_ref(&self.coordinator),
                To::Peers => &self.peers,
                // Nobody brings a tool to a simulated pile.
                To::Service | To::Provisioner => &[],
            };
            self.link.send(outgoing.to.into(), &outgoing.message, addresses.iter().copied());
        }
    }
}
