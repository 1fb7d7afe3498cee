//! `chargehand chassis`: drive a robot's chassis, watch it, record it.

use std::{
    error::Error,
    fs,
    path::{Path, PathBuf},
    time::{Duration, Instant, SystemTime, UNIX_EPOCH},
};

use host_coordinator::{
    chassis::{
        BAUD,
        outcome::{Report, SessionError},
        plot,
        recording::{Recorder, Speeds},
        run::{RunError, run},
        session::{Goal, Heard, Session},
        words,
    },
    line::Address,
};
use protocol::{BootEpoch, SiteMillis, SpeedMps, TurnRateRadps, Twist};
use serde_json::json;
use tokio::runtime;

use super::{Outcome, live::LiveLine, out, out_json, out_json_line, span::TimeSpan, stop::stop_signal};

/// Drive, watch and record a robot's chassis, in place of the robot's own computer
#[derive(clap::Args)]
pub struct Chassis {
    /// The serial port it is at, such as /dev/ttyUSB0
    #[arg(long, global = true, value_name = "PATH", conflicts_with = "addr")]
    port: Option<PathBuf>,
    /// Where its line ends in the network
    #[arg(long, global = true, value_name = "HOST:PORT")]
    addr: Option<String>,
    /// Print JSON
    #[arg(long, global = true)]
    json: bool,
    #[command(subcommand)]
    act: Act,
}

#[derive(clap::Subcommand)]
enum Act {
    /// Drive for a time or until Ctrl-C, then ramp to a stop
    Drive {
        /// Forward, in m/s
        #[arg(long, default_value = "0", allow_hyphen_values = true, value_parser = speed)]
        vx: SpeedMps,
        /// To the left, in m/s
        #[arg(long, default_value = "0", allow_hyphen_values = true, value_parser = speed)]
        vy: SpeedMps,
        /// Counter-clockwise, in rad/s
        #[arg(long, default_value = "0", allow_hyphen_values = true, value_parser = turn_rate)]
        wz: TurnRateRadps,
        /// For how long, such as 2s or 1.5m
        #[arg(long = "for", value_name = "TIME")]
        duration: Option<TimeSpan>,
        /// Record the drive
        #[arg(long, value_name = "FILE")]
        record: Option<PathBuf>,
    },
    /// Ramp to a stop
    Stop {
        /// Brake at once, and stay braked until `release`
        #[arg(long)]
        emergency: bool,
    },
    /// End a stop that is held after a fault or an emergency
    Release,
    /// Show how it moves, until Ctrl-C
    Watch,
    /// Record how it moves as MCAP, until Ctrl-C
    Record {
        /// The recording; one that is there is replaced
        file: PathBuf,
    },
    /// Draw commanded, ramped and measured speed of a recording as PNG
    Plot {
        /// The recording
        file: PathBuf,
        /// The picture; without it, FILE with .png in place of its ending
        #[arg(long, value_name = "PNG")]
        out: Option<PathBuf>,
    },
}

impl Chassis {
    pub fn run(self) -> Outcome {
        let Self { port, addr, json, act } = self;
        let goal = match &act {
            Act::Plot { file, out: picture } => return draw(file, picture.as_deref(), json),
            Act::Drive { vx, vy, wz, duration, .. } => Goal::Drive {
                twist: Twist { vx: *vx, vy: *vy, wz: *wz },
                duration: duration.map(|time| time.0),
            },
            Act::Stop { emergency } => Goal::Stop { emergency: *emergency },
            Act::Release => Goal::Release,
            Act::Watch | Act::Record { .. } => Goal::Listen,
        };
        let address = match (port, addr) {
            (Some(port), _) => Address::Serial(port),
            (None, Some(addr)) => Address::Tcp(addr),
            (None, None) => return Err("where is the chassis? give --port PATH or --addr HOST:PORT".into()),
        };
        let recording = match &act {
            Act::Drive { record, .. } => record.as_deref(),
            Act::Record { file } => Some(file.as_path()),
            _ => None,
        };
        let watch = matches!(act, Act::Watch).then(|| Screen::new(json));
        let report = converse(&address, goal, recording, watch)?;
        match act {
            Act::Watch => Ok(()),
            _ if json => out_json(&report),
            _ => out(&told(goal, &report)),
        }
    }
}

/// Whether the chassis has answered, and refused.
pub fn is_refusal(error: &RunError) -> bool {
    matches!(error, RunError::Session(SessionError::Refused { .. }))
}

