//! Runs libFuzzer on the targets in `fuzz/`.
//!
//! They are built as `cargo fuzz` does it, but with flags that a stable compiler has, so that nothing
//! but a C++ compiler has to be there. The flags go to the target alone, not to what runs in the
//! compiler.

use std::fs;
use std::path::PathBuf;

use serde_json::json;

use crate::command::{Command, Failure, cargo};
use crate::{root, setup, toolchain};

/// The targets, and how many inputs of each make a short test: a second or two.
const TARGETS: [(&str, u32); 6] = [
    ("deframer", 50_000),
    ("decoder", 80_000),
    ("r200", 30_000),
    ("mfrc522", 30_000),
    ("maps", 10_000),
    ("store", 2_000),
];

/// Counters and comparisons for libFuzzer in every function.
const FLAGS: &str = "-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
                     -Cllvm-args=-sanitizer-coverage-inline-8bit-counters \
                     -Cllvm-args=-sanitizer-coverage-pc-table \
                     -Cllvm-args=-sanitizer-coverage-trace-compares -Ccodegen-units=1";

/// When a run ends.
#[derive(Clone, Copy)]
enum Until {
    Seconds(u32),
    /// The same inputs every time.
    Inputs(u32),
}

/// What a run has done.
struct Figures {
    target: &'static str,
    /// Inputs, the corpus included.
    inputs: u64,
    /// Frames, replies or records in them.
    tried: u64,
    accepted: u64,
    /// Inputs in the repository.
    corpus: usize,
    /// Inputs that have reached more of the code than those.
    found: u64,
}

/// Runs every target for `seconds`.
pub fn run(seconds: u32, keep: bool, json: bool) -> Result<(), Failure> {
    let fuzzers = build()?;
    let mut all = Vec::new();
    for (target, _) in TARGETS {
        all.push(fuzzers.fuzz(target, Until::Seconds(seconds))?);
        if keep {
            fuzzers.keep(target)?;
        }
    }
    if json {
        let all: Vec<_> = all.iter().map(Figures::json).collect();
        println!("{}", json!(all));
    } else {
        all.iter().for_each(Figures::print);
    }
    Ok(())
}

/// The whole corpus and a few seconds more, by number of inputs.
pub fn test() -> Result<(), Failure> {
    let fuzzers = build()?;
    for (target, inputs) in TARGETS {
        fuzzers.fuzz(target, Until::Inputs(inputs))?.print();
    }
    Ok(())
}

/// The built targets.
struct Fuzzers {
    programs: PathBuf,
    /// Finds, logs, and inputs that fail.
    output: PathBuf,
}

fn build() -> Result<Fuzzers, Failure> {
    setup::cpp()?;
    let host = toolchain::host()?;
    // With a target named, what runs in the compiler gets no flags.
    cargo("build --quiet --release --manifest-path fuzz/Cargo.toml --target-dir target/fuzz --target")
        .args([&host])
        .variable("RUSTFLAGS", FLAGS)
        .run()?;
    let output = root().join("target/fuzz");
    Ok(Fuzzers { programs: output.join(host).join("release"), output })
}

impl Fuzzers {
    fn program(&self, target: &str) -> Command {
        Command::new(&self.programs.join(target).to_string_lossy())
    }

