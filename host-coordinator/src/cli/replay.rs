//! `chargehand replay`: what was known at an instant, and what another policy would have decided.

use std::{fmt, path::PathBuf, str::FromStr, sync::Arc};

use host_coordinator::{
    config::{Config, Policy, RobotConfig},
    core::{
        Coordinator, Decision, Event, State,
        replay::{Anew, Replay as Follower, Standing},
    },
    selection::PolicyName,
    site::Site,
    store::Store,
};
use jiff::Timestamp;
use protocol::{PileId, RobotId, SiteMillis};
use serde::Serialize;

use super::{Outcome, out, out_json, span::TimeSpan, table::table};

/// Decisions that are printed for a person.
const PRINTED: usize = 20;

/// Follow an event log: what was known at an instant, and what another policy would have decided
#[derive(clap::Args)]
pub struct Replay {
    /// The event log of a coordinator that does not run, or a copy of one
    #[arg(value_name = "LOG")]
    log: PathBuf,
    /// No further than this: a time such as 2026-11-25T14:30:00Z, milliseconds as in at_ms, or 30m after the
    /// log's first event; to its end if left out
    #[arg(long, value_name = "T")]
    until: Option<Until>,
    /// The coordinator's configuration, with its site, robots and policy
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Take every decision anew with this changed: theta=F, q_threshold=F or choose=POLICY
    #[arg(long, value_name = "KEY=VALUE", requires = "config")]
    what_if: Vec<WhatIf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// An instant of a log.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Until {
    At(SiteMillis),
    After(TimeSpan),
}

/// A change to a configuration's policy.
#[derive(Clone, Copy, Debug, PartialEq)]
enum WhatIf {
    Theta(f64),
    QThreshold(f64),
    Choose(PolicyName),
}

/// Why there is no replay.
#[derive(Debug, thiserror::Error)]
enum NoReplay {
    #[error("the event log {} has no event{}", log.display(), if *any { " until then: give a later --until" } else { "" })]
    Nothing { log: PathBuf, any: bool },
}

/// What is printed.
#[derive(Serialize)]
struct Report {
    events: usize,
    from_ms: SiteMillis,
    until_ms: SiteMillis,
    standing: Standing,
    #[serde(skip_serializing_if = "Option::is_none")]
    what_if: Option<Comparison>,
}

/// All decisions taken anew, with the policy as it is and as it might be.
#[derive(Serialize)]
struct Comparison {
    changed: Vec<String>,
    /// Decisions in the log.
    decisions: usize,
    /// Those of which the log does not tell enough, or of another site or fleet.
    untold: usize,
    /// Those that come out as in the log when nothing is changed.
    repeated: usize,
    /// Those that come out otherwise with the change.
    differ: Vec<Difference>,
}

#[derive(Serialize)]
struct Difference {
    id: u64,
    at_ms: SiteMillis,
    robot: RobotId,
    was: Pick,
    would_be: Pick,
}

/// A pile that was chosen, or none.
#[derive(Clone, Copy, PartialEq, Serialize)]
struct Pick {
    pile: Option<PileId>,
    /// The length of the way to it.
    cells: Option<f64>,
    /// The time from then until the robot would have worked again.
    away_s: Option<f64>,
}

impl Replay {
    pub fn run(self) -> Outcome {
        let mut events = Store::read_only(&self.log)?;
        let nothing = |any| NoReplay::Nothing { log: self.log.clone(), any };
        let from = events.first().ok_or_else(|| nothing(false))?.at;
        if let Some(until) = self.until {
            let until = until.after(from);
            // The site's clock may step back when a coordinator starts: the log's order counts.
            let end = events.iter().position(|event| event.at > until).unwrap_or(events.len());
            events.truncate(end);
        }
        let until = events.last().ok_or_else(|| nothing(true))?.at;
        let what_if = match &self.config {
            Some(config) if !self.what_if.is_empty() => {
                let (config, site) = Config::load(config)?;
                Some(compare(&events, site, &config, &self.what_if))
            }
            _ => None,
        };
        let standing = Standing::of(&State::fold(&events));
        let report = Report { events: events.len(), from_ms: from, until_ms: until, standing, what_if };
        if self.json { out_json(&report) } else { out(&report.to_string()) }
    }
}

