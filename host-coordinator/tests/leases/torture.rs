//! A day on a bad line, with restarts of everybody: no wrong state at any instant, and in the end no
//! lease is left and the piles' journals and the coordinator's ledger say the same.

use std::collections::{BTreeMap, BTreeSet};

use firmware_pile::store::Report;
use host_coordinator::core::{Event, Fact};
use protocol::{ChargeReport, LeaseRef, PassReport, PileId, ReportId, RobotId, TagId};

use crate::bad_line::Trouble as Line;
use crate::box_site::{BoxSite, Trouble, leases};

const SEED: u64 = 24;
const MINUTE: u64 = 60_000;
const DAY: u64 = 24 * 60 * MINUTE;
const ROBOTS: u16 = 4;
const PILES: usize = 2;

#[test]
fn after_a_day_on_a_bad_line_no_lease_is_stuck_and_the_ledger_is_the_journal() {
    println!("seed {SEED}");
    let mut site = BoxSite::new(SEED, ROBOTS, PILES);
    site.trouble = Trouble {
        line: Line { lost: 10, damaged: 10, repeated: 10, late: 10, delay_ms: 90 },
        abandon: 1,
        ..Trouble::default()
    };
    let piles: Vec<PileId> = site.piles.keys().copied().collect();
    let end = site.now + DAY;
    while site.now < end {
        let quiet = site.random.below(8 * MINUTE);
        site.run(quiet);
        let pile = piles[site.random.below(piles.len() as u64) as usize];
        match site.random.below(4) {
            0 => site.crash(),
            1 => site.restart_pile(pile),
            2 => site.piles[&pile].cut_soon(&mut site.random),
            // The worst: both at once.
            _ => {
                site.restart_pile(pile);
                site.crash();
            }
        }
    }
    come_to_rest(&mut site);
    let (charges, passes) = ledger_is_the_journal(&site);
    println!("{}", site.line.figures);
    println!(
        "{} restarts of the coordinator, {} of piles; {} leases with current, {charges} charges and {passes} \
         passes in the ledger, {} visits; {} events",
        site.crashes,
        site.pile_restarts,
        site.flowed.len(),
        site.visits,
        site.log.len()
    );
    let figures = &site.line.figures;
    assert!(
        [figures.lost, figures.damaged, figures.repeated, figures.overtaken].into_iter().all(|n| n > 1_000)
    );
    assert!(site.crashes > 50 && site.pile_restarts > 50 && charges > 500, "hardly anything happened");
}

/// The line is good and nobody asks any more: every lease ends, and everything waiting is told.
fn come_to_rest(site: &mut BoxSite) {
    site.trouble = Trouble { line: Line { delay_ms: 50, ..Line::default() }, ..Trouble::default() };
    site.closing = true;
    site.run(30 * MINUTE);
    assert_eq!(leases(site.coordinator.state()), BTreeMap::new(), "seed {}: a lease is stuck", site.seed);
    for id in site.piles.keys().copied().collect::<Vec<_>>() {
        let held = site.piles[&id].core.leases().current();
        assert!(held.is_none(), "seed {}: pile {id} is held: {held:?}", site.seed);
        site.restart_pile(id);
        assert_eq!(site.piles[&id].waited, 0, "seed {}: pile {id} has untold reports", site.seed);
    }
}

/// Every report that a pile has written down is noted once and as it was written, and nothing else is;
/// under every lease that gave current there is a charge. Says how many charges and passes there are.
fn ledger_is_the_journal(site: &BoxSite) -> (usize, u64) {
    let mut noted: BTreeMap<(PileId, ReportId), &Fact> = BTreeMap::new();
    let (mut charged, mut over, mut charges) = (BTreeSet::new(), BTreeSet::new(), 0);
    for Event { fact, .. } in &site.log {
        let (Fact::Charged { pile, report, .. } | Fact::Passed { pile, report, .. }) = fact else { continue };
        assert!(noted.insert((*pile, *report), fact).is_none(), "seed {}: twice: {fact:?}", site.seed);
        if let Fact::Charged { lease, ended, .. } = fact {
            charged.insert((*pile, *lease));
            // Those before it were interrupted by the power, and the coordinator has kept the lease.
            let last = ended.is_none() || over.insert((*pile, *lease));
            assert!(last, "seed {}: a lease has ended twice: {fact:?}", site.seed);
            charges += 1;
        }
    }
    for (id, pile) in &site.piles {
        for (report, written) in &pile.written.reports {
            let fact = noted.get(&(*id, *report));
            let fact = fact.unwrap_or_else(|| panic!("seed {}: pile {id} lost {written:?}", site.seed));
            let versions = pile.written.under_way.iter().filter(|other| other.id() == *report);
            let told = [written].into_iter().chain(versions).any(|version| fact_of(*id, version) == **fact);
            assert!(told, "seed {}: {written:?} was noted as {fact:?}", site.seed);
        }
    }
    for ((pile, report), fact) in &noted {
        let written = &site.piles[pile].written;
        let known = written.reports.contains_key(report)
            || written.under_way.iter().any(|other| other.id() == *report);
        assert!(known, "seed {}: nobody wrote {fact:?}", site.seed);
    }
    let unpaid: Vec<_> = site.flowed.difference(&charged).collect();
    assert!(unpaid.is_empty(), "seed {}: current without a charge: {unpaid:?}", site.seed);

    let passes = site.coordinator.state().passes.values().flat_map(BTreeMap::values).sum();
    // A restart forgets passes that were not written down yet, and counts a robot that stands there again.
    let restarts = u64::from(site.pile_restarts);
    assert!(passes <= site.visits + restarts, "seed {}: {passes} of {} visits", site.seed, site.visits);
    assert!(passes + 2 * restarts >= site.visits, "seed {}: {passes} of {} visits", site.seed, site.visits);
    (charges, passes)
}

/// What the coordinator notes of a report.
fn fact_of(pile: PileId, report: &Report) -> Fact {
    match report {
        Report::Charge(ChargeReport {
            report,
            lease: LeaseRef { lease, robot, .. },
            reason,
            began,
            ended,
            charged,
            energy,
            ..
        }) => Fact::Charged {
            pile,
            report: *report,
            lease: *lease,
            robot: *robot,
            reason: *reason,
            began: *began,
            ended: *ended,
            charged: *charged,
            energy: *energy,
        },
        Report::Passes(PassReport { report, passes }) => {
            let passes = passes.iter().map(|count| host_coordinator::core::event::Passes {
                robot: robot_of(count.tag),
                period: count.period,
                passes: count.passes,
            });
            Fact::Passed { pile, report: *report, passes: passes.collect() }
        }
    }
}

/// As the site makes tags.
fn robot_of(TagId([low, high, ..]): TagId) -> RobotId {
    RobotId(u16::from_le_bytes([low, high]))
}