    /// Where a target's finds go, empty.
    fn finds(&self, target: &str) -> Result<PathBuf, Failure> {
        let folder = self.output.join("found").join(target);
        let made = match fs::remove_dir_all(&folder) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(error),
            _ => fs::create_dir_all(&folder),
        };
        made.map_err(|error| {
            Failure::new(format!("{} cannot be emptied: {error}", folder.display()), "look who owns it")
        })?;
        Ok(folder)
    }

    fn fuzz(&self, target: &'static str, until: Until) -> Result<Figures, Failure> {
        let log = self.output.join(format!("{target}.log"));
        let finds = self.finds(target)?;
        let limit = match until {
            Until::Seconds(seconds) => format!("-max_total_time={seconds}"),
            Until::Inputs(inputs) => format!("-runs={inputs}"),
        };
        let ran = self
            .program(target)
            // An input that takes ten seconds is a loop without an end.
            .words("-seed=1 -timeout=10 -print_final_stats=1")
            .args([limit, format!("-artifact_prefix={}/{target}-", self.output.display())])
            .args([finds.to_string_lossy(), corpus(target).to_string_lossy()])
            .logged(&log)?;
        let said = fs::read_to_string(&log).unwrap_or_default();
        if !ran {
            return Err(self.failure(target, &said, &log.to_string_lossy()));
        }
        Ok(Figures {
            target,
            inputs: stat(&said, "number_of_executed_units"),
            tried: stat(&said, "tried"),
            accepted: stat(&said, "accepted"),
            corpus: fs::read_dir(corpus(target)).map_or(0, Iterator::count),
            found: stat(&said, "new_units_added"),
        })
    }

    /// Keeps of the corpus and the finds the few that together reach all the code that they reach.
    fn keep(&self, target: &str) -> Result<(), Failure> {
        let log = self.output.join(format!("{target}-merge.log"));
        let (finds, corpus) = (self.output.join("found").join(target), corpus(target));
        let old = self.output.join("corpus").join(target);
        let moved = fs::create_dir_all(old.parent().unwrap_or(&old))
            .and_then(|()| if old.exists() { fs::remove_dir_all(&old) } else { Ok(()) })
            .and_then(|()| fs::rename(&corpus, &old))
            .and_then(|()| fs::create_dir(&corpus));
        moved.map_err(|error| {
            Failure::new(format!("{} cannot be renewed: {error}", corpus.display()), "look who owns it")
        })?;
        let folders = [&corpus, &old, &finds].map(|folder| folder.to_string_lossy());
        if self
            .program(target)
            .words("-set_cover_merge=1 -use_counters=0 -use_cmp=0")
            .args(folders)
            .logged(&log)?
        {
            return Ok(());
        }
        Err(Failure::new(
            format!("the corpus of {target} was not made small, see {}", log.display()),
            format!("`git restore {}`", corpus.display()),
        ))
    }

    fn failure(&self, target: &str, said: &str, log: &str) -> Failure {
        let written = said.lines().find_map(|line| line.split_once("Test unit written to "));
        let Some((_, input)) = written else {
            return Failure::new(
                format!("the fuzzer of {target} failed, see {log}"),
                "report it as a defect",
            );
        };
        let panic =
            said.lines().skip_while(|line| !line.contains("panicked at")).nth(1).unwrap_or("see there");
        Failure::new(
            format!("{target} does not bear the input {input}: {panic} ({log})"),
            format!("make a test of it; again: `{} {input}`", self.program(target)),
        )
    }
}

fn corpus(target: &str) -> PathBuf {
    root().join("fuzz/corpus").join(target)
}

/// A figure that libFuzzer, or a target, prints when it ends.
fn stat(said: &str, name: &str) -> u64 {
    let figure = said.lines().filter_map(|line| line.strip_prefix("stat::")?.split_once(':'));
    figure.filter(|(found, _)| *found == name).find_map(|(_, value)| value.trim().parse().ok()).unwrap_or(0)
}

impl Figures {
    fn print(&self) {
        let Self { target, inputs, tried, accepted, corpus, found } = self;
        println!(
            "{target:<9} {inputs:>9} inputs, {tried:>9} tried in them, {accepted:>8} accepted; corpus {corpus}, {found} new"
        );
    }

    fn json(&self) -> serde_json::Value {
        let Self { target, inputs, tried, accepted, corpus, found } = self;
        json!({ "target": target, "inputs": inputs, "tried": tried, "accepted": accepted, "corpus": corpus, "new": found })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_read_from_what_a_fuzzer_prints() {
        let said = "Done 9 runs in 1 second(s)\nstat::number_of_executed_units: 9\nstat::tried: 30\n";
        assert_eq!((stat(said, "number_of_executed_units"), stat(said, "tried")), (9, 30));
        assert_eq!(stat(said, "accepted"), 0);
    }
}
