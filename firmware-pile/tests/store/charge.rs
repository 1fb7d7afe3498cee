//! A whole life of a pile against a coordinator that keeps a ledger: it is provisioned, starts, is
//! granted under a new epoch, charges, is passed, finds a contactor welded and is cleared of it, reports
//! and is acknowledged. The power is cut in every word and every erase; the pile starts again and goes on.

use std::collections::BTreeMap;

use embassy_futures::block_on;
use firmware_pile::device::Device;
use firmware_pile::plant::{Battery, Plant};
use firmware_pile::store::{ROOM, Record, Report, Store};
use firmware_pile::{ChargingPile, Input, Outputs, TagRead};
use protocol::*;

use crate::flash::{Flash, TEARS, Tear};
use crate::samples::{identity, load, passes};

const ROBOT: TagId = TagId([7; 12]);
const EPOCH: Epoch = Epoch(5);
/// A start takes less, in milliseconds of the pile's time.
const PATIENCE_MS: u64 = 60_000;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Charge,
    Weld,
    Clear,
    Done,
}

/// The coordinator, which never loses anything, and what is true.
struct World {
    phase: Phase,
    starts: u64,
    commands: u32,
    ledger: BTreeMap<ReportId, ChargeReport>,
    passes: BTreeMap<ReportId, u32>,
    last: [Option<ReportId>; 2],
    /// Reports that came once: the first acknowledgement is always lost.
    seen: Vec<ReportId>,
    /// Reports whose record is in flash, as it was written last.
    promised: BTreeMap<ReportId, Report>,
    /// Reports whose record the power cut short.
    perhaps: BTreeMap<ReportId, Report>,
    boots: Vec<BootEpoch>,
    /// The most that was written under live contacts, in bytes.
    written_live: usize,
}

impl World {
    fn new() -> Self {
        Self {
            phase: Phase::Charge,
            starts: 0,
            commands: 0,
            ledger: BTreeMap::new(),
            passes: BTreeMap::new(),
            last: [None; 2],
            seen: Vec::new(),
            promised: BTreeMap::new(),
            perhaps: BTreeMap::new(),
            boots: Vec::new(),
            written_live: 0,
        }
    }

    /// Takes a report once, and acknowledges it from the second time on.
    fn take(&mut self, kind: usize, report: ReportId, note: impl FnOnce(&mut Self)) -> Option<Message> {
        if self.last[kind].is_none_or(|last| report > last) {
            self.last[kind] = Some(report);
            note(self);
        }
        if self.seen.contains(&report) {
            return Some(Message::Ack(Ack { of: Reference::Report(report) }));
        }
        self.seen.push(report);
        None
    }

    fn answer(&mut self, message: &Message, now: SiteMillis) -> Option<Message> {
        match message {
            Message::Hello(hello) => Some(Message::Hello(Hello { epoch: EPOCH, ..*hello })),
            Message::TimeRequest(TimeRequest { asked_at }) => {
                Some(Message::TimeSync(TimeSync { asked_at: *asked_at, site_now: now }))
            }
            Message::ChargeReport(told) => self.take(0, told.report, |world| {
                assert!(world.ledger.insert(told.report, *told).is_none(), "a charge came twice");
            }),
            Message::PassReport(told) => self.take(1, told.report, |world| {
                let sum = told.passes.iter().map(|count| count.passes).sum();
                assert!(world.passes.insert(told.report, sum).is_none(), "passes came twice");
            }),
            Message::Fault(fault) => Some(Message::Ack(Ack { of: Reference::Report(fault.report) })),
            _ => None,
        }
    }

    fn completed(&self) -> bool {
        self.ledger.values().any(|charge| charge.reason == EndReason::Completed && charge.ended.is_some())
    }
}

/// A pile with its store, as its shell runs it. `None` is the end of the power.
struct Node<'a> {
    world: &'a mut World,
    flash: &'a Flash,
    pile: ChargingPile,
    store: Store<Flash>,
    plant: Plant,
    now: Millis,
}

