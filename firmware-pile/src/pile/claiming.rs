//! A robot that hears no coordinator asks the pile for itself.

use protocol::{ClaimPile, ClaimRef, LeaseId, NackReason, Reference, RobotId};

use super::{ChargingPile, answered, say};
use crate::{
    claims,
    io::{Messages, To},
};

impl ChargingPile {
    /// Serves the claim, or says why not.
    pub(super) fn hear_claim(&mut self, robot: RobotId, claim: &ClaimPile, messages: &mut Messages) {
        let of = ClaimRef { robot, request: claim.request };
        let count = self.counters.claims.saturating_add(1);
        let answer = if !self.claims.are_open(self.now) || !self.reports.has_place() {
            Err(NackReason::NotClaimable)
        } else if self.leases.current().is_none() && self.claims.was_served(of) {
            Err(NackReason::Ended)
        } else if !claims::is_fresh(claim, &self.row()) {
            Err(NackReason::TooLate)
        } else {
            let (planned, place) = (self.planned(claim.energy), self.place(claim.tag));
            self.leases.claim(LeaseId::local(count), robot, claim, planned, place)
        };
        // The number must be stored before anybody hears of it.
        if self.leases.current().is_some_and(|lease| lease.name.lease == LeaseId::local(count)) {
            self.counters.claims = count;
            self.claims.serve(of);
        }
        say(messages, To::Peers, answered(Reference::Claim(of), answer));
    }
}
