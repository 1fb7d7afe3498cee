//! Every check and every test, in the order in which they fail soonest.

use std::time::{Duration, Instant};

use crate::command::{Command, Failure, cargo};
use crate::{firmware, fuzz, labwired, planning, setup, soak};

/// The steps that ran, and how long each took.
#[derive(Default)]
struct Steps {
    done: Vec<(&'static str, Duration)>,
}

/// Runs all steps; stops at the first that fails.
pub fn all() -> Result<(), Failure> {
    let mut steps = Steps::default();
    let finished = run(&mut steps);
    steps.summarise(finished.is_ok());
    finished
}

fn run(steps: &mut Steps) -> Result<(), Failure> {
    let fuzz = cargo("fmt --manifest-path fuzz/Cargo.toml --check");
    steps.commands("rustfmt", [cargo("fmt --all --check"), fuzz])?;
    let toolchain = steps.step("setup", "cargo xtask setup", setup::all)?;
    steps.step("firmware", "cargo xtask firmware", || firmware::build(&toolchain))?;
    let soft_float = steps.step("LabWired setup", "cargo xtask setup", labwired::set_up)?;
    steps.step("LabWired images", "cargo xtask boot", || labwired::compile(&soft_float))?;
    steps.commands("firmware lints", firmware::lints(&toolchain))?;
    steps.commands("clippy", [cargo("clippy --quiet --workspace --all-targets -- -D warnings")])?;
    let documentation = cargo("doc --quiet --workspace --no-deps").variable("RUSTDOCFLAGS", "-D warnings");
    steps.commands("documentation", [documentation])?;
    steps.commands("firmware documentation", firmware::documentation(&toolchain))?;
    steps.commands("tests", [cargo("test --quiet --workspace")])?;
    steps.commands("optimal lengths", [planning::check()])?;
    steps.commands("simulated sites", soak::some())?;
    steps.step("fuzzing", "cargo xtask fuzz", fuzz::test)
}

impl Steps {
    /// A step that is nothing but commands; each can be run alone as it is printed.
    fn commands(
        &mut self,
        name: &'static str,
        commands: impl IntoIterator<Item = Command>,
    ) -> Result<(), Failure> {
        for command in commands {
            self.step(name, &command.to_string(), || command.run())?;
        }
        Ok(())
    }

    fn step<T>(
        &mut self,
        name: &'static str,
        alone: &str,
        work: impl FnOnce() -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        println!("==> {name}: {alone}");
        let start = Instant::now();
        let result = work();
        self.done.push((name, start.elapsed()));
        result.map_err(|failure| {
            Failure::new(format!("{name}: {failure}"), format!("this step alone is `{alone}`"))
        })
    }

    fn summarise(&self, passed: bool) {
        println!();
        for (index, (name, took)) in self.done.iter().enumerate() {
            let verdict = if passed || index + 1 < self.done.len() { "passed" } else { "FAILED" };
            println!("{name:<22} {verdict} {:>8.1} s", took.as_secs_f64());
        }
        let total: Duration = self.done.iter().map(|(_, took)| *took).sum();
        println!("{:<22} {} {:>8.1} s", "all", if passed { "passed" } else { "FAILED" }, total.as_secs_f64());
    }
}
