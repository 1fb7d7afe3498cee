//! A whole site in one pure computation, made to break: `chargehand simulate`.
//!
//! The real coordinator core, the real pile cores with models of their chargers and stores, and robots
//! with tasks live through hours in a fraction of a second: nothing is stepped but what something
//! happens to ([`agenda`]). What can go wrong does ([`faults`]), and after every step the system's
//! promises are checked ([`breach`], [`watch`]). Everything follows from a seed.
//!
//! # What is as on a real site, and what is not
//! - Frames go by value and are not sealed, but sessions follow the rules of sealed ones ([`network`]).
//! - A pile's store keeps every record or does not, as `firmware-pile`'s store does, which is tested
//!   where it is, word by word.
//! - A pile with nobody at its contacts is stepped once a second, or when it hears something; one with a
//!   robot at its contacts reads its sensors every 100 ms and its reader twice a second. On a board all
//!   of this happens more often: what an idle pile does by its own timers may come up to a second later
//!   here.
//! - Piles gossip to robots that wait, who alone listen, and not to each other: every robot hears every pile, and no
//!   pile decides by what it hears of others.
//!
//! | module | one idea |
//! |---|---|
//! | [`agenda`] | what is to happen when |
//! | [`faults`] | what can go wrong, and when it does |
//! | [`network`] | frames on their way |
//! | [`body`] | where a robot is and what its battery holds |
//! | [`breach`] | the promises, and how each can be broken |
//! | [`watch`] | whether a pile keeps its promises |
//! | `office` | the coordinator, its log and its clock |
//! | `piles` | piles: firmware core, charger, store |
//! | `rovers` | robots: computer and body |
//! | `help` | mobile chargers that charge robots, and people who tow them |
//! | `run` | all of them, from one event to the next |
//! | [`outcome`] | what a run comes to |
//! | [`campaign`] | many runs on all processors |
//! | [`comparison`] | two policies on the same seeds |
//! | [`shrink`] | the smallest run that still fails |

use std::{ops::Range, sync::Arc};

use planning::grid::Cell;
use protocol::{DurationMs, PileId, RobotId};

use super::{fleet::Model, ground::Point, terrain::Terrain};
use crate::{
    config::{Policy, RobotConfig},
    core::Coordinator,
    site::Site,
};

pub mod agenda;
pub mod body;
pub mod breach;
pub mod campaign;
pub mod comparison;
pub mod faults;
mod help;
pub mod network;
mod office;
pub mod outcome;
mod piles;
mod rovers;
mod run;
pub mod shrink;
#[cfg(test)]
mod tests;
pub mod watch;

use faults::Faults;
use outcome::Outcome;

/// The robots: they need a charge about every half an hour, so that 50 of them use 13 piles of 500 W for
/// some 60 % of the time. Rushes come by chance, and three robots in ten consume more than anybody
/// believes, so a robot asks early enough to wait for five minutes.
const MODEL: Model =
    Model { full_j: 120_000.0, drive_j_per_m: 60.0, idle_w: 30.0, speed_mps: 0.8, reserve_s: 300.0 };

/// The mobile chargers: robots with a large battery, most of which is for others.
const CHARGER: Model = Model { full_j: 600_000.0, ..MODEL };

/// Which run: everything that happens in it follows from this and its [`Ground`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trial {
    /// Another seed gives another run.
    pub seed: u64,
    /// How many robots there are; no more than the ground has.
    pub robots: u16,
    /// How long it lasts.
    pub duration: DurationMs,
    /// What can go wrong.
    pub faults: Faults,
    /// Which of the faults that strike happen, by their numbers.
    pub only: Range<u64>,
}

impl Trial {
    /// What becomes of it on `ground`.
    #[must_use]
    pub fn run(&self, ground: &Ground) -> Outcome {
        run::Run::new(ground, self).outcome()
    }
}

/// A site and its fleet, as they are before any run; shared by all.
#[derive(Debug)]
pub struct Ground {
    terrain: Arc<Terrain>,
    /// A coordinator that has not started yet.
    coordinator: Coordinator,
    robots: u16,
    chargers: u16,
    alert_j: f64,
    /// No more power than this may go to all piles together, in watts.
    power_cap_w: Option<f64>,
    piles: Vec<(PileId, f32, Point)>,
    doors: Vec<(Point, f64)>,
}

impl Ground {
    /// `site` with so many robots and mobile chargers, and a coordinator that decides by `policy`.
    #[must_use]
    pub fn new(site: &Arc<Site>, policy: Policy, robots: u16, chargers: u16) -> Self {
        let point = |cell: Cell| Point::from(site.position(cell));
        let of_chargers = (robots.saturating_add(1)..=robots.saturating_add(chargers))
            .map(|id| RobotConfig { gives_w: Some(help::GIVES_W as f32), ..CHARGER.config(RobotId(id)) });
        let configs = (1..=robots).map(|id| MODEL.config(RobotId(id))).chain(of_chargers);
        let configs: Vec<_> = configs.collect();
        let congestion =
            |door| site.congestion.iter().find(|(id, _)| *id == door).map_or(0.0, |(_, rho)| *rho);
        let doors = site.rooms.doors().iter().map(|door| (point(door.cell), congestion(door.id)));
        Self {
            terrain: Arc::new(Terrain::new(site)),
            coordinator: Coordinator::recover(Arc::clone(site), site.lmpp(1.0), policy, &configs, []),
            robots,
            power_cap_w: policy.power_cap_w,
            chargers,
            alert_j: MODEL.alert(site).get().into(),
            piles: site.piles.iter().map(|pile| (pile.id, pile.power_w, point(pile.cell))).collect(),
            doors: doors.collect(),
        }
    }

    /// How many robots there are.
    #[must_use]
    pub const fn robots(&self) -> u16 {
        self.robots
    }

    fn pile_index(&self, id: PileId) -> Option<usize> {
        self.piles.iter().position(|(known, ..)| *known == id)
    }
}
