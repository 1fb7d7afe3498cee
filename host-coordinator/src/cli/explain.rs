//! `chargehand explain`: why was that pile chosen?

use std::{
    error::Error,
    path::{Path, PathBuf},
    time::Duration,
};

use host_coordinator::{
    core::{Decision, Fact, decision::Explanation},
    store::Store,
};

use super::{Outcome, out, out_json, table::table};

/// How long a coordinator may take to answer.
const PATIENCE: Duration = Duration::from_secs(10);

/// Explain a decision: what every pile would have cost, and what would have changed it
#[derive(clap::Args)]
pub struct Explain {
    /// The number of the decision, as the dashboard and the API show it
    #[arg(value_name = "ID")]
    id: u64,
    /// The coordinator that made it
    #[arg(long, value_name = "URL", default_value = "http://127.0.0.1:8480", conflicts_with = "log")]
    url: String,
    /// The event log of a coordinator that does not run
    #[arg(long, value_name = "FILE")]
    log: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Why there is no explanation.
#[derive(Debug, thiserror::Error)]
enum Unexplained {
    #[error("{url} has no decision {id}: see GET /api/v1/state for the newest ones")]
    NoneThere { url: String, id: u64 },
    #[error("the event log {} has no decision {id}{}", file.display(), newest.map_or_else(
        || ": it has none at all".to_owned(),
        |newest| format!("; its newest is {newest}"),
    ))]
    NoneInLog { file: PathBuf, id: u64, newest: Option<u64> },
    #[error(
        "{url} does not answer ({cause}): is a coordinator running there? Else name its event log with --log"
    )]
    Silent { url: String, cause: String },
}

impl Explain {
    pub fn run(self) -> Outcome {
        let decision = match &self.log {
            Some(file) => self.read_log(file)?,
            None => self.ask_coordinator()?,
        };
        if self.json { out_json(&decision) } else { out(&text(&decision)) }
    }

    fn read_log(&self, file: &Path) -> Result<Decision, Box<dyn Error>> {
        let decisions = Store::read_only(file)?.into_iter().filter_map(|event| match event.fact {
            Fact::Decided(decision) => Some(decision),
            _ => None,
        });
        let mut newest = None;
        for decision in decisions {
            if decision.id == self.id {
                return Ok(decision);
            }
            newest = Some(decision.id);
        }
        Err(Unexplained::NoneInLog { file: file.to_owned(), id: self.id, newest }.into())
    }

    fn ask_coordinator(&self) -> Result<Decision, Unexplained> {
        let Self { url, id, .. } = self;
        let silent = |cause: String| Unexplained::Silent { url: url.clone(), cause };
        let config = ureq::Agent::config_builder().timeout_global(Some(PATIENCE));
        let agent: ureq::Agent = config.build().into();
        let address = format!("{}/api/v1/decisions/{id}", url.trim_end_matches('/'));
        match agent.get(&address).call() {
            Ok(mut answer) => {
                let body = answer.body_mut().read_to_string().map_err(|error| silent(error.to_string()))?;
                serde_json::from_str(&body)
                    .map_err(|error| silent(format!("its answer is no decision: {error}")))
            }
            Err(ureq::Error::StatusCode(404)) => Err(Unexplained::NoneThere { url: url.clone(), id: *id }),
            Err(error) => Err(silent(error.to_string())),
        }
    }
}

fn text(decision: &Decision) -> String {
    let Decision { id, robot, request, chosen, policy, stage, .. } = decision;
    let chosen = chosen.map_or("waits".to_owned(), |pile| format!("goes to pile {pile}"));
    let head = format!(
        "decision {id}: robot {robot} {chosen} ({policy}: {})\n\
         request {request}, after {:.0} s of waiting; urgency {:.2}; it gets {:.1} cells far, surely {:.1}\n",
        stage.replace('_', " "),
        decision.waited_s,
        decision.urgency,
        decision.reach,
        decision.sure_reach
    );
    let seconds = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.0}"));
    let mut rows: Vec<&Explanation> = decision.explanations.iter().collect();
    rows.sort_by_key(|row| (Some(row.pile) != decision.chosen, row.pile));
    let rows: Vec<_> = rows
        .into_iter()
        .map(|row| {
            let times = row.times;
            [
                row.pile.to_string(),
                row.distance.map_or("-".to_owned(), |distance| format!("{distance:.1}")),
                format!("{:.2}", row.probability),
                seconds(times.map(|times| times.way_s())),
                seconds(times.map(|times| times.wait_s())),
                seconds(times.map(|times| times.charge_s)),
                seconds(times.map(|times| times.back_s)),
                row.score.map_or_else(
                    || seconds(times.map(|times| times.away_s())),
                    |score| format!("{score:.3}"),
                ),
                row.unless.as_ref().map_or_else(
                    || row.reason.clone(),
                    |unless| format!("{}; could be chosen {unless}", row.reason),
                ),
            ]
        })
        .collect();
    let of = if decision.explanations.iter().any(|row| row.score.is_some()) { "score" } else { "away s" };
    let columns = ["pile", "cells", "p", "way s", "wait s", "charge s", "back s", of, "why"];
    format!("{head}\n{}", table(columns, &[0, 1, 2, 3, 4, 5, 6, 7], &rows))
}
