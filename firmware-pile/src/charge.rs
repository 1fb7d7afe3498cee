//! How long a charge takes and how much of it is left (LMPP eqs. 1 and 2).
//!
//! A pile allots time and counts the time for which its contacts were live. What it delivers in
//! that time it measures, and only tells.

use protocol::{DurationMs, EnergyJ, Fraction};

/// The planned time of a charge, t_plan (LMPP eq. 2): what the robots' batteries lack, divided by
/// the pile's power (g_pertime), plus the adjustment `eta`.
///
/// `needs` are the robot on the pile and those granted it next. A pile whose power is not positive
/// charges for no time; a result beyond [`DurationMs::MAX`] becomes that.
#[must_use]
pub fn planned_time(needs: impl IntoIterator<Item = EnergyJ>, power_w: f32, eta: DurationMs) -> DurationMs {
    if power_w.is_nan() || power_w <= 0.0 {
        return DurationMs(0);
    }
    let energy_j: f32 = needs.into_iter().map(EnergyJ::get).sum();
    let charge = DurationMs::from_seconds(energy_j / power_w);
    DurationMs::saturating(u64::from(charge.0) + u64::from(eta.0))
}

/// The share of the planned time still ahead, q (LMPP eq. 1): 1 at the start, 0 at the end, after
/// the end, and when nothing was planned.
#[must_use]
pub fn remaining(planned: DurationMs, elapsed: DurationMs) -> Fraction {
    match planned.0.checked_sub(elapsed.0) {
        Some(ahead) if planned.0 > 0 => Fraction::clamped(ahead as f32 / planned.0 as f32),
        _ => Fraction::MIN,
    }
}

/// A charge under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Charge {
    planned: DurationMs,
    elapsed: DurationMs,
    /// In millijoules: many small parts of a large sum.
    delivered_mj: u64,
}

impl Charge {
    /// A charge that begins now.
    #[must_use]
    pub const fn new(planned: DurationMs) -> Self {
        Self { planned, elapsed: DurationMs(0), delivered_mj: 0 }
    }

    /// The contacts were live for `time` more.
    pub fn advance(&mut self, time: DurationMs) {
        self.elapsed = DurationMs::saturating(u64::from(self.elapsed.0) + u64::from(time.0));
    }

    /// So much more energy went into the robot, in joules; what is no energy counts for none.
    pub fn deliver(&mut self, energy_j: f32) {
        // The cast takes NaN and what is negative for 0, and the largest number for what is larger.
        let energy_mj = (energy_j * 1_000.0 + 0.5) as u64;
        self.delivered_mj = self.delivered_mj.saturating_add(energy_mj);
    }

    /// The energy that went into the robot: the integral of voltage times current.
    #[must_use]
    pub fn delivered(&self) -> EnergyJ {
        EnergyJ::clamped(self.delivered_mj as f32 / 1_000.0)
    }

    /// t_plan.
    #[must_use]
    pub const fn planned(&self) -> DurationMs {
        self.planned
    }

    /// t_fulfil: how long the contacts were live.
    #[must_use]
    pub const fn elapsed(&self) -> DurationMs {
        self.elapsed
    }

    /// q, see [`remaining`].
    #[must_use]
    pub fn remaining(&self) -> Fraction {
        remaining(self.planned, self.elapsed)
    }

    /// Whether the planned time was given.
    #[must_use]
    pub const fn is_complete(&self) -> bool {
        self.elapsed.0 >= self.planned.0
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn energy(joules: f32) -> EnergyJ {
        EnergyJ::new(joules).unwrap()
    }

    #[test]
    fn the_planned_time_sums_over_robots_and_adds_eta() {
        let needs = [energy(1_000.0), energy(500.0)];
        assert_eq!(planned_time(needs, 50.0, DurationMs(4_000)), DurationMs(34_000));
        assert_eq!(planned_time([], 50.0, DurationMs(4_000)), DurationMs(4_000));
    }

    #[test]
    fn a_pile_without_power_charges_for_no_time() {
        for power_w in [0.0, -1.0, f32::NAN, f32::NEG_INFINITY] {
            assert_eq!(planned_time([energy(1_000.0)], power_w, DurationMs(4_000)), DurationMs(0));
        }
    }

    #[test]
    fn the_remaining_share_falls_from_one_to_nothing() {
        let planned = DurationMs(8_000);
        let shares = [0, 2_000, 4_000, 8_000, 9_000].map(|ms| remaining(planned, DurationMs(ms)).get());
        assert_eq!(shares, [1.0, 0.75, 0.5, 0.0, 0.0]);
        assert_eq!(remaining(DurationMs(0), DurationMs(0)), Fraction::MIN);
    }

    #[test]
    fn small_parts_of_a_large_delivery_are_not_lost() {
        let mut charge = Charge::new(DurationMs(0));
        charge.deliver(1.0e6);
        (0..1_000).for_each(|_| charge.deliver(0.001));
        [f32::NAN, -5.0, f32::NEG_INFINITY].into_iter().for_each(|nonsense| charge.deliver(nonsense));
        assert_eq!(charge.delivered(), energy(1.0e6 + 1.0));
    }

    proptest! {
        #[test]
        fn the_remaining_share_never_rises(planned: u32, elapsed: u32, more: u32) {
            let later = DurationMs(elapsed.saturating_add(more));
            prop_assert!(remaining(DurationMs(planned), later) <= remaining(DurationMs(planned), DurationMs(elapsed)));
        }

        #[test]
        fn more_energy_never_takes_less_time(joules in 0.0f32..1.0e9, more in 0.0f32..1.0e9, power_w: f32) {
            let time = |joules| planned_time([EnergyJ::clamped(joules)], power_w, DurationMs(100));
            prop_assert!(time(joules) <= time(joules + more));
            prop_assert!(time(joules + more) <= DurationMs::MAX);
        }
    }
}
