//! Watches that no pile ever has two holders, from outside.
//!
//! The auditor believes nobody: at every step it compares what the pile cores say and do with who
//! really stands on their contacts, and later with the leases that the coordinator says it had
//! then. A site that is well has an empty list of [`Violation`]s.

use std::{
    collections::{BTreeMap, BTreeSet},
    fmt,
};

use firmware_pile::plant::Plant;
use protocol::{DurationMs, LeaseId, LeaseRef, Millis, PileId, PileState, RobotId};

/// How long pile and coordinator may disagree about a holder: news need time to travel.
const NEWS: DurationMs = DurationMs(5_000);
/// How long holders are remembered for claims about the past.
const MEMORY: DurationMs = DurationMs(600_000);

/// One pile at one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Sight {
    /// What its core said last.
    pub said: PileState,
    /// Whether it wants current at its contacts.
    pub live: bool,
    /// Who stands on its contacts.
    pub at_contacts: Vec<RobotId>,
}

impl Sight {
    /// What is seen of a pile that has `said` something, with this charger.
    #[must_use]
    pub fn new(said: PileState, plant: &Plant, at_contacts: Vec<RobotId>) -> Self {
        Self { said, live: plant.power().current_limit_a > 0.0, at_contacts }
    }
}

/// What the coordinator says of one pile: that it had accepted a lease of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Claim {
    /// When.
    pub at: Millis,
    /// Which pile.
    pub pile: PileId,
    /// Whose lease.
    pub granted: RobotId,
}

/// A pile, or a robot, that was given twice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Violation {
    /// The pile gave energy to a robot that does not hold its lease.
    WrongRobot {
        /// Which pile.
        pile: PileId,
        /// Who stood on its contacts.
        robot: RobotId,
    },
    /// The pile took a new lease while it held another.
    Replaced {
        /// Which pile.
        pile: PileId,
        /// The lease that never ended.
        lease: LeaseId,
    },
    /// One robot held two piles.
    TwoPiles {
        /// Which robot.
        robot: RobotId,
        /// One pile.
        one: PileId,
        /// The other.
        other: PileId,
    },
    /// The coordinator took the pile to be held by somebody while it was held by another.
    Disputed {
        /// Which pile.
        pile: PileId,
        /// Who held it.
        holder: RobotId,
        /// Whom the coordinator had given it to.
        granted: RobotId,
    },
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::WrongRobot { pile, robot } => {
                write!(f, "pile {pile} gave energy to robot {robot}, which does not hold its lease")
            }
            Self::Replaced { pile, lease } => {
                write!(f, "pile {pile} took a new lease before lease {lease} had ended")
            }
            Self::TwoPiles { robot, one, other } => write!(f, "robot {robot} held piles {one} and {other}"),
            Self::Disputed { pile, holder, granted } => {
                write!(f, "pile {pile} was taken to be robot {granted}'s while robot {holder} held it")
            }
        }
    }
}

/// What the auditor remembers.
#[derive(Clone, Debug, Default)]
pub struct Auditor {
    /// Every pile's holders, and since when, oldest first.
    holders: BTreeMap<PileId, Vec<(Millis, Option<LeaseRef>)>>,
    claims: Vec<Claim>,
    violations: BTreeSet<(LeaseId, Violation)>,
}

impl Auditor {
    /// Looks at all piles at once. The same violation under the same lease counts once.
    pub fn look(&mut self, now: Millis, sights: &BTreeMap<PileId, Sight>) {
        let mut holdings: BTreeMap<RobotId, PileId> = BTreeMap::new();
        for (&pile, sight) in sights {
            self.check_contacts(pile, sight);
            self.check_replaced(now, pile, sight);
            if let Some(holder) = sight.said.holder
                && let Some(one) = holdings.insert(holder.robot, pile)
            {
                self.note(holder, Violation::TwoPiles { robot: holder.robot, one, other: pile });
            }
        }
        // News of the time after a claim have to be in before it is judged.
        let (ripe, rest) = self.claims.iter().partition(|claim| now.since(claim.at) > NEWS);
        self.claims = rest;
        let ripe: Vec<Claim> = ripe;
        ripe.into_iter().for_each(|claim| self.check_claim(claim));
    }

    /// Takes a claim of the coordinator's, to be judged when all news are in.
    pub fn hear(&mut self, claim: Claim) {
        self.claims.push(claim);
    }

    /// What was found, in the order of the leases.
    pub fn violations(&self) -> impl Iterator<Item = &Violation> {
        self.violations.iter().map(|(_, violation)| violation)
    }

    fn note(&mut self, lease: LeaseRef, violation: Violation) {
        self.violations.insert((lease.lease, violation));
    }

    fn check_contacts(&mut self, pile: PileId, sight: &Sight) {
        if !sight.live {
            return;
        }
        for &robot in &sight.at_contacts {
            if sight.said.holder.is_none_or(|holder| holder.robot != robot) {
                let lease = sight.said.holder.map_or_else(LeaseId::default, |holder| holder.lease);
                self.violations.insert((lease, Violation::WrongRobot { pile, robot }));
            }
        }
    }

    fn check_replaced(&mut self, now: Millis, pile: PileId, sight: &Sight) {
        let holder = sight.said.holder;
        let past = self.holders.entry(pile).or_default();
        let before = past.last().and_then(|&(_, before)| before);
        if past.is_empty() || before != holder {
            past.push((now, holder));
        }
        let forgotten = past.partition_point(|&(since, _)| now.since(since) > MEMORY);
        // The last of the old ones lasted on.
        past.drain(..forgotten.saturating_sub(1));
        if let (Some(before), Some(holder)) = (before, holder) {
            let ended = sight.said.ended.is_some_and(|ended| ended.lease.lease == before.lease);
            if before.lease != holder.lease && !ended {
                self.note(before, Violation::Replaced { pile, lease: before.lease });
            }
        }
    }

