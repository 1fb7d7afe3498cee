//! Whether a pile keeps its promises, looked at from outside after every step of its core.

use firmware_pile::lease::{EXTENSION_GRACE, Lease};
use protocol::{DurationMs, EndedLease, LeaseRef, Millis, PileId, RobotId, SiteMillis};

use super::breach::Breach;
use crate::{
    core::state::{self, Phase},
    simulate::auditor::Violation,
};

/// How long current may flow on when its lease has ended: it is taken away along a ramp.
const RAMP: DurationMs = DurationMs(500);
/// How long a pile and the coordinator may disagree about a holder: news need time to travel.
const NEWS: DurationMs = DurationMs(10_000);
/// How long a lease that a pile made for itself may not be in the book of a coordinator that hears the pile: an
/// offer of its own has to run out first.
const RECONCILED: DurationMs = DurationMs(60_000);
/// How late an idle pile may notice something here.
const NOTICE: DurationMs = DurationMs(2_000);

/// A pile at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Sight<'a> {
    /// Which.
    pub pile: PileId,
    /// The lease it holds to.
    pub lease: Option<&'a Lease>,
    /// The lease that it says ended last.
    pub ended: Option<EndedLease>,
    /// What its power stage may give, in amperes.
    pub limit_a: f32,
    /// Who stands on its contacts.
    pub docked: Option<RobotId>,
    /// The site's time as far as it knows.
    pub site_now: Option<SiteMillis>,
    /// The coordinator's lease of it.
    pub booked: Option<&'a state::Lease>,
    /// Whether the coordinator is there and the two hear each other.
    pub connected: bool,
}

/// What is remembered of a pile between two looks.
#[derive(Clone, Debug, Default)]
pub struct PileWatch {
    held: Option<LeaseRef>,
    expiry: SiteMillis,
    /// When it last held to a lease.
    held_at: Millis,
    disputed_since: Option<Millis>,
    /// When the coordinator was first heard past the lease's expiry.
    heard_past: Option<Millis>,
    /// Since when a lease of its own is not in the coordinator's book.
    unbooked_since: Option<Millis>,
}

impl PileWatch {
    /// The pile has lost its power.
    pub fn restarted(&mut self) {
        *self = Self::default();
    }

    /// The pile takes a frame of the coordinator, at a time of the site as far as it knows.
    pub fn hears(&mut self, now: Millis, site_now: Option<SiteMillis>) {
        if site_now.is_some_and(|site_now| site_now >= self.expiry) {
            self.heard_past.get_or_insert(now);
        }
    }

    /// What is wrong with what is seen, if anything.
    pub fn look(&mut self, now: Millis, sight: &Sight<'_>) -> Option<Breach> {
        let Sight { pile, lease, .. } = *sight;
        let before = self.held;
        self.held = lease.map(|lease| lease.name);
        if let (Some(before), Some(lease)) = (before, lease)
            && before.lease != lease.name.lease
            && sight.ended.is_none_or(|ended| ended.lease.lease != before.lease)
        {
            return Some(Breach::DoubleGrant(Violation::Replaced { pile, lease: before.lease }));
        }
        let expiry = lease.map_or(self.expiry, |lease| lease.expiry);
        if expiry != self.expiry || before.map(|name| name.lease) != self.held.map(|name| name.lease) {
            self.expiry = expiry;
            self.heard_past = None;
        }
        if lease.is_some() {
            self.held_at = now;
        }
        self.energy(now, sight)
            .or_else(|| self.life(now, sight))
            .or_else(|| self.dispute(now, sight))
            .or_else(|| self.reconcile(now, sight))
    }

    /// Energy is for the holder of a lease.
    fn energy(&self, now: Millis, sight: &Sight<'_>) -> Option<Breach> {
        let Sight { pile, lease, docked, limit_a, .. } = *sight;
        if limit_a <= 0.0 {
            return None;
        }
        match (lease, docked) {
            (None, _) => (now.since(self.held_at) > RAMP).then_some(Breach::Unleased { pile }),
            (Some(lease), Some(robot)) if robot != lease.name.robot => {
                Some(Breach::DoubleGrant(Violation::WrongRobot { pile, robot }))
            }
            _ => None,
        }
    }

    /// No lease lives beyond its expiry, but under a charge while the coordinator is not heard; and no
    /// charge beyond its planned end.
    fn life(&self, now: Millis, sight: &Sight<'_>) -> Option<Breach> {
        let lease = sight.lease?;
        let over = match lease.charge {
            Some(charge) => {
                let heard = self
                    .heard_past
                    .is_some_and(|heard| now.since(heard) > DurationMs(EXTENSION_GRACE.0 + NOTICE.0));
                // The site's clock may have been set back meanwhile.
                (heard && sight.site_now.is_some_and(|site_now| site_now >= lease.expiry))
                    || charge.elapsed().0 > charge.planned().0.saturating_add(NOTICE.0)
            }
            None => sight.site_now.is_none_or(|site_now| site_now > lease.expiry.after(NOTICE)),
        };
        over.then_some(Breach::HeldTooLong { pile: sight.pile, lease: lease.name.lease })
    }