impl Node<'_> {
    fn site_now(&self) -> SiteMillis {
        SiteMillis(1_000_000 * self.world.starts + self.now.0)
    }

    fn step(&mut self, input: Input<'_>) -> Option<()> {
        let Outputs { power, store, messages, .. } = self.pile.step(self.now, input);
        self.plant.command(power);
        self.flash.allow_erase(!self.pile.energised());
        let before = self.store.room();
        for record in &store {
            let kept = block_on(self.store.append(record));
            self.note(record, kept.is_ok());
            kept.ok()?;
        }
        if self.pile.energised() {
            self.world.written_live += before - self.store.room();
        } else {
            block_on(self.store.make_room()).ok()?;
            assert!(self.store.room() >= ROOM);
        }
        for outgoing in messages {
            if let Some(answer) = self.world.answer(&outgoing.message, self.site_now()) {
                self.hear(answer)?;
            }
        }
        Some(())
    }

    /// A record is in flash, or the power went while it was written, so that it is there or not.
    fn note(&mut self, record: &Record, kept: bool) {
        let world = &mut *self.world;
        match record {
            Record::Waiting(_, report) => {
                let reports = if kept { &mut world.promised } else { &mut world.perhaps };
                reports.insert(report.id(), report.clone());
            }
            Record::Epoch(epoch) => assert_eq!(*epoch, EPOCH),
            _ => {}
        }
    }

    fn hear(&mut self, message: Message) -> Option<()> {
        let header = Header::new(DeviceId::Coordinator, BootEpoch(1), Sequence(0));
        self.step(Input::Frame(&Frame { header, message }))
    }

    /// One sample, and every tenth time what the reader sees; then what the coordinator wants.
    fn live(&mut self) -> Option<()> {
        self.now.0 += 10;
        let here = self.world.phase == Phase::Charge;
        self.plant.battery = here.then(|| self.plant.battery.unwrap_or(Battery::new(1.0e6, 0.5e6)));
        self.plant.welded = self.world.phase == Phase::Weld;
        let sensors = self.plant.sense(self.now);
        self.step(Input::Sensors(sensors))?;
        if !self.now.0.is_multiple_of(100) {
            return Some(());
        }
        if here {
            self.step(Input::Tag(TagRead { tag: ROBOT, rssi_dbm: -50 }))?;
        } else {
            self.step(Input::ReaderIdle)?;
        }
        self.coordinate()
    }

    fn coordinate(&mut self) -> Option<()> {
        self.world.commands += 1;
        let id = CommandId(self.world.commands);
        match self.world.phase {
            Phase::Charge if self.world.completed() => self.world.phase = Phase::Weld,
            Phase::Charge if self.now.0 >= 500 && self.pile.leases().current().is_none() => {
                let valid_until = self.site_now().after(DurationMs(5_000));
                self.hear(Message::Grant(Grant {
                    head: CommandHead { id, valid_until },
                    lease: LeaseRef { epoch: EPOCH, lease: LeaseId(id.0), robot: RobotId(3) },
                    tag: ROBOT,
                    expiry: self.site_now().after(DurationMs(60_000)),
                    energy: EnergyJ::new(250.0).unwrap(),
                }))?;
            }
            Phase::Weld if self.pile.faults().latched().contains(FaultCode::ContactorWelded) => {
                self.world.phase = Phase::Clear;
            }
            Phase::Clear => {
                let welded = FaultCode::ContactorWelded;
                self.hear(Message::ClearFault(ClearFault { command: id, code: welded }))?;
                if self.pile.faults().standing().is_empty() && self.world.passes.values().sum::<u32>() > 0 {
                    self.world.phase = Phase::Done;
                }
            }
            _ => {}
        }
        Some(())
    }
}

