//! The one place that says whether the contacts may be live.

use protocol::Millis;

use crate::{clock::SiteClock, faults::Faults, lease::Lease, presence::Presence};

/// Whether the contacts may be live now. They may if, and only if, all of this holds:
///
/// 1. the site's time is known, so that the lease's expiry means something,
/// 2. a lease is held and has not run out ([`Lease::has_run_out`] says what that is under a
///    charge whose coordinator is lost),
/// 3. its charge has begun and is not complete,
/// 4. its robot's tag stands at the contacts,
/// 5. the pile has no fault.
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