    /// Pile and coordinator agree about the holder, as soon as news have travelled.
    fn dispute(&mut self, now: Millis, sight: &Sight<'_>) -> Option<Breach> {
        let booked = sight.booked.filter(|booked| matches!(booked.phase, Phase::Held { .. }));
        let (Some(lease), Some(booked)) = (sight.lease, booked) else {
            self.disputed_since = None;
            return None;
        };
        // Of what a pile settles by itself the coordinator learns when it hears it.
        let unheard = lease.name.lease.is_local() && !sight.connected;
        if lease.name.robot == booked.name.robot || unheard {
            self.disputed_since = None;
            return None;
        }
        let since = *self.disputed_since.get_or_insert(now);
        let (holder, granted) = (lease.name.robot, booked.name.robot);
        let disputed = Violation::Disputed { pile: sight.pile, holder, granted };
        (now.since(since) > NEWS).then_some(Breach::DoubleGrant(disputed))
    }
}

impl PileWatch {
    /// A lease that the pile made for itself is in the coordinator's book as soon as it can be.
    fn reconcile(&mut self, now: Millis, sight: &Sight<'_>) -> Option<Breach> {
        let lease = sight.lease.map(|lease| lease.name).filter(|lease| lease.lease.is_local());
        let booked = sight.booked.is_some_and(|booked| lease.is_some_and(|lease| booked.is_called(lease)));
        let Some(lease) = lease.filter(|_| sight.connected && !booked) else {
            self.unbooked_since = None;
            return None;
        };
        let since = *self.unbooked_since.get_or_insert(now);
        let late = now.since(since) > RECONCILED;
        late.then_some(Breach::Unreconciled { pile: sight.pile, lease: lease.lease })
    }
}

#[cfg(test)]
mod tests {
    use firmware_pile::lease::{Leases, Place};
    use protocol::{
        BootEpoch, ClaimPile, CommandHead, CommandId, EndReason, EnergyJ, Epoch, Grant, LeaseId, RequestId,
        TagId,
    };

    use super::*;
    use crate::core::event::RevokeReason;

    const PILE: PileId = PileId(3);
    const EXPIRY: SiteMillis = SiteMillis(60_000);

    fn name(lease: u32, robot: u16) -> LeaseRef {
        LeaseRef { epoch: Epoch(1), lease: LeaseId(lease), robot: RobotId(robot) }
    }

    /// A pile that was granted a lease which plans a charge of ten seconds.
    fn granted(lease: u32, robot: u16) -> Leases {
        let mut leases = Leases::new(Epoch(0));
        let grant = Grant {
            head: CommandHead { id: CommandId(lease), valid_until: SiteMillis(10_000) },
            lease: name(lease, robot),
            tag: TagId([7; 12]),
            expiry: EXPIRY,
            energy: EnergyJ::MIN,
        };
        let place = Place { site_now: Some(SiteMillis(0)), faulted: false, occupied: false };
        leases.grant(&grant, DurationMs(10_000), place).unwrap();
        leases
    }

    fn charging(lease: u32, robot: u16) -> Leases {
        let mut leases = granted(lease, robot);
        leases.begin_charge();
        leases
    }

