//! What changed between two views: only the rows that differ.

use serde::Serialize;

use crate::core::{
    Decision, View,
    view::{ChargeView, DoorView, HelpView, PileView, RobotView, TotalsView},
};

/// The difference of two views.
#[derive(Debug, PartialEq, Serialize)]
pub struct Change<'a> {
    now_ms: u64,
    epoch: u32,
    degraded: Option<&'a str>,
    warnings: &'a [String],
    piles: Vec<&'a PileView>,
    robots: Vec<&'a RobotView>,
    doors: Vec<&'a DoorView>,
    helps: &'a [HelpView],
    decisions: Vec<&'a Decision>,
    charges: Vec<&'a ChargeView>,
    totals: &'a TotalsView,
}

impl<'a> Change<'a> {
    /// What a reader who knows `before` has to be told of `after`. Both are views of the same
    /// site, so their rows are in the same order.
    #[must_use]
    pub fn between(before: &View, after: &'a View) -> Self {
        let newest = before.decisions.first().map(|decision| decision.id);
        let last = before.charges.first().map(|charge| charge.id);
        Self {
            now_ms: after.now_ms,
            epoch: after.epoch,
            degraded: after.degraded.as_deref(),
            warnings: &after.warnings,
            piles: changed(&before.piles, &after.piles),
            robots: changed(&before.robots, &after.robots),
            doors: changed(&before.site.doors, &after.site.doors),
            helps: &after.helps,
            decisions: after.decisions.iter().take_while(|decision| Some(decision.id) > newest).collect(),
            charges: after.charges.iter().take_while(|charge| Some(charge.id) > last).collect(),
            totals: &after.totals,
        }
    }
}

fn changed<'a, T: PartialEq>(before: &[T], after: &'a [T]) -> Vec<&'a T> {
    after.iter().enumerate().filter(|(at, row)| before.get(*at) != Some(row)).map(|(_, row)| row).collect()
}
