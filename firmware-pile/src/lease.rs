//! Who may use the pile, and which commands are obeyed.
//!
//! A lease is granted by the coordinator with the highest epoch seen, for one robot, until an
//! expiry which the coordinator moves on while it wants the lease to last. It ends on completion,
//! expiry, fault, revocation or the robot's departure, once, and its number is never accepted
//! again. There is at most one.
//!
//! While no coordinator is heard the pile may make a lease for itself, for a robot that claims it
//! ([`Leases::claim`]). It has the epoch that is known and a number of its own kind, and is a lease like any
//! other: the coordinator that is back extends or revokes it.
//!
//! # Expiry and a lost coordinator
//! Before the robot has arrived the lease ends at its expiry. A charge under way has to tell a
//! coordinator that chose not to extend the lease from one that is lost, because without a
//! coordinator the pile finishes the charge it is in. So from the expiry on the pile asks for the
//! time every few seconds, and the charge ends [`EXTENSION_GRACE`] after the coordinator is first heard
//! past the expiry, unless it extends the lease in between. A coordinator that comes back has the
//! grace to take its leases over; while it stays silent the charge runs to its planned end and no
//! further.

use heapless::HistoryBuf;
use protocol::{
    ClaimPile, CommandHead, DurationMs, EndReason, EndedLease, Epoch, Grant, LeaseId, LeaseRef, Millis,
    NackReason, Revoke, RobotId, SiteMillis, TagId, limits,
};

use crate::charge::Charge;

/// How long a coordinator has to extend a lease that ran out under a charge.
pub const EXTENSION_GRACE: DurationMs = DurationMs(5_000);
/// Ended leases whose late grants are refused by number; older ones fall to their time to live.
pub const REMEMBERED_LEASES: usize = 8;
/// Commands whose repeats are answered without doing them again.
pub const REMEMBERED_COMMANDS: usize = 16;

/// What a command is answered.
pub type Answer = Result<(), NackReason>;

/// The lease that is held.
#[derive(Clone, Copy, Debug)]
pub struct Lease {
    /// Its names.
    pub name: LeaseRef,
    /// How the reader recognises its robot.
    pub tag: TagId,
    /// When it runs out.
    pub expiry: SiteMillis,
    /// How long its charge is to take (LMPP eq. 2).
    pub planned: DurationMs,
    /// The charge, from the robot's arrival on.
    pub charge: Option<Charge>,
    /// When the coordinator was first heard after the expiry.
    heard_past_expiry: Option<Millis>,
}

impl Lease {
    /// Whether the lease ends by its expiry: see the module's documentation.
    #[must_use]
    pub fn has_run_out(&self, now: Millis, site_now: SiteMillis) -> bool {
        match (site_now < self.expiry, self.charge) {
            (true, _) => false,
            (false, None) => true,
            (false, Some(_)) => {
                self.heard_past_expiry.is_some_and(|heard| now.since(heard) >= EXTENSION_GRACE)
            }
        }
    }
}

/// What a grant depends on besides the leases.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// The site's time, if known.
    pub site_now: Option<SiteMillis>,
    /// Whether the pile has a fault.
    pub faulted: bool,
    /// Whether another robot than the grant's stands at the contacts.
    pub occupied: bool,
}

impl Place {
    fn is_free(self) -> Answer {
        match self {
            Self { faulted: true, .. } => Err(NackReason::Faulted),
            Self { occupied: true, .. } => Err(NackReason::Occupied),
            _ => Ok(()),
        }
    }
}

/// What ends a lease besides its own time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Circumstances {
    /// Whether the pile has a fault.
    pub faulted: bool,
    /// Whether the lease's robot is not at the contacts any more.
    pub robot_left: bool,
}

/// The current lease, and what is remembered of earlier ones.
#[derive(Clone, Debug)]
pub struct Leases {
    highest_epoch: Epoch,
    current: Option<Lease>,
    ended: Option<EndedLease>,
    past: HistoryBuf<LeaseId, REMEMBERED_LEASES>,
    /// Two coordinators on copies of one log share an epoch and count their commands alike: a repeat is
    /// about the same lease, too.
    answers: HistoryBuf<(LeaseRef, CommandHead, Answer), REMEMBERED_COMMANDS>,
}

impl Leases {
    /// No lease; `highest_epoch` as it was remembered over the restart.
    #[must_use]
    pub const fn new(highest_epoch: Epoch) -> Self {
        Self {
            highest_epoch,
            current: None,
            ended: None,
            past: HistoryBuf::new(),
            answers: HistoryBuf::new(),
        }
    }

    /// The highest epoch seen.
    #[must_use]
    pub const fn highest_epoch(&self) -> Epoch {
        self.highest_epoch
    }

    /// The lease that is held.
    #[must_use]
    pub const fn current(&self) -> Option<&Lease> {
        self.current.as_ref()
    }

    /// The lease that was held and ended last.
    #[must_use]
    pub const fn ended(&self) -> Option<EndedLease> {
        self.ended
    }

    /// The charge of the current lease.
    pub fn charge_mut(&mut self) -> Option<&mut Charge> {
        self.current.as_mut()?.charge.as_mut()
    }

    /// The current lease's robot has arrived: its charge begins, unless it had begun before.
    pub fn begin_charge(&mut self) {
        if let Some(lease) = &mut self.current {
            lease.charge.get_or_insert(Charge::new(lease.planned));
        }
    }

    /// A coordinator of this epoch exists.
    pub fn see_epoch(&mut self, epoch: Epoch) {
        self.highest_epoch = self.highest_epoch.max(epoch);
    }

