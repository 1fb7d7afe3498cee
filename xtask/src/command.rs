//! Other programs, and what to say when they fail.

use std::ffi::OsStr;
use std::fs::File;
use std::path::Path;
use std::{fmt, io, process};

use crate::root;

/// What went wrong, why, and what to do next: one sentence.
#[derive(Debug, thiserror::Error)]
#[error("{problem}; {next}")]
pub struct Failure {
    problem: String,
    next: String,
}

impl Failure {
    /// `problem` names the thing and the cause, `next` the next step.
    pub fn new(problem: impl Into<String>, next: impl Into<String>) -> Self {
        Self { problem: problem.into(), next: next.into() }
    }
}

/// A program with its arguments and variables, run in the root of the repository. Shown as it would
/// be typed into a shell.
#[derive(Clone, Debug)]
pub struct Command {
    variables: Vec<(String, String)>,
    words: Vec<String>,
}

/// Cargo, by the toolchain in use, with `arguments` separated by blanks.
pub fn cargo(arguments: &str) -> Command {
    Command::new("cargo").words(arguments)
}

impl Command {
    /// `program` without arguments.
    pub fn new(program: &str) -> Self {
        Self { variables: Vec::new(), words: vec![program.into()] }
    }

    /// Adds the words of `line`, which are separated by blanks.
    pub fn words(self, line: &str) -> Self {
        self.args(line.split_whitespace())
    }

    /// Adds arguments.
    pub fn args(mut self, arguments: impl IntoIterator<Item = impl Into<String>>) -> Self {
        self.words.extend(arguments.into_iter().map(Into::into));
        self
    }

    /// Sets an environment variable.
    pub fn variable(mut self, name: &str, value: impl Into<String>) -> Self {
        self.variables.push((name.into(), value.into()));
        self
    }

    /// Runs it, its output going where ours goes.
    pub fn run(&self) -> Result<(), Failure> {
        let status = self.process()?.status().map_err(|error| self.cannot_start(&error))?;
        if status.success() {
            Ok(())
        } else {
            Err(Failure::new(format!("`{self}` failed ({status})"), "its own messages above say why"))
        }
    }

    /// Runs it and returns what it printed.
    pub fn output(&self) -> Result<String, Failure> {
        let output = self.process()?.output().map_err(|error| self.cannot_start(&error))?;
        if output.status.success() {
            return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
        }
        let errors = String::from_utf8_lossy(&output.stderr);
        let cause = errors.trim().lines().last().unwrap_or("it gave no reason").to_owned();
        Err(Failure::new(format!("`{self}` failed: {cause}"), "run it by hand to see all it says"))
    }

    /// Runs it, its output going into a file; whether it succeeded.
    pub fn logged(&self, log: &Path) -> Result<bool, Failure> {
        let file = |failed: io::Error| {
            Failure::new(format!("{} cannot be written: {failed}", log.display()), "look who owns its folder")
        };
        let output = File::create(log).map_err(file)?;
        let errors = output.try_clone().map_err(file)?;
        let status = self.process()?.stdout(output).stderr(errors).status();
        Ok(status.map_err(|error| self.cannot_start(&error))?.success())
    }

    fn process(&self) -> Result<process::Command, Failure> {
        let Some((program, arguments)) = self.words.split_first() else {
            return Err(Failure::new("there is no program to run", "report this as a defect of xtask"));
        };
        let mut process = process::Command::new(OsStr::new(program));
        process.args(arguments).envs(self.variables.iter().cloned()).current_dir(root());
        Ok(process)
    }

    fn cannot_start(&self, error: &io::Error) -> Failure {
        let program = self.words.first().map_or("", String::as_str);
        Failure::new(
            format!("`{self}` cannot be started: {error}"),
            format!("install {program} and try again"),
        )
    }
}

impl fmt::Display for Command {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, value) in &self.variables {
            write!(f, "{name}={} ", quoted(value))?;
        }
        f.write_str(&self.words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" "))
    }
}

fn quoted(word: &str) -> String {
    if word.contains(char::is_whitespace) { format!("'{word}'") } else { word.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_is_shown_as_it_would_be_typed() {
        let command = cargo("doc --no-deps").variable("RUSTDOCFLAGS", "-D warnings").args(["a b"]);
        assert_eq!(command.to_string(), "RUSTDOCFLAGS='-D warnings' cargo doc --no-deps 'a b'");
    }

    #[test]
    fn a_failing_program_and_a_missing_one_are_failures_that_name_it() {
        let failed = Command::new("false").run().unwrap_err().to_string();
        assert!(failed.contains("`false` failed"), "{failed}");
        let missing = Command::new("no-such-program").output().unwrap_err().to_string();
        assert!(missing.contains("install no-such-program"), "{missing}");
    }
}
