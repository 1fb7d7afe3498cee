//! `flash IMAGE`: checks the image of a board against the chip's map and flashes it.

use std::fs;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use flash::check::erased;
use flash::{Chip, Image, check, chip, probe};

/// Checks the image of a board against the map of its chip and flashes it.
#[derive(Parser)]
#[command(name = "flash")]
struct Arguments {
    /// The ELF file.
    image: PathBuf,
    /// Only checks.
    #[arg(long)]
    dry_run: bool,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(Arguments { image: path, dry_run }: &Arguments) -> Result<(), Box<dyn std::error::Error>> {
    let bytes = fs::read(path).map_err(|error| {
        format!("cannot read {}: {error}; build it with `cargo xtask firmware`", path.display())
    })?;
    let image = Image::parse(&bytes).map_err(|error| {
        format!("{} cannot be flashed: {error}; build it with `cargo xtask firmware`", path.display())
    })?;
    let target = chip::target()?;
    let chip = Chip::of(&target)?;
    let problems = check(&image, &chip);
    if !problems.is_empty() {
        let list: String = problems.iter().map(|problem| format!("\n  {problem}")).collect();
        return Err(format!("{} is not to be flashed:{list}", path.display()).into());
    }
    let loader = probe::loader(&image, &target)?;
    for (address, data) in loader.data() {
        println!("{address:#010x}: {} bytes", data.len());
    }
    let sectors: Vec<String> =
        erased(&image, &chip).iter().map(|sector| format!("{:#010x}", sector.start)).collect();
    println!("sectors to erase: {}", sectors.join(" "));
    if *dry_run {
        println!("{} is fit for the {}; nothing was flashed", path.display(), chip::NAME);
        return Ok(());
    }
    probe::write(loader, target)?;
    println!("flashed and started");
    Ok(())
}
