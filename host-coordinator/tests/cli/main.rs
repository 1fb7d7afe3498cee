//! The `chargehand` command as a person or a script meets it: the real binary, its output and
//! its exit code.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod check;
mod keys;
mod map;
mod plan;
mod provision;
mod replay;
mod reproduce;
mod select;
mod simulate;

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use host_coordinator::keys::Keys;
use tempfile::TempDir;

/// What a command left behind.
struct Ran {
    success: bool,
    stdout: String,
    stderr: String,
}

impl Ran {
    #[track_caller]
    fn succeeds(self) -> String {
        assert!(self.success, "failed: {}", self.stderr);
        assert_eq!(self.stderr, "");
        self.stdout
    }

    /// The error; a person must be told in words, not by a panic.
    #[track_caller]
    fn fails(self) -> String {
        assert!(!self.success, "succeeded: {}", self.stdout);
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
        assert!(!self.stderr.contains('\x1b'), "colours without a terminal: {:?}", self.stderr);
        self.stderr
    }
}

fn chargehand(arguments: &[&str]) -> Ran {
    let output = Command::new(env!("CARGO_BIN_EXE_chargehand")).args(arguments).output().unwrap();
    Ran {
        success: output.status.success(),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}

/// A site, as it is in the repository.
fn site(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../sites").join(name)
}

/// The site of LMPP.
fn fig7() -> PathBuf {
    site("lmpp-fig7")
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// A copy of a site, with keys.
fn copy_of(site: &Path) -> TempDir {
    let copy = tempfile::tempdir().unwrap();
    for entry in fs::read_dir(site).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), copy.path().join(entry.file_name())).unwrap();
    }
    Keys::change(&copy.path().join("keys.toml"), |keys| keys.make_site()).unwrap();
    copy
}

/// A copy of LMPP's site, with keys, in which `from` in `file` is replaced by `to`.
fn fig7_with(file: &str, from: &str, to: &str) -> TempDir {
    let copy = copy_of(&fig7());
    let path = copy.path().join(file);
    let before = fs::read_to_string(&path).unwrap();
    assert!(before.contains(from), "{file} has no {from:?}");
    fs::write(&path, before.replacen(from, to, 1)).unwrap();
    copy
}

/// Runs a command that prints JSON.
#[track_caller]
fn json(arguments: &[&str]) -> serde_json::Value {
    serde_json::from_str(&chargehand(&[arguments, &["--json"]].concat()).succeeds()).unwrap()
}
