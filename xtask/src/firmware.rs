//! The images that QEMU runs.

use std::path::PathBuf;

use crate::command::{Command, Failure};
use crate::toolchain::{TARGET, Toolchain};
use crate::{root, size};

/// What an image is built from: package, and the binary of its emulated board.
pub const IMAGES: [(&str, &str); 1] = [("firmware-pile", "emulated")];

/// Builds every image and prints its flash and RAM use.
pub fn build(toolchain: &Toolchain) -> Result<(), Failure> {
    for (package, binary) in IMAGES {
        cargo(toolchain, "build --quiet", package, binary).run()?;
    }
    size::print()
}

/// Clippy on what only exists on the ARM core; where rustup's clippy has no library for it, the
/// compiler's own warnings.
pub fn lints(toolchain: &Toolchain) -> impl Iterator<Item = Command> {
    IMAGES.into_iter().map(|(package, binary)| match toolchain {
        Toolchain::Rustup => {
            cargo(toolchain, "clippy --quiet --no-deps", package, binary).words("-- -D warnings")
        }
        Toolchain::Debian { .. } => {
            cargo(toolchain, "check --quiet", package, binary).variable("RUSTFLAGS", "-D warnings")
        }
    })
}

/// The documentation of the libraries with what only exists on the ARM core.
pub fn documentation(toolchain: &Toolchain) -> impl Iterator<Item = Command> {
    IMAGES.into_iter().map(|(package, binary)| {
        toolchain
            .cargo("doc --quiet --release --no-deps --lib")
            .args(["--package", package, "--features", binary])
            .variable("RUSTDOCFLAGS", "-D warnings")
    })
}

fn cargo(toolchain: &Toolchain, command: &str, package: &str, binary: &str) -> Command {
    toolchain
        .cargo(command)
        // Whatever CARGO_TARGET_DIR says: the tests look for the image there.
        .words("--target-dir target --release --lib")
        .args(["--package", package, "--bin", binary, "--features", binary])
}

/// Where cargo puts an image.
pub fn path(binary: &str) -> PathBuf {
    root().join("target").join(TARGET).join("release").join(binary)
}
