//! The event log followed again: decisions are taken anew, by another policy or with other doors.
//!
//! A decision in the log tells all that its policy knew: where the robot was and what its battery held, and
//! what every pile could be used for. [`Replay`] folds the log up to each decision and lets a coordinator
//! choose again. Robots that waited beside it and were given nothing are known from the last decision for
//! them; they stand where they stood. Each decision is taken anew by itself: what would have followed from
//! another choice is in no log.
//!
//! [`Standing`] is what was known for sure at an instant.

mod standing;

use std::collections::BTreeMap;

use protocol::{Availability, RobotId};

pub use standing::Standing;

use super::{
    consumption::Consumption,
    coordinator::Coordinator,
    decision::{Decision, Explanation},
    event::{Event, Fact},
    situation::{RESERVE, Seat, Seen},
};
use crate::selection::{Asker, Situation, Verdict, priority};

/// A decision of the log, and what the coordinator of the replay decides from the same knowledge.
#[derive(Clone, Debug, PartialEq)]
pub struct Anew {
    /// As it is in the log.
    pub was: Decision,
    /// As it would be; none if the log does not tell enough of it, or the site or the fleet has changed.
    pub would_be: Option<Decision>,
}

/// Follows a log.
#[derive(Debug)]
pub struct Replay {
    coordinator: Coordinator,
    /// The last decision for each robot.
    latest: BTreeMap<RobotId, Decision>,
    /// Decisions of one instant so far.
    together: Vec<Decision>,
}

impl Replay {
    /// Decisions are taken anew as `coordinator` does it, which must have no past of its own.
    #[must_use]
    pub const fn new(coordinator: Coordinator) -> Self {
        Self { coordinator, latest: BTreeMap::new(), together: Vec::new() }
    }

    /// Goes on by one event; answers with the decisions of the instant before, if that is over.
    pub fn follow(&mut self, event: &Event) -> Vec<Anew> {
        let taken = match &event.fact {
            Fact::Decided(decision) if self.is_another_instant(decision) => self.finish(),
            // What the step does that decides.
            Fact::Decided(_) | Fact::Granted { .. } | Fact::NextReserved { .. } | Fact::Revoked { .. } => {
                Vec::new()
            }
            _ => self.finish(),
        };
        if let Fact::Decided(decision) = &event.fact {
            self.together.push(decision.clone());
        }
        self.coordinator.state.apply(event);
        taken
    }

    /// The decisions of the last instant.
    pub fn finish(&mut self) -> Vec<Anew> {
        let together = std::mem::take(&mut self.together);
        let situation = self.situation_anew(&together);
        let choices = self.coordinator.chooser.choose(&situation);
        let policy = self.coordinator.policy.choose;
        let anew = |was: Decision| {
            let choice = situation.askers.iter().zip(&choices).find(|(asker, _)| asker.robot == was.robot);
            let would_be = choice.map(|(asker, choice)| {
                Decision::new(was.id, was.at_ms, was.request, policy, &situation, asker, choice)
            });
            Anew { was, would_be }
        };
        let taken: Vec<_> = together.into_iter().map(anew).collect();
        self.latest.extend(taken.iter().map(|anew| (anew.was.robot, anew.was.clone())));
        taken
    }

    fn is_another_instant(&self, decision: &Decision) -> bool {
        self.together.first().is_some_and(|first| first.at_ms != decision.at_ms)
            || self.together.iter().any(|other| other.robot == decision.robot)
    }

    /// What was known when `together` was decided, in the order in which the step knew it.
    fn situation_anew(&self, together: &[Decision]) -> Situation {
        let Some(first) = together.first() else { return Situation::default() };
        let decided = together.iter().filter_map(|decision| self.coordinator.asker_anew(decision, decision));
        let beside = first.beside.iter().filter_map(|robot| {
            let last = self.latest.get(robot)?;
            let request = self.coordinator.state.requests.get(robot)?;
            let asker = self.coordinator.asker_anew(last, first)?;
            let share = self.coordinator.share(&asker)?;
            Some(Asker { urgency: priority::urgency(share, request.priority, asker.waited_s), ..asker })
        });
        // Who was decided for counts as that, should the log name it beside another too.
        let askers: BTreeMap<_, _> = beside.chain(decided).map(|asker| (asker.robot, asker)).collect();
        Situation { askers: askers.into_values().collect() }
    }
}

impl Coordinator {
    /// The robot of a decision as it was known then or, having waited on, when `known` was decided, with the
    /// ways of this coordinator to piles that were as `known` tells.
    fn asker_anew(&self, decision: &Decision, known: &Decision) -> Option<Asker> {
        let now = known.at_ms;
        let Decision { robot, energy_j: energy, reach, .. } = *decision;
        let config = self.robots.get(&robot)?;
        let position = decision.position?;
        let cell = self.site.cell_of(position).filter(|cell| self.site.grid.is_free(*cell))?;
        // Eq. 6 the other way round.
        let per_metre_j = |energy_j: f64, reach: f64| {
            let taken_j = energy_j / (reach * self.site.resolution_m);
            if reach > 0.0 { taken_j } else { config.energy_per_metre_j.into() }
        };
        let energy_j = f64::from(energy.get());
        let spare_j = energy_j - RESERVE * f64::from(config.full.get());
        let unseen_w = Consumption::default().standing_w(config.energy_per_metre_j, config.speed_mps);
        let seen = Seen {
            config,
            energy,
            per_metre_j: per_metre_j(energy_j, reach),
            at_most_j: per_metre_j(spare_j, decision.sure_reach),
            standing_w: decision.standing_w.unwrap_or(unseen_w),
            ways: self.routes.ways(cell).into(),
        };
        let offers = self.site.piles.iter().map(|pile| {
            let row = known.explanations.iter().find(|row| row.pile == pile.id)?;
            let mut seat = Seat::from(row);
            if row.stands_here && known.robot != robot {
                seat.availability = Some(Availability::Done);
            }
            Some(self.offer(now, &seen, pile, &seat))
        });
        Some(Asker {
            robot,
            position,
            energy,
            asked_at: decision.asked_at_ms,
            waited_s: decision.waited_s + now.since(decision.at_ms).0 as f64 / 1000.0,
            urgency: decision.urgency,
            is_critical: decision.is_critical,
            reach,
            sure_reach: decision.sure_reach,
            standing_w: seen.standing_w,
            offers: offers.collect::<Option<_>>()?,
        })
    }

    fn share(&self, asker: &Asker) -> Option<f64> {
        let config = self.robots.get(&asker.robot)?;
        Some(f64::from(asker.energy.get()) / f64::from(config.full.get()))
    }
}

impl From<&Explanation> for Seat {
    fn from(row: &Explanation) -> Self {
        // Others of the same instant had taken the facility's power by then.
        let lacked_power = row.verdict == Verdict::NoPower.name();
        Self {
            availability: row.availability.map(|was| if lacked_power { Availability::Reserved } else { was }),
            remaining: row.remaining,
            free_in_s: row.free_in_s,
            next_is_open: row.next_is_open,
            holder: row.holder,
        }
    }
}
