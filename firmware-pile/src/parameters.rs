//! What differs from pile to pile.

use firmware_common::{
    passes::{self, PassRule},
    presence::RssiBand,
};
use protocol::{BootEpoch, DurationMs, Epoch, PileId, PileParameters};

use crate::{
    faults::FaultSet,
    safety::Limits,
    store::{Counters, Identity, Kept},
};

/// What a pile is told at its start.
#[derive(Clone, Copy, Debug)]
pub struct Parameters {
    /// Which pile this is.
    pub pile: PileId,
    /// Which of its starts this is, from non-volatile memory.
    pub boot: BootEpoch,
    /// The highest epoch seen before this start, from non-volatile memory.
    pub highest_epoch: Epoch,
    /// The faults that were latched before this start, from non-volatile memory.
    pub latched: FaultSet,
    /// What the pile did before this start, from non-volatile memory.
    pub counters: Counters,
    /// What it was provisioned with, from non-volatile memory; a pile that is only modelled has none.
    pub identity: Option<Identity>,
    /// What the pile gives a robot, in watts (g_pertime of LMPP eq. 2).
    pub power_w: f32,
    /// What voltage, current and temperature allow, and what the sensors measure.
    pub limits: Limits,
    /// The adjustment of the planned time (eta of eq. 2).
    pub eta: DurationMs,
    /// The length of a period of the day (lambda of eq. 8).
    pub period: DurationMs,
    /// How many periods make a day.
    pub periods: u16,
    /// What counts as a pass (eq. 4).
    pub pass_rule: PassRule,
    /// The signal strengths at which a tag stands at the contacts and has left them.
    pub docked: RssiBand,
    /// A tag that was not read for this long has left the contacts.
    pub tag_timeout: DurationMs,
}

impl Parameters {
    /// Usual values for a pile in its first start: two-hour periods as in the paper's example, a
    /// reader whose field is about 3 m deep, robots with 24 V batteries.
    #[must_use]
    pub const fn new(pile: PileId, power_w: f32) -> Self {
        Self {
            pile,
            boot: BootEpoch(1),
            highest_epoch: Epoch(0),
            latched: FaultSet::EMPTY,
            counters: Counters::NONE,
            identity: None,
            power_w,
            limits: Limits::new(power_w),
            eta: DurationMs(5_000),
            period: DurationMs(7_200_000),
            periods: 12,
            pass_rule: PassRule::PerApproach {
                band: RssiBand { enter_dbm: -70, leave_dbm: -76 },
                dwell: passes::DWELL,
                gap: DurationMs(3_000),
            },
            docked: RssiBand { enter_dbm: -60, leave_dbm: -66 },
            tag_timeout: DurationMs(2_000),
        }
    }

    /// What non-volatile memory keeps of a pile that was provisioned as `identity`.
    #[must_use]
    pub fn kept(identity: Identity, kept: &Kept) -> Self {
        let PileParameters { power, eta, voltage_max, current_max, derate_from, stop_at, .. } =
            identity.parameters;
        let usual = Self::new(identity.pile, power.get());
        Self {
            boot: kept.boot,
            highest_epoch: kept.epoch,
            latched: kept.latched,
            counters: kept.counters,
            identity: Some(identity),
            limits: Limits {
                voltage_max_v: voltage_max.get(),
                current_max_a: current_max.get(),
                derate_from_c: derate_from.get(),
                stop_at_c: stop_at.get(),
                ..usual.limits
            },
            eta,
            docked: RssiBand {
                enter_dbm: identity.parameters.dock_enter_dbm,
                leave_dbm: identity.parameters.dock_leave_dbm,
            },
            ..usual
        }
    }
}