/// One start of the board, until the power goes (`None`) or all is done and told.
fn start(flash: &Flash, world: &mut World) -> Option<()> {
    world.starts += 1;
    let (mut store, kept) = load(flash).ok()?;
    assert!(world.boots.iter().all(|boot| *boot < kept.boot), "start {} was there before", kept.boot);
    world.boots.push(kept.boot);
    let device = Device::new(kept.clone());
    block_on(store.make_room()).ok()?;
    let Device::Pile(pile) = device else {
        assert!(world.promised.is_empty(), "a pile has forgotten who it is");
        let firmware_pile::store::Identity { pile, device_key, site_key, boot_floor, parameters } =
            identity();
        let command = CommandId(1);
        let provision = Provision { command, pile, device_key, site_key, boot_floor, parameters };
        let header = Header::new(DeviceId::Service, BootEpoch(1), Sequence(0));
        let frame = Frame { header, message: Message::Provision(provision) };
        let mut fresh = firmware_pile::provisioning::Fresh::new();
        for record in fresh.step(Millis(0), Some(&frame)).store.as_slice() {
            block_on(store.append(record)).ok()?;
        }
        return start(flash, world);
    };
    let mut node = Node { world, flash, pile, store, plant: Plant::new(), now: Millis(0) };
    let mut quiet_ms = 0;
    while quiet_ms < 3_000 {
        node.live()?;
        quiet_ms = if node.world.phase == Phase::Done { quiet_ms + 10 } else { 0 };
        assert!(node.now.0 < PATIENCE_MS, "stuck in phase {:?}", node.world.phase);
    }
    Some(())
}

/// Lives to the end, however often the power goes, and compares the ledger with what was promised.
fn finish(flash: &Flash, world: &mut World) {
    while start(flash, world).is_none() {
        flash.repower();
        flash.allow_erase(true);
    }
    flash.allow_erase(true);
    for (id, report) in &world.promised {
        match report {
            Report::Charge(charge) => {
                let told = world.ledger.get(id).unwrap_or_else(|| panic!("charge {id} is lost"));
                // The record of its end was promised last.
                let perhaps = world.perhaps.get(id) == Some(&Report::Charge(*told));
                assert!(told == charge || perhaps, "{charge:?} is told as {told:?}");
            }
            Report::Passes(_) => assert!(world.passes.contains_key(id), "passes {id} are lost"),
        }
    }
    let written = |id: &ReportId| world.promised.contains_key(id) || world.perhaps.contains_key(id);
    assert!(world.ledger.keys().chain(world.passes.keys()).all(written), "something was told unwritten");
    assert!(world.completed());
    // The cut may be one that comes after this life.
    flash.repower();
    let (_, kept) = load(flash).unwrap();
    assert_eq!((kept.identity, kept.epoch), (Some(identity()), EPOCH));
    assert!(kept.latched.is_empty() && kept.journal.iter().all(Option::is_none), "{kept:?}");
}

/// Cuts the life from `begin` in every operation.
fn cut_everywhere(begin: &[u8]) -> (u64, u64) {
    let whole = Flash::holding(begin.to_vec());
    finish(&whole, &mut World::new());
    let operations = whole.operations();
    let cut = |tear: Tear| {
        (0..operations).for_each(|operation| {
            let flash = Flash::holding(begin.to_vec());
            flash.cut_at(operation, tear);
            finish(&flash, &mut World::new());
        });
    };
    std::thread::scope(|scope| TEARS.into_iter().for_each(|tear| drop(scope.spawn(move || cut(tear)))));
    (operations, whole.erases().iter().sum())
}

/// A flash that a pile has used for long, so that its sectors turn before, in or after the charge.
fn used() -> Vec<u8> {
    let flash = Flash::new();
    let (mut store, _) = load(&flash).unwrap();
    let mut number = 0;
    while store.room() > ROOM + 200 {
        number += 1;
        block_on(store.append(&Record::Waiting(0, passes(1, number)))).unwrap();
    }
    block_on(store.append(&Record::Acknowledged(0))).unwrap();
    flash.bytes()
}

#[test]
fn a_ledger_is_the_truth_wherever_the_power_is_cut() {
    let (new, _) = cut_everywhere(&Flash::new().bytes());
    let (turning, erases) = cut_everywhere(&used());
    assert!(erases > 0, "the sectors have not turned");
    println!(
        "a life of {new} words and erases, one of {turning} with {erases} erases; cut in each, torn in 6 ways"
    );
}

#[test]
fn a_charge_writes_a_fraction_of_the_room_that_is_made_for_it() {
    let flash = Flash::new();
    let mut world = World::new();
    finish(&flash, &mut world);
    // Besides: all places of the journal acknowledged under live contacts, and a new epoch each time.
    let others = 8 * (12 + 16);
    println!("a charge writes {} bytes under live contacts, others at most {others}", world.written_live);
    assert!(world.written_live > 0, "nothing was written");
    assert!(world.written_live + others < ROOM / 2);
}
