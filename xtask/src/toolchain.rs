//! The compiler for the boards' ARM core.
//!
//! Usually that is rustup's toolchain with the target added. Where rustup cannot fetch the target,
//! Debian's `rustc-web` compiles the standard library's `core` from its own sources
//! (`rust-web-src`) and then the image; rustup's toolchain still gives the linker.

use std::path::{Path, PathBuf};

use crate::command::{Command, Failure, cargo};

/// The Cortex-M4F of the STM32F407.
pub const TARGET: &str = "thumbv7em-none-eabihf";
/// The same core without its FPU.
pub const SOFT_FLOAT: &str = "thumbv7em-none-eabi";

/// Debian's packages of a recent compiler, its cargo and its library's sources.
pub const DEBIAN_PACKAGES: [&str; 3] = ["rustc-web", "cargo-web", "rust-web-src"];

/// What compiles for the ARM core.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Toolchain {
    target: &'static str,
    compiler: Compiler,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Compiler {
    /// Rustup's toolchain has the target.
    Rustup,
    /// Debian's compiler builds `core` first and links with this linker.
    Debian {
        /// Rustup's `rust-lld`.
        linker: PathBuf,
    },
}

impl Toolchain {
    /// The toolchain for `target` that is ready to use, if there is one.
    pub fn find(target: &'static str) -> Result<Option<Self>, Failure> {
        let sysroot = sysroot()?;
        if library(&sysroot, target).join("lib").is_dir() {
            return Ok(Some(Self { target, compiler: Compiler::Rustup }));
        }
        let linker = linker(&sysroot)?;
        let is_ready = linker.is_file() && debian_is_ready();
        Ok(is_ready.then_some(Self { target, compiler: Compiler::Debian { linker } }))
    }

    /// Whether rustup's clippy has a library for the target.
    pub const fn has_clippy(&self) -> bool {
        matches!(self.compiler, Compiler::Rustup)
    }

    /// `cargo arguments`, for the target.
    pub fn cargo(&self, arguments: &str) -> Command {
        match &self.compiler {
            Compiler::Rustup => cargo(arguments).words("--target").words(self.target),
            Compiler::Debian { linker } => Command::new("/usr/bin/cargo")
                .words(arguments)
                .words("-Zbuild-std=core,alloc --target")
                .words(self.target)
                .variable("RUSTC", "/usr/bin/rustc")
                .variable("RUSTDOC", "/usr/bin/rustdoc")
                // Building the library is an unstable feature of a stable compiler.
                .variable("RUSTC_BOOTSTRAP", "1")
                .variable(&linker_variable(self.target), linker.to_string_lossy()),
        }
    }
}

/// What cargo asks for the linker for `target`.
fn linker_variable(target: &str) -> String {
    format!("CARGO_TARGET_{}_LINKER", target.to_uppercase().replace('-', "_"))
}

/// Debian's compiler is installed, with its sources, and new enough for this workspace.
fn debian_is_ready() -> bool {
    let version = Command::new("/usr/bin/rustc").words("--version").output().ok();
    let sources = Command::new("/usr/bin/rustc").words("--print sysroot").output().is_ok_and(|sysroot| {
        Path::new(sysroot.trim()).join("lib/rustlib/src/rust/library/core/Cargo.toml").is_file()
    });
    let new_enough = version
        .as_deref()
        .and_then(|text| text.split_whitespace().nth(1))
        .and_then(minor_version)
        .zip(minor_version(env!("CARGO_PKG_RUST_VERSION")))
        .is_some_and(|(found, needed)| found >= needed);
    sources && new_enough && Path::new("/usr/bin/cargo").is_file()
}

/// The linker that comes with rustup's compiler.
fn linker(sysroot: &Path) -> Result<PathBuf, Failure> {
    Ok(library(sysroot, &host()?).join("bin/rust-lld"))
}

/// The target that programs for this machine are built for.
pub fn host() -> Result<String, Failure> {
    let verbose = Command::new("rustc").words("-vV").output()?;
    Ok(verbose.lines().find_map(|line| line.strip_prefix("host: ")).unwrap_or_default().into())
}

fn sysroot() -> Result<PathBuf, Failure> {
    Ok(PathBuf::from(Command::new("rustc").words("--print sysroot").output()?.trim()))
}

fn library(sysroot: &Path, target: &str) -> PathBuf {
    sysroot.join("lib/rustlib").join(target)
}

/// The 95 of `1.95.0` and `1.95`; all compilers are version 1.
fn minor_version(version: &str) -> Option<u32> {
    version.split('.').nth(1)?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fallback_builds_core_and_links_with_rustups_linker() {
        let compiler = Compiler::Debian { linker: "/toolchain/rust-lld".into() };
        let toolchain = Toolchain { target: TARGET, compiler };
        assert_eq!(
            toolchain.cargo("build").to_string(),
            "RUSTC=/usr/bin/rustc RUSTDOC=/usr/bin/rustdoc RUSTC_BOOTSTRAP=1 \
             CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER=/toolchain/rust-lld \
             /usr/bin/cargo build -Zbuild-std=core,alloc --target thumbv7em-none-eabihf"
        );
    }

    #[test]
    fn versions_are_compared_as_numbers() {
        assert!(minor_version("1.100.0") > minor_version("1.95"));
        assert_eq!(minor_version("nightly"), None);
    }
}