    fn sight(leases: &Leases) -> Sight<'_> {
        Sight {
            pile: PILE,
            lease: leases.current(),
            ended: leases.ended(),
            limit_a: 0.0,
            docked: None,
            site_now: Some(SiteMillis(0)),
            booked: None,
            connected: true,
        }
    }

    #[test]
    fn an_orderly_charge_keeps_every_promise() {
        let mut watch = PileWatch::default();
        let mut leases = charging(1, 7);
        let live = Sight { limit_a: 10.0, docked: Some(RobotId(7)), ..sight(&leases) };
        assert_eq!(watch.look(Millis(0), &live), None);
        leases.end(EndReason::Completed);
        // The current goes along its ramp.
        assert_eq!(watch.look(Millis(100), &Sight { limit_a: 1.0, ..sight(&leases) }), None);
        assert_eq!(watch.look(Millis(1_000), &sight(&leases)), None);
    }

    #[test]
    fn energy_for_a_stranger_or_for_nobody_is_found() {
        let leases = charging(1, 7);
        let live = Sight { limit_a: 10.0, docked: Some(RobotId(8)), ..sight(&leases) };
        let stranger = Breach::DoubleGrant(Violation::WrongRobot { pile: PILE, robot: RobotId(8) });
        assert_eq!(PileWatch::default().look(Millis(0), &live), Some(stranger));
        let nobody = Leases::new(Epoch(0));
        let live = Sight { limit_a: 10.0, ..sight(&nobody) };
        assert_eq!(PileWatch::default().look(Millis(10_000), &live), Some(Breach::Unleased { pile: PILE }));
    }

    #[test]
    fn a_lease_that_replaces_another_is_found_and_one_after_a_restart_is_none() {
        let (one, other) = (granted(1, 7), granted(2, 8));
        let mut watch = PileWatch::default();
        assert_eq!(watch.look(Millis(0), &sight(&one)), None);
        let mut restarted = watch.clone();
        let replaced = Breach::DoubleGrant(Violation::Replaced { pile: PILE, lease: LeaseId(1) });
        assert_eq!(watch.look(Millis(1), &sight(&other)), Some(replaced));
        restarted.restarted();
        assert_eq!(restarted.look(Millis(1), &sight(&other)), None);
    }

    #[test]
    fn a_lease_of_a_piles_own_that_a_coordinator_never_learns_of_is_found() {
        let mut leases = Leases::new(Epoch(0));
        let claim = ClaimPile {
            request: RequestId(1),
            pile: PILE,
            boot: BootEpoch(1),
            version: 1,
            tag: TagId([7; 12]),
            energy: EnergyJ::MIN,
            within: DurationMs(600_000),
        };
        let place = Place { site_now: Some(SiteMillis(0)), faulted: false, occupied: false };
        leases.claim(LeaseId::local(1), RobotId(7), &claim, DurationMs(10_000), place).unwrap();
        let found = |connected, booked: Option<&state::Lease>| {
            let mut watch = PileWatch::default();
            let sight = Sight { connected, booked, ..sight(&leases) };
            assert_eq!(watch.look(Millis(0), &sight), None, "news travel");
            watch.look(Millis(61_000), &sight)
        };
        let lease = LeaseId::local(1);
        assert_eq!(found(true, None), Some(Breach::Unreconciled { pile: PILE, lease }));
        assert_eq!(found(false, None), None);
        let mut booked = state::Lease {
            name: leases.current().unwrap().name,
            energy: EnergyJ::MIN,
            granted_at: SiteMillis(0),
            expiry: EXPIRY,
            phase: Phase::Held { until: EXPIRY },
            command: None,
        };
        assert_eq!(found(true, Some(&booked)), None);
        booked.name = name(3, 8);
        assert_eq!(found(false, Some(&booked)), None, "the coordinator can't know");
        assert!(found(true, Some(&booked)).is_some());
    }

    #[test]
    fn a_reservation_beyond_its_expiry_is_found() {
        let leases = granted(1, 7);
        let look = |site_now| {
            let sight = Sight { site_now: Some(SiteMillis(site_now)), ..sight(&leases) };
            PileWatch::default().look(Millis(0), &sight)
        };
        assert_eq!(look(EXPIRY.0 + 1_000), None, "an idle pile looks every second");
        let late = Breach::HeldTooLong { pile: PILE, lease: LeaseId(1) };
        assert_eq!(look(EXPIRY.0 + 5_000), Some(late));
    }

    #[test]
    fn a_charge_that_goes_on_though_the_coordinator_did_not_extend_it_is_found() {
        let leases = charging(1, 7);
        let mut watch = PileWatch::default();
        let mut look = |now, heard: bool| {
            let site_now = Some(SiteMillis(now));
            if heard {
                watch.hears(Millis(now), site_now);
            }
            watch.look(Millis(now), &Sight { site_now, ..sight(&leases) })
        };
        assert_eq!(look(0, true), None);
        assert_eq!(look(200_000, false), None, "the coordinator is lost");
        assert_eq!(look(201_000, true), None);
        assert_eq!(look(205_000, true), None, "it has a grace to extend the lease");
        let late = Breach::HeldTooLong { pile: PILE, lease: LeaseId(1) };
        assert_eq!(look(209_000, false), Some(late));
    }

    #[test]
    fn a_charge_beyond_its_plan_is_found() {
        let mut leases = charging(1, 7);
        leases.charge_mut().unwrap().advance(DurationMs(13_000));
        let late = Breach::HeldTooLong { pile: PILE, lease: LeaseId(1) };
        assert_eq!(PileWatch::default().look(Millis(0), &sight(&leases)), Some(late));
    }

    #[test]
    fn a_coordinator_that_takes_a_held_pile_for_anothers_is_found_unless_news_are_only_late() {
        let leases = granted(1, 7);
        let book = |robot, phase| state::Lease {
            name: name(2, robot),
            energy: EnergyJ::MIN,
            granted_at: SiteMillis(0),
            expiry: EXPIRY,
            phase,
            command: None,
        };
        let held = Phase::Held { until: EXPIRY };
        let judge = |booked: state::Lease, times: [u64; 2]| {
            let mut watch = PileWatch::default();
            let mut look = |now| watch.look(Millis(now), &Sight { booked: Some(&booked), ..sight(&leases) });
            assert_eq!(look(times[0]), None);
            look(times[1])
        };
        let disputed = Violation::Disputed { pile: PILE, holder: RobotId(7), granted: RobotId(8) };
        let disputed = Breach::DoubleGrant(disputed);
        assert_eq!(judge(book(8, held), [0, 20_000]), Some(disputed));
        assert_eq!(judge(book(8, held), [0, 9_000]), None, "news travel");
        assert_eq!(judge(book(7, held), [0, 20_000]), None, "the same robot");
        let revoking = Phase::Revoking { why: RevokeReason::Unknown };
        assert_eq!(judge(book(8, revoking), [0, 20_000]), None, "it is being taken back");
    }
}
