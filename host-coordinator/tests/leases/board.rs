//! A pile's board: the real core and the real store, on a flash that forgets nothing but what was
//! under way when the power went, and a model of what is connected to it.

use std::collections::BTreeMap;

use embassy_futures::block_on;
use firmware_pile::{
    ChargingPile, Input, Outgoing, Parameters, Power, Sensors,
    plant::Plant,
    store::{Identity, Record, Report, Store},
    trust,
};
use protocol::{BootEpoch, Millis, Position, ReportId, Session, Sessions};

use crate::flash::{Flash, TEARS};
use crate::random::Random;

/// What the board has written down to be told.
#[derive(Default)]
pub struct Written {
    /// The last version of every report whose writing has ended.
    pub reports: BTreeMap<ReportId, Report>,
    /// Reports that were being written when the power went: they are there, or are not.
    pub under_way: Vec<Report>,
}

pub struct Board {
    pub core: ChargingPile,
    pub sessions: Sessions<[Session; trust::PEERS]>,
    pub plant: Plant,
    pub position: Position,
    pub written: Written,
    /// Reports that waited at the last start.
    pub waited: usize,
    identity: Identity,
    boot: BootEpoch,
    flash: Flash,
    store: Store<Flash>,
    started: u64,
}

impl Board {
    /// A board that was provisioned and is switched on now.
    pub fn new(identity: Identity, position: Position, now: u64) -> Self {
        let flash = Flash::new();
        let (mut store, kept) = block_on(Store::load(flash.clone(), 0)).unwrap();
        block_on(store.append(&Record::Identity(identity))).unwrap();
        let mut board = Self {
            core: ChargingPile::new(Parameters::new(identity.pile, 0.0)),
            sessions: trust::sessions(Some(&identity), kept.boot),
            plant: Plant::new(),
            position,
            written: Written::default(),
            waited: 0,
            identity,
            boot: kept.boot,
            flash,
            store,
            started: now,
        };
        board.restart(now);
        board
    }

    /// The power goes and comes.
    pub fn restart(&mut self, now: u64) {
        self.flash.repower();
        let (mut store, kept) = block_on(Store::load(self.flash.clone(), 0)).unwrap();
        assert!(kept.boot > self.boot, "a start has the number of an earlier one");
        assert_eq!(kept.identity, Some(self.identity));
        block_on(store.make_room()).unwrap();
        self.store = store;
        self.boot = kept.boot;
        self.started = now;
        self.waited = kept.journal.iter().flatten().count();
        self.sessions = trust::sessions(Some(&self.identity), kept.boot);
        self.core = ChargingPile::resume(Parameters::kept(self.identity, &kept), kept.journal);
        self.plant = Plant::new();
    }

    /// The power will go in one of the next writes, and tear it.
    pub fn cut_soon(&self, random: &mut Random) {
        self.flash.cut_at(random.below(60), TEARS[random.below(TEARS.len() as u64) as usize]);
    }

    /// Whether the power has gone.
    pub fn is_dead(&self) -> bool {
        !self.flash.powered()
    }

    /// As the board's task does it: the power first, then the store, then the messages.
    pub fn step(&mut self, now: u64, input: Input<'_>) -> Vec<Outgoing> {
        if self.is_dead() {
            return Vec::new();
        }
        let outputs = self.core.step(Millis(now - self.started), input);
        self.plant.command(outputs.power);
        let kept = outputs.store.iter().all(|record| self.keep(record));
        if !kept || (!self.core.energised() && block_on(self.store.make_room()).is_err()) {
            assert!(self.is_dead(), "the store fails under power");
            self.plant.command(Power::OFF);
            return Vec::new();
        }
        outputs.messages.into_iter().collect()
    }

    /// What the sensors say.
    pub fn sense(&mut self, now: u64) -> Sensors {
        self.plant.sense(Millis(now - self.started))
    }

    fn keep(&mut self, record: &Record) -> bool {
        let kept = block_on(self.store.append(record)).is_ok();
        if let Record::Waiting(_, report) = record {
            if kept {
                self.written.reports.insert(report.id(), report.clone());
            } else {
                self.written.under_way.push(report.clone());
            }
        }
        kept
    }
}
