//! Seals what a device sends and opens what it gets.

use super::seal::{Receiver, Seal, Sealing};
use crate::{
    error::{FrameError, SealError},
    frame::{self, Frame, FrameBytes, Header},
    ids::{BootEpoch, DeviceId, Sequence},
    key::Key,
    message::Message,
    packet::Packet,
};

/// For whom a message is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Recipient {
    /// One device.
    Device(DeviceId),
    /// All piles of the site, and the robots that have its key: gossip, claims and their answers.
    Piles,
    /// Who has sent a [`Provision`](crate::Provision): the answer to it, which is as plain as that.
    Provisioner,
}

/// Whom a device believes. `Peers` are the [`Session`]s with those that share a key with it: an array
/// on a board, a vector in the coordinator.
#[derive(Clone, Debug)]
pub enum Trust<Peers> {
    /// Anyone: nothing is sealed, whoever can reach the link can say anything. For tests, and for
    /// lines that do not leave a device.
    Insecure,
    /// Who has the key.
    Keys {
        /// What gossip and claims are sealed with; a device that has none neither sends nor believes them.
        site: Option<Key>,
        /// One session for each device it speaks with.
        peers: Peers,
    },
}

/// What is known of one other device: its key, its start, its last frame.
#[derive(Clone, Debug)]
pub struct Session {
    peer: DeviceId,
    key: Key,
    next: Sequence,
    /// The last frame that was taken: which start of the peer, which of its frames.
    heard: Option<(BootEpoch, Sequence)>,
}

impl Session {
    /// A peer that was not heard since this device's start.
    #[must_use]
    pub const fn new(peer: DeviceId, key: Key) -> Self {
        Self { peer, key, next: Sequence(0), heard: None }
    }
}

/// One device's end of all its conversations. Without peers it can only be insecure.
#[derive(Clone, Debug)]
pub struct Sessions<Peers = [Session; 0]> {
    own: DeviceId,
    boot: BootEpoch,
    trust: Trust<Peers>,
    /// Of frames that belong to no session.
    next: Sequence,
}

impl Sessions {
    /// Those of a device without keys, by name: see [`Trust::Insecure`].
    #[must_use]
    pub const fn insecure(own: DeviceId, boot: BootEpoch) -> Self {
        Self::new(own, boot, Trust::Insecure)
    }
}

impl<Peers> Sessions<Peers> {
    /// Those of the device `own` in its start `boot`, which must be greater than in all its starts
    /// before, and not 0.
    #[must_use]
    pub const fn new(own: DeviceId, boot: BootEpoch, trust: Trust<Peers>) -> Self {
        Self { own, boot, trust, next: Sequence(0) }
    }
}

impl<Peers: AsMut<[Session]>> Sessions<Peers> {
    /// The bytes of the next frame.
    ///
    /// # Errors
    /// [`SealError`] if it cannot be sealed, above all because the recipient was not heard yet.
    pub fn seal(&mut self, to: Recipient, message: &Message) -> Result<FrameBytes, SealError> {
        let Trust::Keys { site, peers } = &mut self.trust else {
            let header = Header::new(self.own, self.boot, take_next(&mut self.next)?);
            return Ok(frame::encode(header, message, None)?);
        };
        let (next, seal, key, receiver) = match to {
            Recipient::Provisioner => {
                if !matches!(message, Message::Ack(_) | Message::Nack(_)) {
                    return Err(SealError::Stranger { peer: DeviceId::Service });
                }
                let header = Header::new(self.own, self.boot, take_next(&mut self.next)?);
                return Ok(frame::encode(header, message, None)?);
            }
            Recipient::Piles => {
                let key = site.as_ref().ok_or(SealError::NoSiteKey)?;
                (&mut self.next, Seal::Site, key, Receiver::Site)
            }
            Recipient::Device(peer) => {
                let session = find(peers, peer).ok_or(SealError::Stranger { peer })?;
                let boot = match message {
                    Message::Hello(_) => BootEpoch(0),
                    _ => session.heard.ok_or(SealError::Unheard { peer })?.0,
                };
                (&mut session.next, Seal::Device, &session.key, Receiver::Device(peer, boot))
            }
        };
        let header = Header::new(self.own, self.boot, take_next(next)?);
        Ok(frame::encode(header, message, Some(Sealing { seal, key, receiver }))?)
    }

    /// What a packet says, if it is to be believed: authentic, meant for this start of this device,
    /// and newer than all before it. A [`Provision`](crate::Provision) has no seal and may be anyone's.
    ///
    /// # Errors
    /// [`FrameError`] says why not. An [`Unauthentic`](FrameError::Unauthentic) frame is to be
    /// answered by a `Hello`.
    pub fn open(&mut self, packet: Packet<'_>) -> Result<Frame, FrameError> {
        let header = packet.header();
        let sender = header.sender;
        match (&mut self.trust, packet.seal()) {
            (Trust::Insecure, Seal::None) => {}
            (Trust::Insecure, _) => return Err(FrameError::Sealed { sender }),
            // It comes from a tool that has no key yet for this device; whether to obey is for who holds
            // the device to say.
            (Trust::Keys { .. }, Seal::None) => {
                return match packet.message() {
                    Ok(message @ Message::Provision(_)) if sender == DeviceId::Service => {
                        Ok(Frame { header, message })
                    }
                    _ => Err(FrameError::Unsealed { sender }),
                };
            }
            (Trust::Keys { site, .. }, Seal::Site) => {
                let key = site.as_ref().ok_or(FrameError::Stranger { sender })?;
                check(packet, Sealing { seal: Seal::Site, key, receiver: Receiver::Site })?;
                let message = packet.message()?;
                return match message {
                    message if message.is_of_site() => Ok(Frame { header, message }),
                    _ => Err(FrameError::NotGossip { sender }),
                };
            }
            (Trust::Keys { peers, .. }, Seal::Device) => {
                let session = find(peers, sender).ok_or(FrameError::Stranger { sender })?;
                let boot = if packet.is_hello() { BootEpoch(0) } else { self.boot };
                let receiver = Receiver::Device(self.own, boot);
                check(packet, Sealing { seal: Seal::Device, key: &session.key, receiver })?;
                if let Some((boot, sequence)) = session.heard {
                    if header.boot < boot {
                        return Err(FrameError::EarlierStart { sender });
                    }
                    if header.boot == boot && header.sequence <= sequence {
                        return Err(FrameError::Replayed { sender });
                    }
                }
                session.heard = Some((header.boot, header.sequence));
            }
        }
        Ok(Frame { header, message: packet.message()? })
    }
}

fn find<Peers: AsMut<[Session]>>(peers: &mut Peers, peer: DeviceId) -> Option<&mut Session> {
    peers.as_mut().iter_mut().find(|session| session.peer == peer)
}

/// A number is never used twice in a start.
fn take_next(next: &mut Sequence) -> Result<Sequence, SealError> {
    let taken = *next;
    next.0 = next.0.checked_add(1).ok_or(SealError::Exhausted)?;
    Ok(taken)
}

fn check(packet: Packet<'_>, sealing: Sealing<'_>) -> Result<(), FrameError> {
    match packet.mac() {
        Some(mac) if sealing.holds(packet.content(), mac) => Ok(()),
        _ => Err(FrameError::Unauthentic { sender: packet.header().sender }),
    }
}
