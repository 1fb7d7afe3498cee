//! `chargehand reproduce`: do the papers' tables come out?

use std::{
    fs, io,
    io::IsTerminal as _,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use host_coordinator::reproduce::{Paper, Row, Verdict, chosen, figure::Figure, render};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;

use super::{Outcome, out, out_json, table::table};

/// Compute the papers' tables again and compare them with what is printed
///
/// The maps of LMPP's Fig. 7 and Access's Fig. 3 are lost; they were reconstructed from the printed
/// lengths, so that their match is a fit and no independent test.
#[derive(clap::Args)]
pub struct Reproduce {
    /// One paper, such as lmpp; all if left out
    #[arg(long, value_name = "NAME")]
    paper: Option<String>,
    /// One table or experiment, such as 5 or "Experiment 1"; all if left out
    #[arg(long, value_name = "NAME")]
    table: Option<String>,
    /// Draw what the papers' experiments draw into this folder, as SVG and PNG
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// What the notes on door sets mean.
const DOORS: [(&str, &str); 2] = [
    ("doors as drawn", "each subarea has its own doors"),
    (
        "doors as run",
        "what the lengths of Tests 3 and 4 demand: the hall also offers doors 1 and 2 and links them to \
         door 4, the corridor offers doors 3 and 7 only",
    ),
];

/// A picture could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{} cannot be written ({cause}): give --plots a folder that can be", file.display())]
struct Unwritable {
    file: PathBuf,
    cause: io::Error,
}

#[derive(Serialize)]
struct Report {
    rows: Vec<Row>,
    /// The pictures that were written.
    files: Vec<PathBuf>,
}

impl Reproduce {
    pub fn run(self) -> Outcome {
        let chosen = chosen(self.paper.as_deref(), self.table.as_deref())?;
        let tables: usize = chosen.iter().map(|(_, tables)| tables.len()).sum();
        let drawn = if self.plots.is_some() { chosen.len() } else { 0 };
        let mut progress = Progress::new(tables + drawn);
        let mut report = Report { rows: Vec::new(), files: Vec::new() };
        for (paper, tables) in &chosen {
            for table in tables {
                progress.show(&format!("{}: {table}", paper.name));
                report.rows.extend((paper.rows)(table)?);
            }
            if let Some(folder) = &self.plots {
                progress.show(&format!("{}: figures", paper.name));
                for figure in (paper.figures)()? {
                    report.files.extend(draw(folder, &figure)?);
                }
            }
        }
        progress.clear();
        if self.json {
            return out_json(&report);
        }
        out(&text(&report.rows, &chosen.iter().map(|&(paper, _)| paper).collect::<Vec<_>>()))?;
        report.files.iter().try_for_each(|file| out(&format!("written {}", file.display())))
    }
}

/// Draws `figure` into `folder`; the answer is the files.
fn draw(folder: &Path, figure: &Figure) -> Result<[PathBuf; 2], Box<dyn std::error::Error>> {
    let write = |ending: &str, content: &[u8]| {
        let file = folder.join(format!("{}.{ending}", figure.name));
        let written = fs::create_dir_all(folder).and_then(|()| fs::write(&file, content));
        written.map(|()| file.clone()).map_err(|cause| Unwritable { file, cause })
    };
    let svg = write("svg", render::svg(figure)?.as_bytes())?;
    Ok([svg, write("png", &render::png(figure)?)?])
}

/// A bar on a terminal, once it takes a while.
struct Progress {
    bar: ProgressBar,
    begun: Instant,
}

impl Progress {
    const PATIENCE: Duration = Duration::from_secs(1);

    fn new(steps: usize) -> Self {
        let bar = ProgressBar::with_draw_target(Some(steps as u64), ProgressDrawTarget::hidden());
        // The template is ours; should it be wrong, indicatif's own does.
        let style = ProgressStyle::with_template("{bar:24.green} {pos}/{len} {msg}")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        Self { bar: bar.with_style(style), begun: Instant::now() }
    }

    fn show(&mut self, now: &str) {
        if self.bar.is_hidden() && self.begun.elapsed() > Self::PATIENCE && io::stderr().is_terminal() {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
        self.bar.set_message(now.to_owned());
        self.bar.inc(1);
    }

    fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

fn text(rows: &[Row], papers: &[&Paper]) -> String {
    let fields = |row: &Row| {
        let Row { paper, table, row: name, column, published, verdict, note, .. } = row;
        let ours = row.ours_as_printed();
        let (published, verdict) = (published.to_string(), verdict.to_string());
        let (paper, table) = ((*paper).to_owned(), (*table).to_owned());
        [paper, table, name.clone(), column.clone(), published, ours, verdict, note.clone()]
    };
    let fields: Vec<_> = rows.iter().map(fields).collect();
    let head = ["paper", "table", "row", "column", "published", "ours", "verdict", "note"];
    let table = table(head, &[4, 5], &fields);
    let mut lines = table.lines();
    let mut text: Vec<String> = lines.by_ref().take(2).map(str::to_owned).collect();
    text.extend(lines.zip(rows).map(|(line, row)| coloured(line, row.verdict)));
    text.push(String::new());
    text.extend(
        DOORS
            .iter()
            .filter(|(set, _)| rows.iter().any(|row| row.note.contains(set)))
            .map(|(set, meaning)| format!("{set}: {meaning}")),
    );
    text.extend(papers.iter().map(|paper| summary(rows, paper.name)));
    text.join("\n")
}

/// How many rows of a paper have which verdict.
fn summary(rows: &[Row], paper: &str) -> String {
    let of_paper = || rows.iter().filter(|row| row.paper == paper);
    let count = |verdict| of_paper().filter(|row| row.verdict == verdict).count();
    format!(
        "{paper}: {} rows, {} exact, {} close, {} differ, {} not comparable",
        of_paper().count(),
        count(Verdict::Exact),
        count(Verdict::Close),
        count(Verdict::Differs),
        count(Verdict::NotComparable),
    )
}

fn coloured(line: &str, verdict: Verdict) -> String {
    let colour = match verdict {
        Verdict::Exact => return line.to_owned(),
        Verdict::Close => "\x1b[33m",
        Verdict::Differs => "\x1b[31m",
        Verdict::NotComparable => "\x1b[2m",
    };
    format!("{colour}{line}\x1b[0m")
}
