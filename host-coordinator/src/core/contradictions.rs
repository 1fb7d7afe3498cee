//! What a pile and a robot say that cannot both be right, and who has fallen silent.
//!
//! Looked at once a second. What lasts for [`ROBOT_PATIENCE`] while both are heard is an event; so is its
//! end. What follows is the same every time:
//!
//! | what | what follows |
//! |---|---|
//! | [`Unleased`](Contradiction::Unleased) | nobody else is given the pile, and whom it was reserved for waits again; the robot that stands there is given it when it asks |
//! | [`NoCurrent`](Contradiction::NoCurrent) | the lease is taken back, and the robot waits again |
//! | [`NotDocked`](Contradiction::NotDocked) | the charge goes on: the pile sees the tag, feels the contacts and measures the current |
//!
//! The operator is told of each.

use std::collections::BTreeMap;

use planning::grid::Cell;
use protocol::{Activity, Availability, PileId, RobotId, SiteMillis, limits};

use super::{
    ROBOT_PATIENCE,
    coordinator::Coordinator,
    event::{Contradiction, Device, Fact},
    observed::SeenRobot,
    state::Place,
    turn::Turn,
};

/// A smaller current is noise, in amperes.
const NO_CURRENT_A: f32 = 0.3;

/// What contradicts what, and who is concerned if that is known.
pub type Seen = (Contradiction, Option<RobotId>);

impl Coordinator {
    /// Records who has fallen silent, and which contradictions have lasted or are over.
    pub(super) fn compare_words(&mut self, turn: &mut Turn) {
        let due = turn.now.since(self.observed.compared_at) >= limits::REPEAT_INTERVAL;
        if !due {
            return;
        }
        self.observed.compared_at = turn.now;
        self.note_silence(turn);
        let standing = self.robots_by_cell(turn.now);
        let piles: Vec<_> = self.site.piles.iter().map(|pile| (pile.id, pile.cell)).collect();
        for (pile, cell) in piles {
            let seen = self.contradiction(pile, standing.get(&cell).copied(), turn.now);
            self.follow_contradiction(turn, pile, seen);
        }
    }

    fn note_silence(&mut self, turn: &mut Turn) {
        let piles = self.site.piles.iter().map(|pile| Device::Pile(pile.id));
        let devices: Vec<_> = piles.chain(self.robots.keys().map(|robot| Device::Robot(*robot))).collect();
        for who in devices {
            let contact = match who {
                Device::Pile(pile) => self.observed.piles.get(&pile).map(|seen| seen.contact),
                Device::Robot(robot) => self.observed.robots.get(&robot).map(|seen| seen.contact),
            };
            let is_silent = self.observed.is_silent(contact.as_ref(), turn.now);
            let was_heard = contact.is_some_and(|contact| contact.heard.is_some());
            let known = self.state.silent.contains(&who);
            if is_silent && !known {
                self.record(turn, Fact::FellSilent { who });
            } else if !is_silent && known && was_heard {
                self.record(turn, Fact::HeardAgain { who });
            }
        }
    }

    /// The robots that are heard, by where they say they are.
    fn robots_by_cell(&self, now: SiteMillis) -> BTreeMap<Cell, RobotId> {
        let heard =
            self.observed.robots.iter().filter(|(robot, _)| !self.observed.robot_is_silent(**robot, now));
        let at = heard.filter_map(|(robot, seen)| Some((self.site.cell_of(seen.report?.position)?, *robot)));
        at.collect()
    }

