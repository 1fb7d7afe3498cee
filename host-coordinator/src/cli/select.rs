//! `chargehand select`: which pile should a robot use, and why?

use std::{fs, path::PathBuf};

use host_coordinator::{
    selection::{Choice, Rule, choose},
    site::Site,
};

use super::{Outcome, out, out_json, plan::free_cell, point::Point, table::table};

/// Choose a pile for a robot and explain the choice
///
/// The site file says which piles are free and how far the charges on the others are.
#[derive(clap::Args)]
pub struct Select {
    /// The folder of the site
    #[arg(long, value_name = "DIR")]
    site: PathBuf,
    /// Where the robot is, in the site's coordinates
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true)]
    robot: Point,
    /// How far it gets with what is left in its battery, in cells
    #[arg(long, value_name = "F", allow_hyphen_values = true, value_parser = super::non_negative)]
    reach: f64,
    /// How likely it is active near each pile after the charge, in the order of the piles'
    /// numbers: a list such as 0.5,0.2,0.3 or a file with one; equal if left out
    #[arg(long, value_name = "FILE|LIST", allow_hyphen_values = true)]
    probabilities: Option<String>,
    /// Choose as the paper prints the rule, if need be beyond the robot's reach
    #[arg(long)]
    literal: bool,
    /// A charge this far done counts as almost done; the paper's value if left out
    #[arg(long, value_name = "F", default_value_t = 0.1, value_parser = super::non_negative)]
    q_threshold: f64,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// What is wrong with the probabilities.
#[derive(Debug, thiserror::Error)]
enum BadProbabilities {
    #[error(
        "probabilities {text:?} are neither a list such as 0.5,0.2,0.3 nor a file that can be read ({cause}): give one of them"
    )]
    Unreadable { text: String, cause: std::io::Error },
    #[error("probability {position} is {text:?}: give a number from 0 to 1")]
    NotOne { position: usize, text: String },
    #[error("{found} probabilities for {piles} piles: give one for each pile")]
    Count { found: usize, piles: usize },
}

impl Select {
    pub fn run(self) -> Outcome {
        let site = Site::load(&self.site)?;
        let robot = free_cell(&site.grid, site.frame, self.robot)?;
        let probabilities = self.probabilities(site.piles.len())?;
        let rule = if self.literal { Rule::PaperLiteral } else { Rule::Corrected };
        let lmpp = site.lmpp(1.0);
        let survey = lmpp.survey(robot)?;
        let candidates = site.candidates(&survey, &probabilities, rule);
        let choice = choose(&candidates, self.reach, self.q_threshold, rule);
        if self.json { out_json(&choice) } else { out(&text(&choice)) }
    }

    fn probabilities(&self, piles: usize) -> Result<Vec<f64>, BadProbabilities> {
        let Some(given) = &self.probabilities else { return Ok(vec![1.0 / piles.max(1) as f64; piles]) };
        let is_list = given.split(',').all(|field| field.trim().parse::<f64>().is_ok());
        let text = if is_list {
            given.clone()
        } else {
            fs::read_to_string(given)
                .map_err(|cause| BadProbabilities::Unreadable { text: given.clone(), cause })?
        };
        let probabilities = (1..)
            .zip(text.split([',', ' ', '\t', '\r', '\n']).filter(|field| !field.is_empty()))
            .map(|(position, field)| match field.parse() {
                Ok(probability) if (0.0..=1.0).contains(&probability) => Ok(probability),
                _ => Err(BadProbabilities::NotOne { position, text: field.chars().take(40).collect() }),
            })
            .collect::<Result<Vec<_>, _>>()?;
        if probabilities.len() == piles {
            Ok(probabilities)
        } else {
            Err(BadProbabilities::Count { found: probabilities.len(), piles })
        }
    }
}

fn text(choice: &Choice) -> String {
    let chosen = choice.chosen.map_or("no pile".into(), |pile| format!("pile {pile}"));
    let number = |number: Option<f64>| number.map_or("-".into(), |number| format!("{number:.3}"));
    let rows: Vec<_> = choice
        .explanations
        .iter()
        .map(|row| {
            let stage = row.stage.name().replace('_', " ");
            let probability = format!("{:.3}", row.probability);
            let distance = row.distance.map_or("-".into(), |distance| format!("{distance:.2}"));
            let fields = [row.pile.to_string(), stage, distance, probability];
            let [pile, stage, distance, probability] = fields;
            [pile, stage, distance, probability, number(row.score), row.verdict.to_string()]
        })
        .collect();
    let head = ["pile", "state", "distance", "p", "score", "why"];
    format!("{chosen}: {}\n\n{}", choice.stage, table(head, &[0, 2, 3, 4], &rows))
}
