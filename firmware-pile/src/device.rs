//! What a board is by what it keeps: nobody yet, or a pile.

use crate::store::Kept;
use crate::{ChargingPile, Parameters, provisioning::Fresh};

/// A board.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "there is no heap to box it on, and one board is one device")]
pub enum Device {
    /// It was never provisioned.
    Fresh(Fresh),
    /// It is a pile.
    Pile(ChargingPile),
}

impl Device {
    /// The board that keeps this.
    #[must_use]
    pub fn new(kept: Kept) -> Self {
        match kept.identity {
            None => Self::Fresh(Fresh::new()),
            Some(identity) => {
                Self::Pile(ChargingPile::resume(Parameters::kept(identity, &kept), kept.journal))
            }
        }
    }
}
