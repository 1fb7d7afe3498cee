//! The one place that says whether the contacts may be live.

use firmware_common::{clock::SiteClock, presence::Presence};
use protocol::Millis;

use super::{OPENING_AT_ONCE, Permit, Safety};
use crate::{faults::Faults, lease::Lease};

/// How much the contacts may give now: something if, and only if, all of this holds:
///
/// 1. the site's time is known, so that the lease's expiry means something,
/// 2. a lease is held and has not run out ([`Lease::has_run_out`] says what that is under a
///    charge whose coordinator is lost),
/// 3. its charge has begun and is not complete,
/// 4. its robot's tag stands at the contacts,
/// 5. the pile has no fault, not even one that is over and was not cleared: among them are the
///    emergency stop, lost mains, and every excess of current, voltage and temperature,
/// 6. the sensors were read just now, and each can be believed,
/// 7. a robot's contacts touch the pile's,
/// 8. with the right poles, and the voltage of a battery this pile is for,
/// 9. the contacts are cool enough for some current.
///
/// A charge begins only while its robot's tag is the only one at the contacts, so that it is the
/// robot on them that is charged and not one beside it; who comes near later changes nothing.
///
/// No message closes the contactor: the coordinator can forbid, never force.
#[must_use]
pub fn permit<const N: usize>(
    now: Millis,
    clock: &SiteClock,
    lease: Option<&Lease>,
    presence: &Presence<N>,
    faults: &Faults,
    safety: &Safety,
) -> Permit {
    if !faults.active().intersection(OPENING_AT_ONCE).is_empty() {
        return Permit::OpenNow;
    }
    let (Some(site_now), Some(lease)) = (clock.site_now(now), lease) else { return Permit::Nothing };
    let is_granted = !lease.has_run_out(now, site_now)
        && lease.charge.is_some_and(|charge| !charge.is_complete())
        && presence.contains(now, lease.tag);
    match current_a(now, safety) {
        Some(current_a) if is_granted && faults.standing().is_empty() => Permit::UpTo(current_a),
        _ => Permit::Nothing,
    }
}

/// What the sensors allow, in amperes: more than 0.
fn current_a(now: Millis, safety: &Safety) -> Option<f32> {
    let sample = safety.sample(now)?;
    // That the current is believed matters as much as its value, which is a fault if it is wrong.
    sample.readings.current_a?;
    let (voltage_v, contact_c) = (sample.readings.voltage_v?, sample.readings.contact_c?);
    let is_battery = (safety.limits.voltage_min_v()..=safety.limits.voltage_max_v).contains(&voltage_v);
    let current_a = safety.limits.current_a(safety.power_w, voltage_v, contact_c);
    (sample.sensors.mated && is_battery && current_a > 0.0).then_some(current_a)
}

#[cfg(test)]
mod tests {
    use firmware_common::presence::RssiBand;
    use protocol::{
        CommandHead, CommandId, DurationMs, EnergyJ, Epoch, Grant, LeaseId, LeaseRef, RobotId, SiteMillis,
        TagId, TimeSync,
    };

    use super::*;
    use crate::{
        faults::FaultSet,
        lease::{Leases, Place},
        safety::{Limits, Sensors},
    };

    const NOW: Millis = Millis(1_000);
    const TAG: TagId = TagId([7; 12]);