fn compare(events: &[Event], site: Site, config: &Config, changes: &[WhatIf]) -> Comparison {
    let site = Arc::new(site);
    let mut changed = config.policy;
    changes.iter().for_each(|change| change.apply(&mut changed));
    let as_it_is = taken_anew(events, &site, config.policy, &config.robots);
    let as_it_might_be = taken_anew(events, &site, changed, &config.robots);
    let told = as_it_is.iter().zip(&as_it_might_be);
    let told: Vec<_> = told
        .filter_map(|(is, might)| Some((&is.was, is.would_be.as_ref()?, might.would_be.as_ref()?)))
        .collect();
    let differ = told.iter().filter(|(_, is, might)| is.chosen != might.chosen);
    let difference = |(was, is, might): &(&Decision, &Decision, &Decision)| Difference {
        id: was.id,
        at_ms: was.at_ms,
        robot: was.robot,
        was: Pick::of(is),
        would_be: Pick::of(might),
    };
    Comparison {
        changed: changes.iter().map(ToString::to_string).collect(),
        decisions: as_it_is.len(),
        untold: as_it_is.len() - told.len(),
        repeated: told.iter().filter(|(was, is, _)| was.chosen == is.chosen).count(),
        differ: differ.map(difference).collect(),
    }
}

fn taken_anew(events: &[Event], site: &Arc<Site>, policy: Policy, robots: &[RobotConfig]) -> Vec<Anew> {
    let coordinator = Coordinator::recover(Arc::clone(site), site.lmpp(1.0), policy, robots, []);
    let mut follower = Follower::new(coordinator);
    let mut anew: Vec<_> = events.iter().flat_map(|event| follower.follow(event)).collect();
    anew.extend(follower.finish());
    anew
}

impl Pick {
    fn of(decision: &Decision) -> Self {
        let row = decision.explanations.iter().find(|row| Some(row.pile) == decision.chosen);
        Self {
            pile: decision.chosen,
            cells: row.and_then(|row| row.distance),
            away_s: row.and_then(|row| row.times).map(|times| times.away_s()),
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { events, standing, .. } = self;
        writeln!(f, "{events} events from {} to {}", time(self.from_ms.0), time(self.until_ms.0))?;
        writeln!(
            f,
            "epoch {}; {} requests, {} charges completed, {} cut short, {:.0} kJ given; waited {:.0} s on \
             average, {:.0} s at most",
            standing.epoch,
            standing.asked,
            standing.charges_completed,
            standing.preempted,
            standing.energy_j / 1e3,
            standing.mean_wait_s,
            standing.worst_wait_s,
        )?;
        write!(f, "\n{}", piles(standing))?;
        if !standing.requests.is_empty() {
            write!(f, "\n\n{}", requests(standing))?;
        }
        if !standing.stranded.is_empty() {
            let stranded: Vec<_> = standing.stranded.iter().map(ToString::to_string).collect();
            write!(f, "\n\nstranded: {}", stranded.join(", "))?;
        }
        self.what_if.iter().try_for_each(|comparison| write!(f, "\n\n{comparison}"))
    }
}

fn piles(standing: &Standing) -> String {
    let rows: Vec<_> = standing
        .piles
        .iter()
        .map(|row| {
            let lease = row.lease.as_ref();
            [
                row.pile.to_string(),
                lease.map_or("-".to_owned(), |lease| lease.id.to_string()),
                lease.map_or("-".to_owned(), |lease| lease.robot.to_string()),
                lease.map_or("-".to_owned(), |lease| lease.phase.to_owned()),
                lease.map_or("-".to_owned(), |lease| time(lease.expiry_ms)),
                row.next.map_or("-".to_owned(), |robot| robot.to_string()),
                row.faults.join(", "),
            ]
        })
        .collect();
    table(["pile", "lease", "robot", "phase", "until", "next", "faults"], &[0, 1, 2], &rows)
}

fn requests(standing: &Standing) -> String {
    let rows: Vec<_> = standing
        .requests
        .iter()
        .map(|row| {
            [
                row.robot.to_string(),
                time(row.asked_at_ms),
                format!("{:.0}", row.energy_j),
                row.place.to_owned(),
                row.pile.map_or("-".to_owned(), |pile| pile.to_string()),
            ]
        })
        .collect();
    table(["robot", "asked at", "energy J", "place", "pile"], &[0, 2, 4], &rows)
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { decisions, untold, repeated, .. } = self;
        let told = decisions - untold;
        write!(f, "{repeated} of {told} decisions come out as in the log when nothing is changed")?;
        if *untold > 0 {
            write!(f, "; of {untold} more it does not tell enough, or the site or the fleet has changed")?;
        }
        let changed = self.changed.join(", ");
        write!(f, "\nwith {changed}, {} of {told} come out otherwise", self.differ.len())?;
        if self.differ.is_empty() {
            return Ok(());
        }
        let without = self.differ.iter().filter(|row| row.would_be.pile.is_none()).count();
        write!(f, "; in {without} of those the robot gets no pile then")?;
        let both = self.differ.iter().filter_map(|row| Some((row.was.away_s?, row.would_be.away_s?)));
        let both: Vec<_> = both.map(|(was, would_be)| would_be - was).collect();
        if !both.is_empty() {
            let mean_s = both.iter().sum::<f64>() / both.len() as f64;
            write!(f, "; where it gets another, it works again {mean_s:+.1} s later on average")?;
        }
        write!(f, "\n\n{}", differences(&self.differ))?;
        if let Some(more) = self.differ.len().checked_sub(PRINTED).filter(|more| *more > 0) {
            write!(f, "\nand {more} more: --json has them all")?;
        }
        Ok(())
    }
}

