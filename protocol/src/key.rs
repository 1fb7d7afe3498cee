//! A secret that two devices share.

use core::fmt;

use serde::{Deserialize, Serialize};

use crate::max_size::MaxSize;

/// Bytes of a [`Key`].
pub const KEY: usize = 32;

/// A secret key. Its bytes are in no log: neither `Debug` nor `defmt` shows them. It is written in
/// two places only, [`Provision`](crate::Provision) and the coordinator's file of keys.
#[derive(Clone, Copy, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Key([u8; KEY]);

impl Key {
    /// The key of these bytes, which come from a source of true randomness.
    #[must_use]
    pub const fn new(bytes: [u8; KEY]) -> Self {
        Self(bytes)
    }

    /// The secret itself, for what stores or uses it.
    #[must_use]
    pub const fn expose(&self) -> &[u8; KEY] {
        &self.0
    }
}

impl PartialEq for Key {
    /// Takes the same time wherever the two differ.
    fn eq(&self, other: &Self) -> bool {
        self.0.iter().zip(&other.0).fold(0, |different, (ours, theirs)| different | (ours ^ theirs)) == 0
    }
}

impl Eq for Key {}

impl MaxSize for Key {
    const MAX_SIZE: usize = KEY;
}

impl fmt::Debug for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Key(secret)")
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Key {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "Key(secret)");
    }
}
