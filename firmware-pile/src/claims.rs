//! Whether the pile may give itself to a robot: only while no coordinator is heard.
//!
//! The time of silence is longer than any command can be on its way
//! ([`CommandHead::valid_until`](protocol::CommandHead)), so that no grant overtakes the lease that the pile makes
//! for itself; and whatever arrives later, the pile holds one lease at a time. Permission comes with the site's
//! time and is not kept over a restart: a pile that starts while the coordinator is lost serves nobody.

use protocol::{ClaimPile, ClaimRef, Millis, PileRow, limits};

/// How many rows of the pile may have been told since the one that a claim names: a minute of them.
const FRESH_ROWS: u32 = 60;

/// What is known of the coordinator, for claims.
#[derive(Clone, Copy, Debug, Default)]
pub struct Claims {
    allowed: bool,
    heard_at: Millis,
    /// The claim that was served last.
    served: Option<ClaimRef>,
}

impl Claims {
    /// Not allowed yet; no coordinator was heard.
    #[must_use]
    pub const fn new() -> Self {
        Self { allowed: false, heard_at: Millis(0), served: None }
    }

    /// The coordinator was heard.
    pub const fn coordinator_heard(&mut self, now: Millis) {
        self.heard_at = now;
    }

    /// The coordinator says whether claims may be served.
    pub const fn allow(&mut self, allowed: bool) {
        self.allowed = allowed;
    }

    /// The pile has made a lease for this claim.
    pub const fn serve(&mut self, claim: ClaimRef) {
        self.served = Some(claim);
    }

    /// Whether the claim is the one that was served last: a late repeat, once its lease is over.
    #[must_use]
    pub fn was_served(&self, claim: ClaimRef) -> bool {
        self.served == Some(claim)
    }

    /// Whether a claim may be served now.
    #[must_use]
    pub const fn are_open(&self, now: Millis) -> bool {
        self.allowed && now.since(self.heard_at).0 >= limits::COORDINATOR_LOST.0
    }
}

/// Whether `claim` names a row of the pile that is fresh, `told` being the last. One that was recorded names an
/// old one.
#[must_use]
pub fn is_fresh(claim: &ClaimPile, told: &PileRow) -> bool {
    let behind = told.version.checked_sub(claim.version);
    claim.boot == told.boot && behind.is_some_and(|behind| behind <= FRESH_ROWS)
}
