//! `cargo xtask`: sets up a machine, builds the boards' images, tests everything.
//!
//! One idea a module: [`setup`] finds or installs what is missing (through [`apt`] where it must),
//! [`toolchain`] is the compiler for the ARM core, [`firmware`] builds an image, [`mod@flash`] flashes
//! it, [`size`] and [`mod@bench`] measure one, [`soak`] simulates sites until they break, [`planning`] measures and checks planners, [`fuzz`] runs the fuzzer's targets, [`mod@test`] is what
//! the project's continuous integration runs. Whatever fails says why and what to do next, and ends
//! with exit code 1.

mod apt;
mod bench;
mod command;
mod firmware;
mod flash;
mod fuzz;
mod labwired;
mod planning;
mod setup;
mod size;
mod soak;
mod test;
mod toolchain;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use command::Failure;
use flash::Board;
use toolchain::TARGET;

/// Sets up a machine, builds the boards' images, tests everything.
#[derive(Parser)]
#[command(name = "cargo xtask")]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Installs what is missing: the ARM targets, QEMU, LabWired, a C++ compiler.
    Setup,
    /// Runs every check and every test, the quick ones first.
    Test,
    /// Builds the boards' images and prints their flash and RAM use.
    Firmware,
    /// Builds the boards' images, prints their flash and RAM use, and measures in QEMU how deep the stack
    /// gets.
    Size,
    /// Builds the image of a board, checks it against the chip's map, and flashes it through the debug
    /// probe that is plugged in.
    Flash {
        /// Which.
        board: Board,
        /// Only check it.
        #[arg(long)]
        dry_run: bool,
    },
    /// Boots the image of a board that is flashed in LabWired, and prints how long it takes to its Hello.
    Boot {
        /// Which.
        board: Board,
    },
    /// Measures: what the chassis' control ticks or the pile's frames cost, how many inputs the coordinator
    /// takes, or how long planning takes.
    Bench {
        /// What.
        #[command(subcommand)]
        what: Bench,
    },
    /// Feeds deframer, decoder, readers, maps and store what a fuzzer makes up.
    Fuzz {
        /// How long each target is fed, in seconds.
        #[arg(long, value_name = "S", default_value_t = 60)]
        seconds: u32,
        /// Adds to the corpus what has reached more of the code, and makes it small.
        #[arg(long)]
        keep: bool,
        /// Print JSON.
        #[arg(long)]
        json: bool,
    },
    /// Simulates 10,000 seeds of an hour with all faults, 50 robots and 13 piles, and checks every promise:
    /// up to an hour.
    Soak,
    /// Kills `chargehand run` 200 times under load over real sockets, and checks that it comes back with the
    /// same leases: some minutes.
    CrashLoop,
    /// Boots the pile's image in QEMU and shows its log.
    Emulate {
        /// Where USART1, the link to the coordinator, listens on this machine.
        #[arg(long, value_name = "PORT", default_value_t = 8491)]
        link: u16,
        /// Where USART2, the RFID reader, listens on this machine.
        #[arg(long, value_name = "PORT", default_value_t = 8492)]
        reader: u16,
    },
}

#[derive(Subcommand)]
enum Bench {
    /// The chassis' image, for 10,000 control ticks: about half a minute.
    Chassis {
        /// Print JSON.
        #[arg(long)]
        json: bool,
    },
    /// The pile's image: what it costs to seal and to open frames.
    Pile {
        /// Print JSON.
        #[arg(long)]
        json: bool,
    },
    /// The coordinator: inputs its core takes in a second, and how long a robot waits for its pile through real
    /// sockets and a synced log, with 500 robots and 200 piles: about a minute.
    Coordinator {
        /// Print JSON.
        #[arg(long)]
        json: bool,
    },
    /// Planners on maps with known optimal lengths, beside other crates: some minutes.
    Planning {
        /// A folder of maps (`.map`), each with its queries (`.map.scen` or `.scen`) beside it; the five in the
        /// repository if none is named.
        #[arg(long, value_name = "DIR")]
        maps: Option<PathBuf>,
        /// Print JSON.
        #[arg(long)]
        json: bool,
    },
}

fn main() -> ExitCode {
    let result = match Arguments::parse().task {
        Task::Setup => setup::all().and_then(|_| labwired::set_up()).map(|_| println!("setup: all is there")),
        Task::Test => test::all(),
        Task::Firmware => setup::arm_toolchain(TARGET).and_then(|toolchain| firmware::build(&toolchain)),
        Task::Size => size::measure(),
        Task::Flash { board, dry_run } => {
            setup::arm_toolchain(TARGET).and_then(|toolchain| flash::flash(&toolchain, board, dry_run))
        }
        Task::Boot { board } => labwired::boot(board),
        Task::Bench { what: Bench::Chassis { json } } => bench::chassis(json),
        Task::Bench { what: Bench::Pile { json } } => bench::pile(json),
        Task::Bench { what: Bench::Coordinator { json } } => bench::coordinator(json),
        Task::Bench { what: Bench::Planning { maps, json } } => planning::bench(maps.as_deref(), json),
        Task::Fuzz { seconds, keep, json } => fuzz::run(seconds, keep, json),
        Task::Soak => soak::all().iter().try_for_each(|command| command.run()),
        Task::CrashLoop => soak::crash_loop().run(),
        Task::Emulate { link, reader } => emulate(link, reader),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::FAILURE
        }
    }
}

fn emulate(link: u16, reader: u16) -> Result<(), Failure> {
    let toolchain = setup::all()?;
    firmware::build(&toolchain)?;
    command::cargo("run --quiet --package tests --bin emulate --")
        .args([link.to_string(), reader.to_string()])
        .run()
}

/// The root of the repository.
fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here).to_path_buf()
}