fn differences(differ: &[Difference]) -> String {
    let number = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.0}"));
    let pile = |pick: Pick| pick.pile.map_or("waits".to_owned(), |pile| format!("pile {pile}"));
    let rows: Vec<_> = differ
        .iter()
        .take(PRINTED)
        .map(|row| {
            [
                row.id.to_string(),
                time(row.at_ms.0),
                row.robot.to_string(),
                pile(row.was),
                pile(row.would_be),
                number(row.was.cells),
                number(row.would_be.cells),
                number(row.was.away_s),
                number(row.would_be.away_s),
            ]
        })
        .collect();
    let head = ["decision", "at", "robot", "is", "would be", "cells", "would be", "away s", "would be"];
    table(head, &[0, 2, 5, 6, 7, 8], &rows)
}

/// An instant of the site's clock for a person.
fn time(millis: u64) -> String {
    let instant = i64::try_from(millis).ok().and_then(|millis| Timestamp::from_millisecond(millis).ok());
    instant.map_or_else(|| format!("{millis} ms"), |instant| instant.to_string())
}

impl Until {
    fn after(self, from: SiteMillis) -> SiteMillis {
        match self {
            Self::At(instant) => instant,
            Self::After(TimeSpan(span)) => from.after(span),
        }
    }
}

impl FromStr for Until {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        if let Ok(span) = text.parse() {
            return Ok(Self::After(span));
        }
        let instant = text.parse::<Timestamp>().ok().and_then(|at| u64::try_from(at.as_millisecond()).ok());
        let millis = text.parse().ok().or(instant).map(SiteMillis);
        millis.map(Self::At).ok_or(
            "expected a time such as 2026-11-25T14:30:00Z, milliseconds as in at_ms, or a length such as 30m",
        )
    }
}

impl WhatIf {
    const fn apply(self, policy: &mut Policy) {
        match self {
            Self::Theta(theta) => policy.theta = theta,
            Self::QThreshold(q_threshold) => policy.q_threshold = q_threshold,
            Self::Choose(choose) => policy.choose = choose,
        }
    }
}

impl fmt::Display for WhatIf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Theta(theta) => write!(f, "theta={theta}"),
            Self::QThreshold(q_threshold) => write!(f, "q_threshold={q_threshold}"),
            Self::Choose(choose) => write!(f, "choose={choose}"),
        }
    }
}

impl FromStr for WhatIf {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (key, value) = text.split_once('=').unwrap_or((text, ""));
        match key {
            "theta" => Ok(Self::Theta(super::non_negative(value)?)),
            "q_threshold" => {
                let share = super::non_negative(value).ok().filter(|share| *share <= 1.0);
                share.map(Self::QThreshold).ok_or_else(|| "expected a number from 0 to 1".to_owned())
            }
            "choose" => value.parse().map(Self::Choose).map_err(|error| format!("{error}")),
            _ => Err("expected theta=F, q_threshold=F or choose=POLICY".to_owned()),
        }
    }
}
