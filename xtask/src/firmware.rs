//! The boards' images.

use std::path::PathBuf;

use crate::command::{Command, Failure};
use crate::toolchain::{TARGET, Toolchain};
use crate::{root, size};

/// What an image is built from: package, and the board it runs on. The board is a feature of the
/// package; the image is the package's binary of both names.
pub const IMAGES: [(&str, &str); 4] = [
    ("firmware-pile", "emulated"),
    ("firmware-pile", "stm32"),
    ("firmware-chassis", "emulated"),
    ("firmware-chassis", "stm32"),
];

/// Builds every image and prints its flash and RAM use.
pub fn build(toolchain: &Toolchain) -> Result<(), Failure> {
    compile(toolchain)?;
    size::print()
}

/// Builds every image.
pub fn compile(toolchain: &Toolchain) -> Result<(), Failure> {
    IMAGES.into_iter().try_for_each(|(package, board)| compile_one(toolchain, package, board))
}

/// Builds one image.
pub fn compile_one(toolchain: &Toolchain, package: &str, board: &str) -> Result<(), Failure> {
    cargo(toolchain, "build --quiet", package, board).run()
}

/// Clippy on what only exists on the ARM core; where rustup's clippy has no library for it, the
/// compiler's own warnings.
pub fn lints(toolchain: &Toolchain) -> impl Iterator<Item = Command> {
    IMAGES.into_iter().map(|(package, board)| {
        if toolchain.has_clippy() {
            cargo(toolchain, "clippy --quiet --no-deps", package, board).words("-- -D warnings")
        } else {
            cargo(toolchain, "check --quiet", package, board).variable("RUSTFLAGS", "-D warnings")
        }
    })
}

/// The documentation of the libraries with what only exists on the ARM core.
pub fn documentation(toolchain: &Toolchain) -> impl Iterator<Item = Command> {
    IMAGES.into_iter().map(|(package, board)| {
        toolchain
            .cargo("doc --quiet --release --no-deps --lib")
            .args(["--package", package, "--features", board])
            .variable("RUSTDOCFLAGS", "-D warnings")
    })
}

fn cargo(toolchain: &Toolchain, command: &str, package: &str, board: &str) -> Command {
    toolchain
        .cargo(command)
        // Whatever CARGO_TARGET_DIR says: the tests look for the image there.
        .words("--target-dir target --release --lib")
        .args(["--package", package, "--bin", &binary(package, board), "--features", board])
}

fn binary(package: &str, board: &str) -> String {
    format!("{package}-{board}")
}

/// Where cargo puts an image.
pub fn path(package: &str, board: &str) -> PathBuf {
    root().join("target").join(TARGET).join("release").join(binary(package, board))
}
