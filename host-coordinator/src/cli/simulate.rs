//! `chargehand simulate`.

use std::{
    error::Error,
    io::{IsTerminal as _, Write as _},
    ops::Range,
    path::PathBuf,
    sync::Arc,
    time::Instant,
};

use clap::Args;
use host_coordinator::{
    config::Policy,
    selection::policy::{NoPolicy, PolicyName},
    simulate::trial::{
        Ground, Trial, campaign, comparison,
        faults::Faults,
        outcome::{Figures, Outcome as Run},
        shrink::{self, Case},
    },
    site::Site,
};
use indicatif::{ProgressBar, ProgressStyle};
use protocol::DurationMs;
use serde::Serialize;

use super::{Outcome, out, out_json, table::table};

/// So many runs are shown one by one.
const SHOWN: usize = 20;
/// An hour in milliseconds.
const HOUR_MS: f64 = 3_600_000.0;

/// Run a whole site as a pure computation, with faults, and check what is promised after every step
#[derive(Args)]
pub struct Simulate {
    /// How piles are chosen: joint, lmpp, lmpp-literal, access or nearest
    #[arg(long, value_name = "NAME", default_value_t, conflicts_with = "compare")]
    policy: PolicyName,
    /// Run every seed under two policies and print how the second differs from the first, with 95 %
    /// confidence intervals
    #[arg(long, value_name = "A,B", value_parser = pair)]
    compare: Option<(PolicyName, PolicyName)>,
    /// How many robots there are
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u16).range(1..=2_000))]
    robots: u16,
    /// How many mobile chargers there are
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(0..=100))]
    chargers: u16,
    /// Only the first so many piles of the site [default: all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    piles: Option<u16>,
    /// The facility's power for all piles together, in watts [default: enough for all]
    #[arg(long, value_name = "W", value_parser = super::non_negative)]
    power_cap: Option<f64>,
    /// How many hours pass in a run
    #[arg(long, value_name = "H", default_value_t = 1.0, value_parser = hours)]
    hours: f64,
    /// What goes wrong: none, all, or some of loss, delay, duplicate, reorder, partition, pile-crash,
    /// robot-crash, coordinator-crash, clock, with commas between; outage is not one of all: all,outage
    #[arg(long, value_name = "LIST", default_value = "all")]
    faults: Faults,
    /// Let only those faults happen whose numbers are from A up to, not including, B; a failing run prints
    /// which it needs
    #[arg(long, value_name = "A..B", value_parser = span)]
    only_faults: Option<Range<u64>>,
    /// The seed of the first run
    #[arg(long, value_name = "S", default_value_t = 1)]
    first_seed: u64,
    /// How many runs, each with the next seed
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..))]
    seeds: u64,
    /// The folder of the site [default: LMPP's Fig. 7, built in]
    #[arg(long, value_name = "DIR")]
    site: Option<PathBuf>,
    /// Print the figures as JSON
    #[arg(long)]
    json: bool,
}

/// Some runs broke what the system promises.
#[derive(Debug, thiserror::Error)]
#[error("{failed} of {runs} runs broke a promise of the system; above is how to repeat the first of them")]
struct Broken {
    failed: usize,
    runs: u64,
}

/// All figures, for programs.
#[derive(Serialize)]
struct Report {
    runs: Vec<Figures>,
    sum: Figures,
    violations: Vec<Violation>,
}

/// A run that was broken off.
#[derive(Serialize)]
struct Violation {
    seed: u64,
    at_s: f64,
    what: String,
}

impl Simulate {
    pub fn run(self) -> Outcome {
        let site = Arc::new(self.site()?);
        let first = Trial {
            seed: self.first_seed,
            robots: self.robots,
            duration: DurationMs::saturating((self.hours * HOUR_MS).round() as u64),
            faults: self.faults,
            only: self.only_faults.clone().unwrap_or(0..u64::MAX),
        };
        if let Some((one, other)) = self.compare {
            return self.print_comparison(&site, &first, [one, other]);
        }
        let (ground, outcomes) = self.outcomes(&site, &first, self.policy);
        if self.json {
            out_json(&report(&outcomes, self.first_seed))?;
        } else {
            out(&text(&outcomes, self.first_seed))?;
        }
        self.judge(&ground, &first, self.policy, &outcomes)
    }

