//! `chargehand check`: is a configuration ready to run?

use std::path::PathBuf;

use host_coordinator::config::Config;
use serde_json::json;

use super::{Outcome, out, out_json};

/// Check a configuration and its site and report every mistake with file and line
#[derive(clap::Args)]
pub struct Check {
    /// The configuration that `chargehand run` would get
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
    /// Print the mistakes as JSON
    #[arg(long)]
    json: bool,
}

impl Check {
    pub fn run(self) -> Outcome {
        let checked = Config::load(&self.config);
        if self.json {
            let mistakes = checked.as_ref().map_or_else(|found| found.mistakes(), |_| &[]);
            out_json(&json!({ "ready": mistakes.is_empty(), "mistakes": mistakes }))?;
        }
        let (config, site) = checked?;
        if self.json {
            return Ok(());
        }
        let has_others = site.rooms.subareas().iter().count() > 1;
        let cut_off = site.piles.iter().filter(|pile| has_others && !site.has_door_to(pile));
        for pile in cut_off {
            out(&format!(
                "pile {} is in a subarea without a door: robots elsewhere will not use it",
                pile.id
            ))?;
        }
        out(&format!(
            "{} is ready to run: {} robots on \"{}\", a site of {} piles and {} doors",
            self.config.display(),
            config.robots.len(),
            site.name,
            site.piles.len(),
            site.rooms.doors().len(),
        ))
    }
}
