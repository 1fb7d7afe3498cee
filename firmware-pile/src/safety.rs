//! The one place that says whether the contacts may be live.

use firmware_common::{clock::SiteClock, presence::Presence};
use protocol::Millis;

use crate::{faults::Faults, lease::Lease};

/// Whether the contacts may be live now. They may if, and only if, all of this holds:
///
/// 1. the site's time is known, so that the lease's expiry means something,
/// 2. a lease is held and has not run out ([`Lease::has_run_out`] says what that is under a
///    charge whose coordinator is lost),
/// 3. its charge has begun and is not complete,
/// 4. its robot's tag stands at the contacts,
/// 5. the pile has no fault.
///
/// A charge begins only while its robot's tag is the only one at the contacts, so that it is the
/// robot on them that is charged and not one beside it; who comes near later changes nothing.
///
/// No message closes the contactor: the coordinator can forbid, never force.
#[must_use]
pub fn may_energise<const N: usize>(
    now: Millis,
    clock: &SiteClock,
    lease: Option<&Lease>,
    presence: &Presence<N>,
    faults: &Faults,
) -> bool {
    let (Some(site_now), Some(lease)) = (clock.site_now(now), lease) else { return false };
    !lease.has_run_out(now, site_now)
        && lease.charge.is_some_and(|charge| !charge.is_complete())
        && presence.contains(now, lease.tag)
        && faults.active().is_empty()
}

#[cfg(test)]
mod tests {
    use firmware_common::presence::RssiBand;
    use protocol::{
        CommandHead, CommandId, DurationMs, EnergyJ, Epoch, Grant, LeaseId, LeaseRef, RobotId, SiteMillis,
        TagId, TimeSync,
    };

    use super::*;
    use crate::lease::{Leases, Place};

    const NOW: Millis = Millis(1_000);
    const TAG: TagId = TagId([7; 12]);

    /// A pile in the middle of a charge of ten seconds under a lease of a minute.
    struct Scene {
        clock: SiteClock,
        leases: Leases,
        presence: Presence<1>,
        faults: Faults,
    }

    impl Scene {
        fn new() -> Self {
            let mut clock = SiteClock::new();
            clock.request(NOW, false).expect("the clock is not known yet");
            clock.accept(NOW, &TimeSync { asked_at: NOW, site_now: SiteMillis(0) });
            let mut leases = Leases::new(Epoch(0));
            let grant = Grant {
                head: CommandHead { id: CommandId(1), valid_until: SiteMillis(100) },
                lease: LeaseRef { epoch: Epoch(1), lease: LeaseId(1), robot: RobotId(1) },
                tag: TAG,
                expiry: SiteMillis(60_000),
                energy: EnergyJ::MIN,
            };
            let place = Place { site_now: clock.site_now(NOW), faulted: false, occupied: false };
            leases.grant(&grant, DurationMs(10_000), place).expect("the pile is free");
            leases.begin_charge();
            let mut scene = Self {
                clock,
                leases,
                presence: Presence::new(RssiBand { enter_dbm: -60, leave_dbm: -66 }, DurationMs(2_000)),
                faults: Faults::new(),
            };
            scene.presence.read(NOW, TAG, -50);
            scene
        }

        fn may_energise(&self, now: Millis) -> bool {
            may_energise(now, &self.clock, self.leases.current(), &self.presence, &self.faults)
        }
    }

    #[test]
    fn the_contacts_may_be_live_when_everything_is_well() {
        assert!(Scene::new().may_energise(NOW));
    }

    #[test]
    fn not_without_a_clock() {
        assert!(!Scene { clock: SiteClock::new(), ..Scene::new() }.may_energise(NOW));
    }

    #[test]
    fn not_without_a_lease_nor_under_one_that_has_run_out() {
        assert!(!Scene { leases: Leases::new(Epoch(0)), ..Scene::new() }.may_energise(NOW));
        let mut scene = Scene::new();
        let (expired, over) = (Millis(NOW.0 + 60_000), Millis(NOW.0 + 65_000));
        scene.presence.read(over, TAG, -50);
        assert!(scene.may_energise(over), "the coordinator is lost");
        scene.leases.coordinator_heard(expired, scene.clock.site_now(expired));
        assert!(!scene.may_energise(over), "the coordinator does not extend");
    }

    #[test]
    fn not_before_the_charge_has_begun_nor_after_its_end() {
        let mut scene = Scene::new();
        scene.leases.charge_mut().expect("a charge").advance(DurationMs(9_999));
        assert!(scene.may_energise(NOW));
        scene.leases.charge_mut().expect("a charge").advance(DurationMs(1));
        assert!(!scene.may_energise(NOW));
        let mut waiting = *scene.leases.current().expect("a lease");
        waiting.charge = None;
        assert!(!may_energise(NOW, &scene.clock, Some(&waiting), &scene.presence, &scene.faults));
    }

    #[test]
    fn not_for_another_tag_nor_long_after_the_read() {
        let mut scene = Scene::new();
        assert!(scene.may_energise(Millis(NOW.0 + 1_999)));
        assert!(!scene.may_energise(Millis(NOW.0 + 2_000)));
        scene.presence.read(Millis(NOW.0 + 2_000), TagId([8; 12]), -50);
        assert!(!scene.may_energise(Millis(NOW.0 + 2_000)));
    }

    #[test]
    fn not_with_a_fault() {
        let mut scene = Scene::new();
        scene.faults.contactor_found(Millis(0), false, true);
        scene.faults.contactor_found(Millis(500), false, true);
        assert!(!scene.may_energise(NOW));
    }
}