    /// What is seen at a pile now, however short.
    fn contradiction(&self, pile: PileId, at_cell: Option<RobotId>, now: SiteMillis) -> Option<Seen> {
        let report = self.observed.report(pile, now);
        let lease = self.state.lease(pile).filter(|lease| lease.is_wanted());
        let holder = lease
            .map(|lease| lease.name.robot)
            .or(report.and_then(|report| report.holder).map(|holder| holder.robot));
        let by_tag = report.and_then(|report| report.standing);
        let stranger = at_cell.filter(|robot| Some(*robot) != holder && !self.is_sent_to(*robot, pile));
        if by_tag.is_some() || stranger.is_some() {
            let known = by_tag.and_then(|tag| self.robot_of(tag)).or(stranger);
            return Some((Contradiction::Unleased, known));
        }
        let robot = holder?;
        let says = self.activity(robot, now)?;
        let flows = report?.current.is_some_and(|current| current.get() >= NO_CURRENT_A);
        match says {
            Activity::Charging if !flows => Some((Contradiction::NoCurrent, Some(robot))),
            Activity::Working | Activity::Waiting | Activity::Approaching if flows => {
                Some((Contradiction::NotDocked, Some(robot)))
            }
            _ => None,
        }
    }

    fn follow_contradiction(&mut self, turn: &mut Turn, pile: PileId, seen: Option<Seen>) {
        let told = self.state.piles.get(&pile).and_then(|record| record.contradiction);
        let watched = &mut self.observed.piles.entry(pile).or_default().contradiction;
        match (seen, *watched) {
            (Some(seen), Some((before, since))) if seen == before => {
                if told.map(|told| told.seen()) != Some(seen) && turn.now.since(since) >= ROBOT_PATIENCE {
                    let (what, robot) = seen;
                    self.record(turn, Fact::Contradicted { pile, robot, what });
                    turn.warn(words(pile, robot, what));
                    self.observed.queue_is_due = true;
                }
            }
            (Some(seen), _) => *watched = Some((seen, turn.now)),
            (None, _) => {
                *watched = None;
                // A pile that is not heard has contradicted nobody.
                if told.is_some() && self.observed.report(pile, turn.now).is_some() {
                    self.record(turn, Fact::ContradictionOver { pile });
                    self.observed.queue_is_due = true;
                }
            }
        }
    }

    /// What stands recorded of a pile.
    pub(super) fn contradicted(&self, pile: PileId) -> Option<Seen> {
        Some(self.state.piles.get(&pile)?.contradiction?.seen())
    }

    /// Whether `robot` itself stands at a pile that would be free without it.
    pub(super) fn stands_at(&self, robot: RobotId, pile: PileId, now: SiteMillis) -> bool {
        self.observed.report(pile, now).is_some_and(|report| {
            let standing = report.standing.and_then(|tag| self.robot_of(tag));
            report.row.availability == Availability::Done
                && standing == Some(robot)
                // After a charge without current it would only come to the same again.
                && self.contradicted(pile).is_none_or(|seen| seen == (Contradiction::Unleased, Some(robot)))
        })
    }

    fn is_sent_to(&self, robot: RobotId, pile: PileId) -> bool {
        let place = self.state.requests.get(&robot).map(|request| request.place);
        place == Some(Place::Next(pile)) || place == Some(Place::Granted(pile))
    }

    fn activity(&self, robot: RobotId, now: SiteMillis) -> Option<Activity> {
        let seen: &SeenRobot = self.observed.robots.get(&robot)?;
        let report = seen.report.filter(|_| !self.observed.is_silent(Some(&seen.contact), now))?;
        Some(report.activity)
    }
}

fn words(pile: PileId, robot: Option<RobotId>, what: Contradiction) -> String {
    let robot = robot.map_or_else(|| "an unknown robot".to_owned(), |robot| format!("robot {robot}"));
    match what {
        Contradiction::Unleased => {
            format!(
                "{robot} stands at pile {pile} without a lease: nobody else is given the pile; move the robot"
            )
        }
        Contradiction::NoCurrent => format!(
            "{robot} says that pile {pile} charges it, and the pile measures no current: its lease is taken back; \
             look at the contacts of both"
        ),
        Contradiction::NotDocked => format!(
            "pile {pile} charges {robot}, which says that it is not there: look who stands at the pile, and \
             whether the tags are right"
        ),
    }
}
