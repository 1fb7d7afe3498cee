//! What a frame is sealed with, and what its MAC is computed over.
//!
//! ```text
//!  MAC = BLAKE2s( key = 32 bytes, digest = 16 bytes,
//!                 receiver's kind (1) | receiver's number (2) | receiver's boot epoch (4)
//!                 | header (12) | body )
//! ```
//! The receiver is not sent: who seals and who opens put it in front. The boot epoch is the one that
//! the sender has last heard of; in a `Hello`, which has to reach who was never heard, it is 0.
//! Gossip has no one receiver: kind `FF`, number `FFFF`, boot epoch 0.

use blake2::{
    Blake2sMac,
    digest::{KeyInit, Mac as _, consts::U16},
};

use crate::{
    frame::device_bytes,
    ids::{BootEpoch, DeviceId},
    key::Key,
};

/// Bytes of a MAC.
pub const MAC: usize = 16;

/// A message authentication code.
pub type Mac = [u8; MAC];

/// With whose key a frame is sealed: the two upper bits of its header's kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Seal {
    None,
    /// With the key of the device that sends or receives it.
    Device,
    /// With the key that all piles of the site have.
    Site,
}

const BITS: u8 = 0xC0;

impl Seal {
    pub(crate) const fn bits(self) -> u8 {
        match self {
            Self::None => 0x00,
            Self::Device => 0x40,
            Self::Site => 0x80,
        }
    }

    /// The seal in a header's kind, and the kind without it.
    pub(crate) const fn split(kind: u8) -> Option<(Self, u8)> {
        let seal = match kind & BITS {
            0x00 => Self::None,
            0x40 => Self::Device,
            0x80 => Self::Site,
            _ => return None,
        };
        Some((seal, kind & !BITS))
    }

    /// Bytes of its MAC.
    pub(crate) const fn mac_size(self) -> usize {
        match self {
            Self::None => 0,
            Self::Device | Self::Site => MAC,
        }
    }
}

/// For whom a frame is.
#[derive(Clone, Copy)]
pub(crate) enum Receiver {
    /// A device, in the start that the sender has heard of.
    Device(DeviceId, BootEpoch),
    /// Whoever has the site's key.
    Site,
}

impl Receiver {
    fn bytes(self) -> [u8; 7] {
        let ([kind, n0, n1], boot) = match self {
            Self::Device(device, boot) => (device_bytes(device), boot),
            Self::Site => ([0xFF; 3], BootEpoch(0)),
        };
        let [b0, b1, b2, b3] = boot.0.to_le_bytes();
        [kind, n0, n1, b0, b1, b2, b3]
    }
}

/// A key, and for whom.
pub(crate) struct Sealing<'a> {
    pub seal: Seal,
    pub key: &'a Key,
    pub receiver: Receiver,
}

impl Sealing<'_> {
    /// The MAC of a frame's header and body.
    pub(crate) fn mac(&self, content: &[u8]) -> Mac {
        self.hash(content).finalize().into_bytes().into()
    }

    /// Whether a frame's MAC is that of its header and body. Takes the same time wherever they differ.
    pub(crate) fn holds(&self, content: &[u8], mac: &Mac) -> bool {
        self.hash(content).verify(mac.into()).is_ok()
    }

    fn hash(&self, content: &[u8]) -> Blake2sMac<U16> {
        Blake2sMac::new(self.key.expose().into()).chain_update(self.receiver.bytes()).chain_update(content)
    }
}
