//! Finds what the boards need, and installs what is missing.

use std::env;
use std::path::Path;

use crate::apt;
use crate::command::{Command, Failure};
use crate::toolchain::{DEBIAN_PACKAGES, TARGET, Toolchain};

/// The emulator.
const QEMU: &str = "qemu-system-arm";

/// The first major version of QEMU whose STM32F405 runs the boards' images in real time.
pub const QEMU_MAJOR: u32 = 10;

/// The package managers other than apt that have QEMU: program, arguments, package.
const PACKAGE_MANAGERS: [(&str, &str, &str); 5] = [
    ("dnf", "install --assumeyes", "qemu-system-arm"),
    ("pacman", "-S --noconfirm", "qemu-system-arm"),
    ("zypper", "--non-interactive install", "qemu-arm"),
    ("apk", "add", "qemu-system-arm"),
    ("brew", "install", "qemu"),
];

/// Everything; returns the compiler for the ARM core.
pub fn all() -> Result<Toolchain, Failure> {
    let toolchain = arm_toolchain(TARGET)?;
    qemu()?;
    cpp()?;
    Ok(toolchain)
}

/// A C++ compiler for libFuzzer, installed if necessary.
pub fn cpp() -> Result<(), Failure> {
    if on_path("c++") {
        return Ok(());
    }
    eprintln!("setup: installing a C++ compiler");
    let installed = if on_path("apt-get") {
        apt::update().and_then(|()| apt::install(&["g++"], None))
    } else {
        Err(Failure::new("xtask knows its package for apt only", "use this system's own package manager"))
    };
    installed.map_err(|failure| {
        Failure::new(
            format!("there is no C++ compiler and none can be installed: {failure}"),
            "install one as `c++` by hand and try again",
        )
    })
}

/// The compiler for an ARM core, installed if necessary.
pub fn arm_toolchain(target: &'static str) -> Result<Toolchain, Failure> {
    if let Some(toolchain) = Toolchain::find(target)? {
        return Ok(toolchain);
    }
    eprintln!("setup: adding the Rust target {target}");
    let rustup = Command::new("rustup").words("target add").words(target).run();
    if let Some(toolchain) = Toolchain::find(target)? {
        return Ok(toolchain);
    }
    let cause = rustup.err().map_or_else(
        || format!("rustup added {target} to another toolchain than the one in use"),
        |failure| failure.to_string(),
    );
    eprintln!("setup: {cause}; using Debian's compiler instead");
    let next = format!("give rustup access to its server and run `rustup target add {target}`");
    if let Err(failure) = apt::update().and_then(|()| apt::install(&DEBIAN_PACKAGES, None)) {
        return Err(Failure::new(
            format!("the Rust target {target} cannot be had, nor Debian's compiler instead of it: {failure}"),
            next,
        ));
    }
    Toolchain::find(target)?.ok_or_else(|| {
        Failure::new(
            format!(
                "the Rust target {target} cannot be had, and Debian's rustc-web is older than {} or rustup's \
                 rust-lld is missing",
                env!("CARGO_PKG_RUST_VERSION")
            ),
            next,
        )
    })
}

/// QEMU of a version that can emulate the boards, installed if necessary.
pub fn qemu() -> Result<(), Failure> {
    if qemu_version().is_some_and(|major| major >= QEMU_MAJOR) {
        return Ok(());
    }
    eprintln!("setup: installing {QEMU} {QEMU_MAJOR} or newer");
    let next = format!("install {QEMU} {QEMU_MAJOR} or newer by hand, put it on the PATH, and try again");
    let installed =
        if on_path("apt-get") { apt::install_qemu(QEMU, QEMU_MAJOR) } else { install_elsewhere() };
    if let Err(failure) = installed {
        return Err(Failure::new(format!("{QEMU} is missing and cannot be installed: {failure}"), next));
    }
    match qemu_version() {
        Some(major) if major >= QEMU_MAJOR => Ok(()),
        Some(major) => {
            Err(Failure::new(format!("this system's {QEMU} is version {major}, which is too old"), next))
        }
        None => Err(Failure::new(format!("{QEMU} was installed and still cannot be run"), next)),
    }
}

fn install_elsewhere() -> Result<(), Failure> {
    let Some((program, arguments, package)) =
        PACKAGE_MANAGERS.into_iter().find(|(program, ..)| on_path(program))
    else {
        let known = PACKAGE_MANAGERS.map(|(program, ..)| program).join(", ");
        return Err(Failure::new(
            format!("there is no package manager that xtask knows (apt-get, {known})"),
            "use this system's own",
        ));
    };
    // Homebrew refuses to run as root.
    let command = if program == "brew" { Command::new(program) } else { as_root(program)? };
    command.words(arguments).words(package).run()
}

/// `program`, run as root: directly, or through sudo.
pub fn as_root(program: &str) -> Result<Command, Failure> {
    if Command::new("id").words("-u").output()?.trim() == "0" {
        Ok(Command::new(program))
    } else if on_path("sudo") {
        Ok(Command::new("sudo").words(program))
    } else {
        Err(Failure::new(format!("{program} needs root and there is no sudo"), "run this as root"))
    }
}

fn on_path(program: &str) -> bool {
    env::var_os("PATH").is_some_and(|path| env::split_paths(&path).any(|folder| is_file(&folder, program)))
}

fn is_file(folder: &Path, name: &str) -> bool {
    folder.join(name).is_file()
}

/// The major version of the QEMU on the PATH.
fn qemu_version() -> Option<u32> {
    major_of(&Command::new(QEMU).words("--version").output().ok()?)
}

/// The 10 of "QEMU emulator version 10.0.2 (Debian …)".
fn major_of(text: &str) -> Option<u32> {
    text.split_once("version ")?.1.split('.').next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn qemus_version_is_read_from_what_it_prints() {
        assert_eq!(
            major_of("QEMU emulator version 7.2.19 (Debian 1:7.2+dfsg-7+deb12u15)\nCopyright"),
            Some(7)
        );
        assert_eq!(major_of("QEMU emulator version 10.0.2\n"), Some(10));
        assert_eq!(major_of("command not found"), None);
    }
}
