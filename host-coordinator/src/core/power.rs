//! The facility's power: all piles together are never given more than it has.
//!
//! A pile counts with its whole power from the grant of a lease until the lease is over for sure, and
//! while it is promised to a robot that comes next, so that a promise never lacks power. A pile that reports
//! a holder that is in no log counts too, one whose lease ran out while it was silent until it is heard, and
//! after a start every pile that was not heard yet, for as long as a device may be silent.

use protocol::{Availability, PileId, RobotId, SiteMillis, limits};

use super::coordinator::Coordinator;
use crate::{
    selection::{Choice, Stage, Verdict},
    site::SitePile,
};

impl Coordinator {
    /// The power of all piles that draw any, or may, in watts.
    pub(super) fn granted_w(&self, now: SiteMillis) -> f64 {
        let draw = self.site.piles.iter().filter(|pile| self.may_draw(pile.id, now));
        draw.fold(0.0, |sum, pile| sum + f64::from(pile.power_w))
    }

    /// What is left for piles that draw none yet, in watts.
    pub(super) fn power_left_w(&self, now: SiteMillis) -> f64 {
        self.policy.power_cap_w.map_or(f64::INFINITY, |cap_w| cap_w - self.granted_w(now))
    }

    /// Whether `left_w` watts are enough for a pile, which may draw its power already.
    pub(super) fn has_power_for(&self, pile: &SitePile, left_w: f64, now: SiteMillis) -> bool {
        f64::from(pile.power_w) <= left_w || self.may_draw(pile.id, now)
    }

    fn may_draw(&self, pile: PileId, now: SiteMillis) -> bool {
        let record = self.state.piles.get(&pile);
        let booked = record.is_some_and(|record| record.lease.is_some() || record.next.is_some());
        let report = self.observed.piles.get(&pile).and_then(|seen| seen.report);
        let unknown = || {
            let charges_on = record.is_some_and(|record| record.may_charge_on);
            charges_on || now.since(self.observed.started) <= limits::SILENCE
        };
        booked || report.map_or_else(unknown, |report| report.energised || report.holder.is_some())
    }

    /// Takes a robot's choice back for which others have taken the power in the meantime, and says so of every pile
    /// that lacks nothing else.
    pub(super) fn keep_within_power(&self, robot: RobotId, choice: &mut Choice, now: SiteMillis) {
        let left_w = self.power_left_w(now);
        let lacks = |pile| {
            self.site.pile(pile).is_some_and(|pile| !self.has_power_for(pile, left_w, now))
                && self.availability_for(robot, pile, now) == Some(Availability::Free)
        };
        if choice.chosen.is_some_and(lacks) {
            (choice.chosen, choice.stage) = (None, Stage::None);
        }
        for row in &mut choice.explanations {
            if matches!(row.verdict, Verdict::Chosen | Verdict::Taken(_)) && lacks(row.pile) {
                row.verdict = Verdict::NoPower;
            }
        }
    }
}
