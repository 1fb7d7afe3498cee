//! LabWired, which runs the images that are flashed, and the images that it can run.
//!
//! It lacks instructions of the FPU, so they are compiled for the same core without one; see the book.

use std::path::Path;

use clap::ValueEnum;

use crate::command::{Command, Failure, cargo};
use crate::flash::Board;
use crate::toolchain::{SOFT_FLOAT, Toolchain};
use crate::{apt, firmware, root, setup};

/// The release whose faults and gaps the images are known to bear.
const VERSION: &str = "0.25.0";

/// Everything that it needs; returns the compiler for the images.
pub fn set_up() -> Result<Toolchain, Failure> {
    install()?;
    setup::arm_toolchain(SOFT_FLOAT)
}

/// Builds the images.
pub fn compile(toolchain: &Toolchain) -> Result<(), Failure> {
    Board::value_variants()
        .iter()
        .try_for_each(|board| firmware::compile_one(toolchain, board.package(), "stm32"))
}

/// Boots a board and prints how long it takes to its Hello.
pub fn boot(board: Board) -> Result<(), Failure> {
    let toolchain = set_up()?;
    firmware::compile_one(&toolchain, board.package(), "stm32")?;
    cargo("run --quiet --package tests --bin boot --").args([board.name()]).run()
}

/// Installs it from PyPI into a place of its own.
fn install() -> Result<(), Failure> {
    let folder = root().join("target/labwired");
    let python = folder.join("bin/python");
    if version(&python).is_some_and(|version| version.trim() == VERSION) {
        return Ok(());
    }
    eprintln!("setup: installing LabWired {VERSION} into {}", folder.display());
    let next =
        format!("install Python 3.9 or newer with its venv module, and `pip install labwired=={VERSION}`");
    let environment =
        || Command::new("python3").words("-m venv --clear").args([folder.to_string_lossy()]).run();
    environment()
        // Debian has the module in a package of its own.
        .or_else(|_| apt::install(&["python3-venv"], None).and_then(|()| environment()))
        .and_then(|()| {
            Command::new(&python.to_string_lossy())
                .words("-m pip install --quiet --disable-pip-version-check")
                .args([format!("labwired=={VERSION}")])
                .run()
        })
        .map_err(|failure| Failure::new(format!("LabWired cannot be installed: {failure}"), next))
}

fn version(python: &Path) -> Option<String> {
    python.is_file().then(|| {
        Command::new(&python.to_string_lossy())
            .args(["-c", "import importlib.metadata as m; print(m.version('labwired'))"])
            .output()
            .ok()
    })?
}