    /// A pile in the middle of a charge of ten seconds under a lease of a minute.
    struct Scene {
        clock: SiteClock,
        leases: Leases,
        presence: Presence<1>,
        faults: Faults,
        safety: Safety,
        sensors: Sensors,
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
                faults: Faults::new(FaultSet::EMPTY),
                safety: Safety::new(Limits::new(500.0), 500.0),
                sensors: Sensors {
                    output_v: 25.0,
                    output_a: 0.0,
                    contact_c: 30.0,
                    contactor_closed: false,
                    mated: true,
                    emergency_stop: false,
                    mains: true,
                },
            };
            scene.presence.read(NOW, TAG, -50);
            scene
        }

        /// What is permitted after a sample that the sensors took at `now`.
        fn permit(&mut self, now: Millis) -> Permit {
            self.safety.sense(now, self.sensors, &mut self.faults);
            self.permit_unsensed(now)
        }

        fn permit_unsensed(&self, now: Millis) -> Permit {
            permit(now, &self.clock, self.leases.current(), &self.presence, &self.faults, &self.safety)
        }

        fn sensing(change: impl FnOnce(&mut Sensors)) -> Permit {
            let mut scene = Self::new();
            change(&mut scene.sensors);
            scene.permit(NOW)
        }
    }

    #[test]
    fn the_power_of_the_pile_is_permitted_when_everything_is_well() {
        assert_eq!(Scene::new().permit(NOW), Permit::UpTo(20.0));
    }

    #[test]
    fn not_without_a_clock() {
        assert_eq!(Scene { clock: SiteClock::new(), ..Scene::new() }.permit(NOW), Permit::Nothing);
    }

    #[test]
    fn not_without_a_lease_nor_under_one_that_has_run_out() {
        assert_eq!(Scene { leases: Leases::new(Epoch(0)), ..Scene::new() }.permit(NOW), Permit::Nothing);
        let mut scene = Scene::new();
        let (expired, over) = (Millis(NOW.0 + 60_000), Millis(NOW.0 + 65_000));
        scene.presence.read(over, TAG, -50);
        assert_ne!(scene.permit(over), Permit::Nothing, "the coordinator is lost");
        scene.leases.coordinator_heard(expired, scene.clock.site_now(expired));
        assert_eq!(scene.permit(over), Permit::Nothing, "the coordinator does not extend");
    }

    #[test]
    fn not_before_the_charge_has_begun_nor_after_its_end() {
        let mut scene = Scene::new();
        scene.leases.charge_mut().expect("a charge").advance(DurationMs(9_999));
        assert_ne!(scene.permit(NOW), Permit::Nothing);
        let mut waiting = *scene.leases.current().expect("a lease");
        waiting.charge = None;
        let Scene { clock, presence, faults, safety, .. } = &scene;
        assert_eq!(permit(NOW, clock, Some(&waiting), presence, faults, safety), Permit::Nothing);
        scene.leases.charge_mut().expect("a charge").advance(DurationMs(1));
        assert_eq!(scene.permit(NOW), Permit::Nothing);
    }

    #[test]
    fn not_for_another_tag_nor_long_after_the_read() {
        let mut scene = Scene::new();
        assert_ne!(scene.permit(Millis(NOW.0 + 1_999)), Permit::Nothing);
        assert_eq!(scene.permit(Millis(NOW.0 + 2_000)), Permit::Nothing);
        scene.presence.read(Millis(NOW.0 + 2_000), TagId([8; 12]), -50);
        assert_eq!(scene.permit(Millis(NOW.0 + 2_000)), Permit::Nothing);
    }

    #[test]
    fn not_with_a_fault_even_if_it_is_only_latched() {
        let latched = FaultSet::of(&[protocol::FaultCode::ContactorStuckOpen]);
        assert_eq!(Scene { faults: Faults::new(latched), ..Scene::new() }.permit(NOW), Permit::Nothing);
    }

    #[test]
    fn not_without_a_fresh_sample() {
        let mut scene = Scene::new();
        assert_eq!(scene.permit_unsensed(NOW), Permit::Nothing);
        scene.permit(NOW);
        assert_eq!(scene.permit_unsensed(Millis(NOW.0 + 249)), Permit::UpTo(20.0));
        assert_eq!(scene.permit_unsensed(Millis(NOW.0 + 250)), Permit::Nothing);
    }

    #[test]
    fn not_if_nothing_touches_the_contacts() {
        assert_eq!(Scene::sensing(|sensors| sensors.mated = false), Permit::Nothing);
    }

    #[test]
    fn not_without_mains() {
        assert_eq!(Scene::sensing(|sensors| sensors.mains = false), Permit::Nothing);
    }

    #[test]
    fn not_without_a_battery_of_the_right_poles_and_voltage() {
        for output_v in [-25.0, 0.0, 14.9, 30.1] {
            assert_eq!(
                Scene::sensing(|sensors| sensors.output_v = output_v),
                Permit::Nothing,
                "{output_v} V"
            );
        }
    }

    #[test]
    fn less_when_the_contacts_are_warm_and_nothing_when_they_are_hot() {
        assert_eq!(Scene::sensing(|sensors| sensors.contact_c = 70.0), Permit::UpTo(10.0));
        assert_eq!(Scene::sensing(|sensors| sensors.contact_c = 80.0), Permit::Nothing);
    }

    #[test]
    fn not_with_a_sensor_that_cannot_be_believed() {
        for nonsense in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert_eq!(Scene::sensing(|sensors| sensors.output_v = nonsense), Permit::Nothing);
            assert_eq!(Scene::sensing(|sensors| sensors.contact_c = nonsense), Permit::Nothing);
        }
        assert_eq!(Scene::sensing(|sensors| sensors.output_a = f32::NAN), Permit::Nothing);
    }

    #[test]
    fn the_contactor_opens_at_once_on_emergency_stop_and_over_current() {
        assert_eq!(Scene::sensing(|sensors| sensors.emergency_stop = true), Permit::OpenNow);
        for output_a in [27.6, -27.6, f32::INFINITY] {
            assert_eq!(
                Scene::sensing(|sensors| sensors.output_a = output_a),
                Permit::OpenNow,
                "{output_a} A"
            );
        }
    }
}
