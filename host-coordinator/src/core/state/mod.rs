//! What the coordinator knows for sure: the fold of the event log.
//!
//! [`State`] changes only by [`State::apply`], so folding the same events always gives the same
//! state. A pile has room for one [`Lease`]: a second holder cannot even be written down.

mod apply;
mod records;

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use protocol::{BootEpoch, CommandId, Epoch, LeaseId, PileId, RequestId, RobotId, SiteMillis, TaskId};

pub use records::{
    Charge, Contradicted, Help, HelpStage, Lease, Phase, PileRecord, Place, Request, Sortie, Totals,
};

use super::{
    decision::Decision,
    event::{Device, Event},
    profile::TaskProfile,
};

/// Decisions that are kept for the dashboard; the log has all of them.
pub const KEPT_DECISIONS: usize = 50;

/// Charges that are kept for the dashboard; the log has all of them.
pub const KEPT_CHARGES: usize = 50;

/// All durable state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// The reign of this coordinator; 0 before the first.
    pub epoch: Epoch,
    /// The start it is in.
    pub boot: BootEpoch,
    /// The number of the next lease.
    pub next_lease: LeaseId,
    /// The number of the next command.
    pub next_command: CommandId,
    /// The number of the next decision.
    pub next_decision: u64,
    /// How many requests were opened for robots that had not asked.
    pub calls: u32,
    /// What was promised to whom, for every pile that was ever spoken of.
    pub piles: BTreeMap<PileId, PileRecord>,
    /// The open requests, at most one a robot.
    pub requests: BTreeMap<RobotId, Request>,
    /// How often a robot passed a pile in a period of the day (LMPP eq. 4).
    pub passes: BTreeMap<(RobotId, u16), BTreeMap<PileId, u64>>,
    /// What the tasks of each robot take (Access Table 1, eqs. 1, 2).
    pub profiles: BTreeMap<RobotId, BTreeMap<TaskId, TaskProfile>>,
    /// The newest decisions, newest first.
    pub decisions: VecDeque<Decision>,
    /// The newest charges, newest first.
    pub charges: VecDeque<Charge>,
    /// Who was not heard for too long.
    pub silent: BTreeSet<Device>,
    /// When the last event happened.
    pub last_at: SiteMillis,
    /// Robots that cannot move.
    pub stranded: BTreeSet<RobotId>,
    /// Robots that wait for help.
    pub helps: BTreeMap<RobotId, Help>,
    /// Sums for the operator.
    pub totals: Totals,
}

impl State {
    /// The state after these events.
    #[must_use]
    pub fn fold<'a>(events: impl IntoIterator<Item = &'a Event>) -> Self {
        let mut state = Self::default();
        events.into_iter().for_each(|event| state.apply(event));
        state
    }

    /// The lease that is or may be alive on a pile.
    #[must_use]
    pub fn lease(&self, pile: PileId) -> Option<&Lease> {
        self.piles.get(&pile)?.lease.as_ref()
    }

    /// The number of the next request that is opened for a robot that has not asked.
    #[must_use]
    pub const fn next_call(&self) -> RequestId {
        RequestId(RequestId::FIRST_CALL.0.saturating_add(self.calls))
    }

    /// Who is promised the pile next.
    #[must_use]
    pub fn next(&self, pile: PileId) -> Option<RobotId> {
        self.piles.get(&pile)?.next
    }

    /// The share of `robot`'s passes in a period that were at `pile` (LMPP p, eq. 5).
    #[must_use]
    pub fn pass_frequency(&self, robot: RobotId, period: u16, pile: PileId) -> f64 {
        let Some(counts) = self.passes.get(&(robot, period)) else { return 0.0 };
        let passes = counts.get(&pile).copied().unwrap_or(0);
        crate::selection::activity::frequency(passes, counts.values().sum())
    }

    /// Near which piles `robot` is wanted in a period, and how often (LMPP's K).
    pub fn wanted_at(&self, robot: RobotId, period: u16) -> impl Iterator<Item = (PileId, f64)> {
        let counts = self.passes.get(&(robot, period));
        counts.into_iter().flatten().map(|(pile, passes)| (*pile, *passes as f64))
    }
}
