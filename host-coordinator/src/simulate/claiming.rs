//! What a robot does while it hears piles and no coordinator: it claims one for itself.
//!
//! It listens to what the piles gossip, chooses by LMPP's rule ([`choose_alone`]), and asks that pile until it is
//! answered. One pile at a time: another is asked only after this one has refused, or has not answered for five
//! seconds.

use std::collections::BTreeMap;

use protocol::{
    ClaimPile, ClaimRef, DurationMs, EnergyJ, Millis, PileId, PileRow, PileTable, RequestId, RobotId, limits,
};

use super::{ground::Point, navigator::Navigator, world::Build};
use crate::selection::{Known, choose_alone};

/// A row that was heard longer ago says nothing any more.
const FRESH: DurationMs = DurationMs(15_000);
/// How long a pile is asked that does not answer.
const PATIENCE: DurationMs = DurationMs(5_000);
/// How long a pile is left alone that has refused, or has not answered.
const LEFT_ALONE: DurationMs = DurationMs(20_000);
/// What a robot takes longer than its way, at most: it may be stopped at crowded doors.
const DELAY: DurationMs = DurationMs(90_000);

/// A metre may take so much more than the robot believes: it claims no pile that it might not get to.
const AT_MOST: f64 = 1.3;

/// A robot's claims.
#[derive(Debug)]
pub struct Claiming {
    robot: RobotId,
    believed: Build,
    /// The newest row of each pile, and when it was heard.
    rows: BTreeMap<PileId, (PileRow, Millis)>,
    /// When the coordinator was last heard, or the robot began to wait for it.
    waits_since: Millis,
    asked: Option<Asked>,
    refused: BTreeMap<PileId, Millis>,
}

#[derive(Clone, Copy, Debug)]
struct Asked {
    pile: PileId,
    since: Millis,
    repeated_at: Millis,
}

impl Claiming {
    /// Those of a robot that takes itself to be built as `believed`.
    #[must_use]
    pub const fn new(robot: RobotId, believed: Build) -> Self {
        Self {
            robot,
            believed,
            rows: BTreeMap::new(),
            waits_since: Millis(0),
            asked: None,
            refused: BTreeMap::new(),
        }
    }

    /// The coordinator was heard, or the robot begins to wait for an answer of it.
    pub const fn coordinator_heard(&mut self, now: Millis) {
        self.waits_since = now;
        self.asked = None;
    }

    /// Piles gossip.
    pub fn hear(&mut self, now: Millis, table: &PileTable) {
        let age = |row: &PileRow| (row.boot, row.version);
        for row in &table.rows {
            if self.rows.get(&row.pile).is_none_or(|(known, _)| age(row) > age(known)) {
                self.rows.insert(row.pile, (*row, now));
            }
        }
    }

    /// A pile has answered a claim. Which pile is the robot's now, if one is.
    pub fn answered(
        &mut self,
        now: Millis,
        of: ClaimRef,
        request: RequestId,
        granted: bool,
    ) -> Option<PileId> {
        if of != (ClaimRef { robot: self.robot, request }) {
            return None;
        }
        let Asked { pile, .. } = self.asked.take()?;
        if !granted {
            self.refused.insert(pile, now);
        }
        granted.then_some(pile)
    }

    /// What to say to the piles now for a robot that waits with `request`.
    pub fn claim(
        &mut self,
        now: Millis,
        request: RequestId,
        (position, energy_j): (Point, f64),
        navigator: &Navigator,
    ) -> Option<ClaimPile> {
        if now.since(self.waits_since) < limits::COORDINATOR_LOST {
            return None;
        }
        if let Some(asked) = self.asked.filter(|asked| now.since(asked.since) >= PATIENCE) {
            self.refused.insert(asked.pile, now);
            self.asked = None;
        }
        if self.asked.is_some_and(|asked| now.since(asked.repeated_at) < limits::REPEAT_INTERVAL) {
            return None;
        }
        self.refused.retain(|_, at| now.since(*at) < LEFT_ALONE);
        let ways = navigator.ways_to_piles(position);
        let asked = match self.asked {
            Some(asked) => Asked { repeated_at: now, ..asked },
            None => {
                let pile = self.choose(now, energy_j, &ways, navigator.metres_per_cell())?;
                Asked { pile, since: now, repeated_at: now }
            }
        };
        self.asked = Some(asked);
        let (row, _) = self.rows.get(&asked.pile)?;
        let way_m = ways.get(&asked.pile)? * navigator.metres_per_cell();
        let arrives_j = energy_j - way_m * self.per_metre_j();
        Some(ClaimPile {
            request,
            pile: asked.pile,
            boot: row.boot,
            version: row.version,
            tag: self.believed.tag,
            energy: EnergyJ::clamped((self.believed.full_j - arrives_j) as f32),
            within: DurationMs::saturating(
                (way_m / self.believed.speed_mps * 1e3) as u64 + u64::from(DELAY.0),
            ),
        })
    }

    fn choose(
        &self,
        now: Millis,
        energy_j: f64,
        ways: &BTreeMap<PileId, f64>,
        cell_m: f64,
    ) -> Option<PileId> {
        let fresh = self
            .rows
            .values()
            .filter(|(row, heard)| now.since(*heard) < FRESH && !self.refused.contains_key(&row.pile));
        let known: Vec<_> =
            fresh.map(|(row, _)| Known { row: *row, distance: ways.get(&row.pile).copied() }).collect();
        choose_alone(&known, energy_j / (AT_MOST * self.per_metre_j()) / cell_m)
    }

    fn per_metre_j(&self) -> f64 {
        self.believed.drive_j_per_m + self.believed.idle_w / self.believed.speed_mps
    }
}
