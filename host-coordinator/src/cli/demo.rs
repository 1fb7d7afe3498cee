//! `chargehand demo`.

use std::{
    io::{IsTerminal as _, Write as _},
    time::Instant,
};

use clap::Args;
use host_coordinator::{
    config::Listen,
    simulate::demo::{Demo as Site, Options, Progress},
};
use indicatif::{ProgressBar, ProgressStyle};
use protocol::{Activity, DurationMs, Millis};
use tokio::runtime::Runtime;

use super::{Outcome, out, out_json, span::TimeSpan, stop::stop_signal};

/// Where no progress bar can be shown, a line is printed after this much simulated time.
const LINE_EVERY: DurationMs = DurationMs(300_000);

/// Run a whole site on this computer: coordinator, 13 piles and 10 robots on the map of LMPP's Fig. 7
#[derive(Args)]
pub struct Demo {
    /// How many simulated seconds pass in a real one
    #[arg(long, value_name = "N", default_value_t = 20.0, value_parser = speed)]
    speed: f64,
    /// End after this simulated time, such as 90s, 30m or 2h [default: at Ctrl-C]
    #[arg(long, value_name = "TIME")]
    duration: Option<TimeSpan>,
    /// Another number gives other robots
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Serve no dashboard
    #[arg(long)]
    headless: bool,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
}

impl Demo {
    pub fn run(self) -> Outcome {
        Runtime::new()?.block_on(self.run_to_its_end())
    }

    async fn run_to_its_end(self) -> Outcome {
        let Self { speed, duration, seed, headless, json } = self;
        let stop = stop_signal()?;
        let mut site = Site::start(Options { speed, seed, headless }).await?;
        if let Some(dashboard) = site.dashboard() {
            if let Some(usual) = Listen::default().http.filter(|usual| *usual != dashboard) {
                say(&format!("{usual} is taken by another program, so the dashboard is elsewhere"));
            }
            say(&format!("dashboard: http://{dashboard}"));
        }
        let end = duration.map(|TimeSpan(duration)| Millis(duration.0.into()));
        say("running; Ctrl-C ends it with a report");

        let begun = Instant::now();
        let mut display = Display::new(end);
        let ended = tokio::select! {
            ended = site.run(end, |progress| display.show(&progress)) => ended,
            () = stop => Ok(()),
        };
        display.clear();
        ended?;
        let (simulated, real) = (site.now(), begun.elapsed().as_secs_f64());
        let speed = simulated.0 as f64 / 1_000.0 / real;
        say(&format!("{} simulated in {real:.1} s, {speed:.0} times as fast as real time", clock(simulated)));
        let (report, violations) = site.finish().await;
        violations.iter().for_each(|violation| say(&format!("double grant: {violation}")));
        if json { out_json(&report) } else { out(&report.to_string()) }
    }
}

fn speed(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(speed) if (0.1..=1_000.0).contains(&speed) => Ok(speed),
        _ => Err("a speed is a number from 0.1 to 1000".to_owned()),
    }
}

/// Tells a person; standard output is for the report.
fn say(text: &str) {
    // Nothing is left to do where even standard error is closed.
    let _ = writeln!(anstream::stderr(), "{text}");
}

/// Shows how far the demo is: a bar on a terminal, now and then a line elsewhere.
enum Display {
    Bar(ProgressBar),
    Lines { next: Millis },
}

impl Display {
    fn new(end: Option<Millis>) -> Self {
        if !std::io::stderr().is_terminal() {
            return Self::Lines { next: Millis(0).after(LINE_EVERY) };
        }
        let (bar, template) = match end {
            Some(end) => (ProgressBar::new(end.0), "{bar:24.green} {msg}"),
            None => (ProgressBar::new_spinner(), "{spinner:.green} {msg}"),
        };
        // The templates are ours; should one be wrong, indicatif's own does.
        let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
        Self::Bar(bar.with_style(style))
    }

    fn show(&mut self, progress: &Progress) {
        match self {
            Self::Bar(bar) => {
                bar.set_position(progress.now.0);
                bar.set_message(line(progress));
            }
            Self::Lines { next } if progress.now >= *next => {
                *next = next.after(LINE_EVERY);
                say(&line(progress));
            }
            Self::Lines { .. } => {}
        }
    }

    fn clear(&self) {
        if let Self::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}

/// Hours, minutes and seconds.
fn clock(now: Millis) -> String {
    let seconds = now.0 / 1_000;
    format!("{:02}:{:02}:{:02}", seconds / 3_600, seconds / 60 % 60, seconds % 60)
}

fn line(progress: &Progress) -> String {
    let count = |activity| progress.robots.iter().filter(|&&robot| robot == activity).count();
    format!(
        "{}  {} working, {} waiting, {} approaching, {} docked, {} stranded; {} charges completed",
        clock(progress.now),
        count(Activity::Working),
        count(Activity::Waiting),
        count(Activity::Approaching),
        count(Activity::Docked) + count(Activity::Charging),
        count(Activity::Stranded),
        progress.charges_completed,
    )
}
