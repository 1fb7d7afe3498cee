//! `cargo xtask flash`: the package `flash` does it, which is built only for that and for its tests.

use clap::ValueEnum;

use crate::command::{Failure, cargo};
use crate::firmware;
use crate::toolchain::Toolchain;

/// A board.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Board {
    /// The charging pile's.
    Pile,
    /// The Mecanum chassis'.
    Chassis,
}

impl Board {
    /// What it is called on a command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pile => "pile",
            Self::Chassis => "chassis",
        }
    }

    /// The package with its images.
    pub const fn package(self) -> &'static str {
        match self {
            Self::Pile => "firmware-pile",
            Self::Chassis => "firmware-chassis",
        }
    }
}

/// Builds the image of a board and flashes it, or with `dry_run` only checks it.
pub fn flash(toolchain: &Toolchain, board: Board, dry_run: bool) -> Result<(), Failure> {
    firmware::compile_one(toolchain, board.package(), "stm32")?;
    let image = firmware::path(board.package(), "stm32");
    let options = if dry_run { "--dry-run" } else { "" };
    cargo("run --quiet --package flash --").args([image.to_string_lossy()]).words(options).run()
}