/// Runs a session; what was recorded is kept even if it fails.
fn converse(
    address: &Address,
    goal: Goal,
    file: Option<&Path>,
    mut screen: Option<Screen>,
) -> Result<Report, Box<dyn Error>> {
    let wall = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let boot = BootEpoch(u32::try_from(wall.as_secs()).unwrap_or(u32::MAX));
    let mut session = Session::new(goal, SiteMillis(u64::try_from(wall.as_millis()).unwrap_or(u64::MAX)));
    let start = Instant::now();
    let mut recorder = None;
    let ran = runtime::Builder::new_current_thread().enable_all().build()?.block_on(async {
        let interrupt = stop_signal()?;
        let mut line = address.open(BAUD).await?;
        // Not before the line is open: a failed call must not empty an older recording.
        recorder = file.map(Recorder::create).transpose()?;
        let mut hear = |session: &Session, heard: &Heard| {
            if let Some(recorder) = &mut recorder {
                recorder.record(nanoseconds(wall + start.elapsed()), heard)?;
            }
            screen.as_mut().map_or(Ok(()), |screen| screen.show(session, heard))
        };
        match run(&mut *line, &mut session, boot, interrupt, &mut hear).await {
            // As it is: a closed pipe has to be seen.
            Err(RunError::Hearing(error)) => Err(error as Box<dyn Error>),
            other => Ok(other?),
        }
    });
    let finished = recorder.map_or(Ok(()), Recorder::finish);
    if let Some(screen) = screen {
        screen.line.close();
    }
    ran?;
    finished?;
    Ok(session.report())
}

fn draw(file: &Path, picture: Option<&Path>, json: bool) -> Outcome {
    let name = file.display();
    let bytes = fs::read(file).map_err(|error| format!("cannot read {name}: {error}"))?;
    let speeds = Speeds::read(&bytes).map_err(|error| format!("{name}: {error}"))?;
    let title = file.file_name().unwrap_or_default().to_string_lossy();
    let png = plot::png(&speeds, &title)?;
    let picture = picture.map_or_else(|| file.with_extension("png"), Path::to_path_buf);
    fs::write(&picture, png).map_err(|error| format!("cannot write {}: {error}", picture.display()))?;
    let (width, height) = plot::SIZE;
    if json {
        return out_json(
            &json!({ "png": picture, "width": width, "height": height, "samples": speeds.measured.len() }),
        );
    }
    out(&format!("{}: {width} x {height} pixels, {} samples", picture.display(), speeds.measured.len()))
}

fn told(goal: Goal, report: &Report) -> String {
    let robot = report.robot.map_or_else(|| "unknown".into(), |robot| robot.to_string());
    let because = report.stop.map_or("it was not told why", words::stop);
    let Report { done, reached, moved, .. } = report;
    match goal {
        Goal::Drive { .. } => format!(
            "robot {robot} drove: {:.3} m/s forward, {:.3} m/s left, {:.3} rad/s when the drive ended\n\
             moved    {:.3} m forward, {:.3} m left, turned {:.3} rad\n\
             commands {done} done\n\
             stopped  because {because}",
            reached.vx.get(),
            reached.vy.get(),
            reached.wz.get(),
            moved.x_m,
            moved.y_m,
            moved.yaw_rad,
        ),
        Goal::Stop { emergency: false } => format!("robot {robot} is braked because {because}"),
        Goal::Stop { emergency: true } => {
            format!("robot {robot} is braked because {because}, and stays so until `release`")
        }
        Goal::Release => format!("robot {robot} is released and waits for a command"),
        Goal::Listen => format!(
            "robot {robot} moved {:.3} m forward, {:.3} m left and turned {:.3} rad",
            moved.x_m, moved.y_m, moved.yaw_rad
        ),
    }
}

/// Where `watch` shows what it hears.
struct Screen {
    json: bool,
    line: LiveLine,
}

impl Screen {
    fn new(json: bool) -> Self {
        Self { json, line: LiveLine::new() }
    }

    fn show(&mut self, session: &Session, heard: &Heard) -> Result<(), Box<dyn Error + Send + Sync>> {
        match heard {
            Heard::Odometry(odometry) if self.json => out_json_line(&json!({ "odometry": odometry }))?,
            Heard::State(state) if self.json => out_json_line(&json!({ "state": state }))?,
            Heard::Odometry(odometry) => self.line.show(|| words::status(odometry, session.state()))?,
            Heard::State(_) => {}
        }
        Ok(())
    }
}

fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

fn speed(text: &str) -> Result<SpeedMps, String> {
    SpeedMps::new(number(text)?).map_err(|error| error.to_string())
}

fn turn_rate(text: &str) -> Result<TurnRateRadps, String> {
    TurnRateRadps::new(number(text)?).map_err(|error| error.to_string())
}

fn number(text: &str) -> Result<f32, String> {
    text.parse().map_err(|_| "expected a number".into())
}
