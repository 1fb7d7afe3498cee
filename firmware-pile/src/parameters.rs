//! What differs from pile to pile.

use firmware_common::{
    passes::{self, PassRule},
    presence::RssiBand,
};
use protocol::{BootEpoch, DurationMs, Epoch, PileId};

use crate::{faults::FaultSet, safety::Limits};

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
}