    /// Runs all seeds under a policy.
    fn outcomes(&self, site: &Arc<Site>, first: &Trial, policy: PolicyName) -> (Ground, Vec<Run>) {
        let policy = Policy { choose: policy, power_cap_w: self.power_cap, ..Policy::default() };
        let ground = Ground::new(site, policy, self.robots, self.chargers);
        let begun = Instant::now();
        let bar = bar(self.seeds);
        let outcomes = campaign::run(&ground, first, self.seeds, |_| bar.inc(1));
        bar.finish_and_clear();
        if !self.json {
            let (simulated_h, real_s) = (self.hours * self.seeds as f64, begun.elapsed().as_secs_f64());
            say(&format!("{}: {simulated_h:.1} simulated hours in {real_s:.1} s", policy.choose));
        }
        (ground, outcomes)
    }

    fn print_comparison(&self, site: &Arc<Site>, first: &Trial, policies: [PolicyName; 2]) -> Outcome {
        let [(one, ones), (other, others)] = policies.map(|policy| self.outcomes(site, first, policy));
        let rows = comparison::rows(&ones, &others);
        if self.json {
            out_json(&rows)?;
        } else {
            let [one, other] = policies.map(PolicyName::name);
            let head = ["mean of all seeds", one, other, "difference", "95 % from", "to"];
            let cells: Vec<_> = rows
                .iter()
                .map(|row| {
                    let [first, second, difference, low, high] =
                        [row.first, row.second, row.difference, row.low, row.high]
                            .map(|value| format!("{value:.4}"));
                    [row.figure.to_owned(), first, second, difference, low, high]
                })
                .collect();
            out(&table(head, &[1, 2, 3, 4, 5], &cells))?;
        }
        let [first_policy, second_policy] = policies;
        self.judge(&one, first, first_policy, &ones)?;
        self.judge(&other, first, second_policy, &others)
    }

    fn site(&self) -> Result<Site, Box<dyn Error>> {
        let mut site = match &self.site {
            Some(folder) => Site::load(folder)?,
            None => Site::fig7()?,
        };
        site.piles.truncate(self.piles.map_or(usize::MAX, usize::from));
        Ok(site)
    }

    /// Says which runs have failed, and how the first of them can be repeated in small.
    fn judge(&self, ground: &Ground, first: &Trial, policy: PolicyName, outcomes: &[Run]) -> Outcome {
        let failed: Vec<_> =
            outcomes.iter().filter_map(|run| Some((run.seed, run.failure.as_ref()?))).collect();
        for (seed, failure) in failed.iter().take(SHOWN) {
            let at_s = failure.at.0 as f64 / 1e3;
            say(&format!("seed {seed}, {at_s:.3} s: {}", failure.breach));
        }
        let Some(&(seed, failure)) = failed.first() else { return Ok(()) };
        let case = Case::new(Trial { seed, ..first.clone() }, failure.clone());
        say(&format!("repeat seed {seed}: {}", self.command(&case.trial, policy)));
        let smallest = case.shrunk(|trial| shrink::failure(ground, trial));
        say(&format!(
            "smallest run found that fails in the same way: {}\n  {}",
            smallest.failure.breach,
            self.command(&smallest.trial, policy)
        ));
        Err(Box::new(Broken { failed: failed.len(), runs: self.seeds }))
    }

