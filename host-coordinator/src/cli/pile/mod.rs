//! `chargehand pile`: ask a pile at a desk, watch it, clear its faults.

mod text;

use std::{
    error::Error,
    path::{Path, PathBuf},
    time::{SystemTime, UNIX_EPOCH},
};

use host_coordinator::{
    core::view::fault_name,
    desk::{
        answers::Answers,
        error::DeskError,
        run::{RunError, run},
        session::{Goal, Session},
    },
    keys::Keys,
    line::Address,
    provision::BAUD,
};
use protocol::{BootEpoch, CommandId, FaultCode, PileId, Trust};
use tokio::runtime;

use super::{Outcome, keys, live::LiveLine, out, out_json, out_json_line, stop::stop_signal};

/// Ask a pile on a desk what it does and what is wrong with it, and clear its faults
#[derive(clap::Args)]
pub struct Pile {
    /// The serial port it is at, such as /dev/ttyUSB0
    #[arg(long, global = true, value_name = "PATH", conflicts_with = "addr")]
    port: Option<PathBuf>,
    /// Where its line ends in the network
    #[arg(long, global = true, value_name = "HOST:PORT")]
    addr: Option<String>,
    /// The folder of its site, where the keys are
    #[arg(long, global = true, value_name = "DIR", conflicts_with = "insecure")]
    site: Option<PathBuf>,
    /// Speak without keys, with a pile whose image was built to
    #[arg(long, global = true)]
    insecure: bool,
    /// Print JSON
    #[arg(long, global = true)]
    json: bool,
    #[command(subcommand)]
    act: Act,
}

#[derive(clap::Subcommand)]
enum Act {
    /// Show what it does, what it measures and how it charges
    Status,
    /// Show what is wrong with it, and what to look at
    Faults,
    /// Show the passes it has counted and not handed on to the coordinator
    Passes,
    /// Show what it knows of all piles
    Table,
    /// Show what it does and measures, until Ctrl-C
    Watch,
    /// Clear a fault whose cause is gone
    ClearFault {
        /// The fault as `faults` names it, such as over_current
        #[arg(value_parser = fault_code)]
        code: FaultCode,
    },
}

impl Pile {
    pub fn run(self) -> Outcome {
        let goal = match self.act {
            Act::Status => Goal::Status,
            Act::Faults => Goal::Faults,
            Act::Passes => Goal::Passes,
            Act::Table => Goal::Table,
            Act::Watch => Goal::Watch,
            Act::ClearFault { code } => Goal::Clear(code),
        };
        let address = match (&self.port, &self.addr) {
            (Some(port), _) => Address::Serial(port.clone()),
            (None, Some(addr)) => Address::Tcp(addr.clone()),
            (None, None) => return Err("where is the pile? give --port PATH or --addr HOST:PORT".into()),
        };
        let keys = match (&self.site, self.insecure) {
            (Some(site), _) => keys_of(site)?,
            // Without keys any pile takes what is said to whichever.
            (None, true) => (vec![PileId(0)], Trust::Insecure),
            (None, false) => {
                return Err("whose pile is it? give --site DIR, where its keys are, or --insecure for an \
                            image that was built without"
                    .into());
            }
        };
        let json = self.json;
        if goal == Goal::Watch {
            let mut line = LiveLine::new();
            let watched = converse(&address, goal, keys, |answers| {
                if json { out_json_line(&answers.document()) } else { line.show(|| text::watch(answers)) }
            });
            line.close();
            return watched;
        }
        let mut last = None;
        converse(&address, goal, keys, |answers| {
            last = Some(answers.clone());
            Ok(())
        })?;
        match last {
            // Ctrl-C before the pile has answered.
            None => Err("ended before the pile has answered".into()),
            Some(answers) if json => out_json(&answers.document()),
            Some(answers) => out(&text::answers(&answers, &self.command())),
        }
    }

    /// The command as it was given, up to what to do.
    fn command(&self) -> String {
        let mut command = String::from("chargehand pile");
        let path = |path: &Path| path.display().to_string();
        let arguments = [
            ("--port", self.port.as_deref().map(path)),
            ("--addr", self.addr.clone()),
            ("--site", self.site.as_deref().map(path)),
        ];
        for (name, value) in arguments {
            command.extend(value.map(|value| format!(" {name} {value}")));
        }
        command + if self.insecure { " --insecure" } else { "" }
    }
}

/// The piles that are called, and what is believed.
type Called = (Vec<PileId>, Trust<Vec<protocol::Session>>);

/// Whether the pile has answered, and refused.
pub fn is_refusal(error: &RunError) -> bool {
    matches!(error, RunError::Desk(DeskError::Refused { .. }))
}

fn converse(
    address: &Address,
    goal: Goal,
    (called, trust): Called,
    mut answered: impl FnMut(&Answers) -> std::io::Result<()>,
) -> Outcome {
    let mut session = Session::new(goal, command(), called);
    runtime::Builder::new_current_thread().enable_all().build()?.block_on(async {
        let interrupt = stop_signal()?;
        let mut line = address.open(BAUD).await?;
        let mut hear = |answers: &Answers| Ok(answered(answers)?);
        match run(&mut *line, &mut session, || BootEpoch(unix_s()), trust, interrupt, &mut hear).await {
            // As it is: a closed pipe has to be seen.
            Err(RunError::Hearing(error)) => Err(error as Box<dyn Error>),
            other => Ok(other?),
        }
    })
}

fn keys_of(site: &Path) -> Result<Called, Box<dyn Error>> {
    Ok(Keys::load(&keys::file_in(site))?.piles())
}

/// Another number than that of the last run: a pile does nothing for a repeat.
fn command() -> CommandId {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    // Its lower bits; they come again after 49 days.
    CommandId(since.as_millis() as u32)
}

fn unix_s() -> u32 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    u32::try_from(since.as_secs()).unwrap_or(u32::MAX)
}

/// A fault by its name; case and what stands between its words do not matter.
fn fault_code(text: &str) -> Result<FaultCode, String> {
    let plain = |name: &str| name.replace(['_', '-', ' '], "").to_lowercase();
    let found = FaultCode::ALL.into_iter().find(|code| plain(fault_name(*code)) == plain(text));
    found.ok_or_else(|| {
        let names: Vec<_> = FaultCode::ALL.into_iter().map(fault_name).collect();
        format!("no such fault; there are {}", names.join(", "))
    })
}