    /// The coordinator was heard.
    pub fn coordinator_heard(&mut self, now: Millis, site_now: Option<SiteMillis>) {
        if let Some(lease) = &mut self.current
            && site_now.is_some_and(|site_now| site_now >= lease.expiry)
        {
            lease.heard_past_expiry.get_or_insert(now);
        }
    }

    /// Obeys a grant or says why not; `planned` is the time its charge would take.
    ///
    /// # Errors
    /// Why the grant is refused.
    pub fn grant(&mut self, grant: &Grant, planned: DurationMs, place: Place) -> Answer {
        self.once(grant.lease, grant.head, place.site_now, |leases| {
            let Some(site_now) = place.site_now else { return Err(NackReason::ClockUnknown) };
            if site_now >= grant.expiry {
                return Err(NackReason::TooLate);
            }
            if leases.past.contains(&grant.lease.lease) {
                return Err(NackReason::Ended);
            }
            if let Some(lease) = &mut leases.current {
                return extend(lease, grant);
            }
            place.is_free()?;
            leases.current = Some(Lease {
                name: grant.lease,
                tag: grant.tag,
                expiry: grant.expiry,
                planned,
                charge: None,
                heard_past_expiry: None,
            });
            Ok(())
        })
    }

    /// Gives the pile to a robot that claims it, under the number `id`; `planned` is the time its charge would
    /// take. Whether claims are served now is for the caller to know. A robot that has the lease already keeps
    /// it as it is.
    ///
    /// # Errors
    /// Why the claim is refused.
    pub fn claim(
        &mut self,
        id: LeaseId,
        robot: RobotId,
        claim: &ClaimPile,
        planned: DurationMs,
        place: Place,
    ) -> Answer {
        if let Some(Lease { name, tag, .. }) = self.current {
            let has_it = name.robot == robot && tag == claim.tag;
            return if has_it { Ok(()) } else { Err(NackReason::Held { by: name }) };
        }
        let site_now = place.site_now.ok_or(NackReason::ClockUnknown)?;
        place.is_free()?;
        self.current = Some(Lease {
            name: LeaseRef { epoch: self.highest_epoch, lease: id, robot },
            tag: claim.tag,
            expiry: site_now.after(claim.within.min(limits::LONGEST_CLAIM)),
            planned,
            charge: None,
            heard_past_expiry: None,
        });
        Ok(())
    }

    /// Ends the lease that is named; one that is not held counts as ended from then on.
    ///
    /// # Errors
    /// Why the revocation is refused.
    pub fn revoke(&mut self, revoke: &Revoke, site_now: Option<SiteMillis>) -> Answer {
        self.once(revoke.lease, revoke.head, site_now, |leases| {
            let id = revoke.lease.lease;
            if leases.current.is_some_and(|lease| lease.name.lease == id) {
                leases.end(EndReason::Revoked);
            } else if !leases.past.contains(&id) {
                leases.past.write(id);
            }
            Ok(())
        })
    }

    /// Why the current lease is over, if it is. Of a pile that does not know the time nothing is.
    #[must_use]
    pub fn over(&self, now: Millis, site_now: Option<SiteMillis>, seen: Circumstances) -> Option<EndReason> {
        let (lease, site_now) = self.current.as_ref().zip(site_now)?;
        if lease.charge.is_some_and(|charge| charge.is_complete()) {
            Some(EndReason::Completed)
        } else if seen.faulted {
            Some(EndReason::Fault)
        } else if lease.has_run_out(now, site_now) {
            Some(EndReason::Expired)
        } else if lease.charge.is_some() && seen.robot_left {
            Some(EndReason::RobotLeft)
        } else {
            None
        }
    }

    /// Ends the current lease, if there is one.
    pub fn end(&mut self, reason: EndReason) {
        if let Some(lease) = self.current.take() {
            let charged = lease.charge.map_or(DurationMs(0), |charge| charge.elapsed());
            self.ended = Some(EndedLease { lease: lease.name, reason, charged });
            self.past.write(lease.name.lease);
        }
    }

    /// What all commands have in common: a repeat is answered as before, a lower epoch and a late
    /// command are refused. Without a clock nothing is known to be late.
    fn once(
        &mut self,
        lease: LeaseRef,
        head: CommandHead,
        site_now: Option<SiteMillis>,
        obey: impl FnOnce(&mut Self) -> Answer,
    ) -> Answer {
        let known = |(of, was, _): &&(LeaseRef, CommandHead, Answer)| (*of, *was) == (lease, head);
        if let Some((_, _, answer)) = self.answers.iter().find(known) {
            return *answer;
        }
        self.see_epoch(lease.epoch);
        let answer = if lease.epoch < self.highest_epoch {
            Err(NackReason::StaleEpoch { highest: self.highest_epoch })
        } else if site_now.is_some_and(|site_now| site_now > head.valid_until) {
            Err(NackReason::TooLate)
        } else {
            obey(self)
        };
        self.answers.write((lease, head, answer));
        answer
    }
}

/// Moves a lease's expiry on. Extensions may arrive in any order: none shortens the lease.
fn extend(lease: &mut Lease, grant: &Grant) -> Answer {
    let same = lease.name.lease == grant.lease.lease
        && lease.name.robot == grant.lease.robot
        && lease.tag == grant.tag;
    if !same {
        return Err(NackReason::Held { by: lease.name });
    }
    lease.name.epoch = grant.lease.epoch;
    lease.expiry = lease.expiry.max(grant.expiry);
    lease.heard_past_expiry = None;
    Ok(())
}