    /// The command line of a trial.
    fn command(&self, trial: &Trial, policy: PolicyName) -> String {
        let Trial { seed, robots, duration, faults, only } = trial;
        let hours = f64::from(duration.0) / HOUR_MS;
        let mut command = format!(
            "chargehand simulate --policy {policy} --first-seed {seed} --seeds 1 --robots {robots} --hours {hours} \
             --faults {faults}"
        );
        if self.chargers != 1 {
            command += &format!(" --chargers {}", self.chargers);
        }
        if only.end != u64::MAX {
            command += &format!(" --only-faults {}..{}", only.start, only.end);
        }
        if let Some(piles) = self.piles {
            command += &format!(" --piles {piles}");
        }
        if let Some(power_cap_w) = self.power_cap {
            command += &format!(" --power-cap {power_cap_w}");
        }
        if let Some(site) = &self.site {
            command += &format!(" --site {}", site.display());
        }
        command
    }
}

fn hours(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(hours) if hours > 0.0 && hours <= 240.0 => Ok(hours),
        _ => Err("hours are a number above 0, up to 240".to_owned()),
    }
}

fn pair(text: &str) -> Result<(PolicyName, PolicyName), String> {
    let (one, other) =
        text.split_once(',').ok_or("two policies have a comma between them, such as nearest,joint")?;
    let read = |name: &str| name.trim().parse().map_err(|error: NoPolicy| error.to_string());
    Ok((read(one)?, read(other)?))
}

fn span(text: &str) -> Result<Range<u64>, String> {
    let span = text.split_once("..").and_then(|(start, end)| Some(start.parse().ok()?..end.parse().ok()?));
    span.ok_or_else(|| "a span is two numbers with two dots between, such as 10..12".to_owned())
}

/// Tells a person; standard output is for the figures.
fn say(text: &str) {
    // Nothing is left to do where even standard error is closed.
    let _ = writeln!(anstream::stderr(), "{text}");
}

fn bar(runs: u64) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    // The template is ours; should it be wrong, indicatif's own does.
    let style = ProgressStyle::with_template("{bar:24.green} {pos} of {len} runs, {eta} left")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(runs).with_style(style)
}

fn report(outcomes: &[Run], first_seed: u64) -> Report {
    let violation = |run: &Run| {
        let failure = run.failure.as_ref()?;
        let at_s = failure.at.0 as f64 / 1e3;
        Some(Violation { seed: run.seed, at_s, what: failure.breach.to_string() })
    };
    Report {
        runs: outcomes.iter().map(|run| run.tally.figures(run.seed)).collect(),
        sum: campaign::sum(outcomes).figures(first_seed),
        violations: outcomes.iter().filter_map(violation).collect(),
    }
}

fn text(outcomes: &[Run], first_seed: u64) -> String {
    const HEAD: [&str; 14] = [
        "seed",
        "requests",
        "granted",
        "completed",
        "preempted",
        "double",
        "lost",
        "stranded, reachable",
        "other",
        "rescued",
        "towed",
        "wait p50 s",
        "p99 s",
        "working",
    ];
    let row = |name: String, figures: Figures| {
        [
            name,
            figures.counts.requests.to_string(),
            figures.counts.granted.to_string(),
            figures.counts.completed.to_string(),
            figures.counts.preempted.to_string(),
            figures.counts.double_grants.to_string(),
            figures.counts.lost_requests.to_string(),
            figures.counts.stranded_reachable.to_string(),
            figures.counts.stranded_unreachable.to_string(),
            figures.counts.rescued.to_string(),
            figures.counts.towed.to_string(),
            format!("{:.1}", figures.wait_s.p50),
            format!("{:.1}", figures.wait_s.p99),
            format!("{:.1} %", 100.0 * figures.working_share),
        ]
    };
    let shown = if outcomes.len() <= SHOWN { outcomes } else { &[] };
    let mut rows: Vec<_> =
        shown.iter().map(|run| row(run.seed.to_string(), run.tally.figures(run.seed))).collect();
    let sum = campaign::sum(outcomes).figures(first_seed);
    rows.push(row(format!("all {}", outcomes.len()), sum));
    let distance_km = sum.counts.charge_distance_m / 1e3;
    let columns: Vec<usize> = (1..HEAD.len()).collect();
    let steps = sum.counts.coordinator_steps;
    let table = table(HEAD, &columns, &rows);
    format!("{table}\n{distance_km:.1} km driven to charge, {steps} steps of the coordinator")
}