    /// Somebody else must not have held the pile all the time around the claim.
    fn check_claim(&mut self, Claim { at, pile, granted }: Claim) {
        let Some(past) = self.holders.get(&pile) else { return };
        let from = Millis(at.0.saturating_sub(NEWS.0.into()));
        let first = past.partition_point(|&(since, _)| since <= from).saturating_sub(1);
        let around = past.iter().skip(first).take_while(|&&(since, _)| since <= at.after(NEWS));
        let holders: Option<Vec<LeaseRef>> = around.map(|&(_, holder)| holder).collect();
        let Some(holders) = holders else { return };
        if let Some(&holder) = holders.first()
            && holders.iter().all(|holder| holder.robot != granted)
        {
            self.note(holder, Violation::Disputed { pile, holder: holder.robot, granted });
        }
    }
}

#[cfg(test)]
mod tests {
    use protocol::{Availability, BootEpoch, EndReason, EndedLease, Epoch, Fraction, PileRow};

    use super::*;

    const PILE: PileId = PileId(3);

    fn lease(lease: u32, robot: u16) -> LeaseRef {
        LeaseRef { epoch: Epoch(1), lease: LeaseId(lease), robot: RobotId(robot) }
    }

    fn sight(holder: Option<LeaseRef>) -> Sight {
        let row = PileRow {
            pile: PILE,
            boot: BootEpoch(1),
            version: 1,
            stamp: None,
            availability: Availability::Reserved,
            remaining: Fraction::MIN,
            planned: DurationMs(0),
        };
        let said = PileState {
            row,
            elapsed: DurationMs(0),
            holder,
            energised: false,
            ended: None,
            standing: None,
            current: None,
        };
        Sight { said, live: false, at_contacts: Vec::new() }
    }

    fn found(looks: impl IntoIterator<Item = (u64, Vec<(PileId, Sight)>)>) -> Vec<Violation> {
        let mut auditor = Auditor::default();
        for (now, sights) in looks {
            auditor.look(Millis(now), &sights.into_iter().collect());
        }
        auditor.violations().copied().collect()
    }

    #[test]
    fn a_charge_of_the_holder_and_its_orderly_end_are_fine() {
        let holder = lease(1, 7);
        let charging = Sight { live: true, at_contacts: vec![RobotId(7)], ..sight(Some(holder)) };
        let mut next = sight(Some(lease(2, 8)));
        next.said.ended =
            Some(EndedLease { lease: holder, reason: EndReason::Completed, charged: DurationMs(1) });
        assert_eq!(found([(0, vec![(PILE, charging)]), (1, vec![(PILE, next)])]), []);
    }

    #[test]
    fn energy_for_a_robot_without_the_lease_is_found() {
        let stranger = Sight { live: true, at_contacts: vec![RobotId(8)], ..sight(Some(lease(1, 7))) };
        let nobody = Sight { live: true, at_contacts: vec![RobotId(9)], ..sight(None) };
        let robot = |robot| Violation::WrongRobot { pile: PILE, robot: RobotId(robot) };
        assert_eq!(found([(0, vec![(PILE, stranger)]), (1, vec![(PILE, nobody)])]), [robot(9), robot(8)]);
    }

    #[test]
    fn a_lease_that_replaces_another_is_found() {
        let looks =
            [(0, vec![(PILE, sight(Some(lease(1, 7))))]), (1, vec![(PILE, sight(Some(lease(2, 8))))])];
        assert_eq!(found(looks), [Violation::Replaced { pile: PILE, lease: LeaseId(1) }]);
    }

    #[test]
    fn a_robot_with_two_piles_is_found() {
        let sights = vec![(PILE, sight(Some(lease(1, 7)))), (PileId(4), sight(Some(lease(2, 7))))];
        let expected = Violation::TwoPiles { robot: RobotId(7), one: PILE, other: PileId(4) };
        assert_eq!(found([(0, sights)]), [expected]);
    }

    #[test]
    fn a_coordinator_that_takes_a_held_pile_for_anothers_is_found_unless_news_were_only_late() {
        let judge = |at| {
            let mut auditor = Auditor::default();
            let look = |auditor: &mut Auditor, now, holder| {
                auditor.look(Millis(now), &[(PILE, sight(holder))].into());
            };
            look(&mut auditor, 0, Some(lease(1, 7)));
            look(&mut auditor, 20_000, None);
            auditor.hear(Claim { at: Millis(at), pile: PILE, granted: RobotId(8) });
            look(&mut auditor, 40_000, None);
            auditor.violations().copied().collect::<Vec<_>>()
        };
        let disputed = Violation::Disputed { pile: PILE, holder: RobotId(7), granted: RobotId(8) };
        assert_eq!(judge(10_000), [disputed]);
        assert_eq!(judge(17_000), [], "the pile let go three seconds later");
        assert_eq!(judge(30_000), [], "nobody held the pile");
    }

    #[test]
    fn a_claim_that_is_true_is_no_violation() {
        let mut auditor = Auditor::default();
        auditor.look(Millis(0), &[(PILE, sight(Some(lease(1, 7))))].into());
        auditor.hear(Claim { at: Millis(1_000), pile: PILE, granted: RobotId(7) });
        auditor.look(Millis(90_000), &[(PILE, sight(Some(lease(1, 7))))].into());
        assert_eq!(auditor.violations().count(), 0);
    }
}
