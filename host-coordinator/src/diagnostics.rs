//! Mistakes in files that people write, reported all at once as a compiler does.

use std::{
    fmt,
    path::{Path, PathBuf},
};

use serde::Serialize;

/// One mistake.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Diagnostic {
    /// The file it is in.
    pub file: PathBuf,
    /// The line, counted from 1; none if the file as a whole is meant.
    pub line: Option<usize>,
    /// What is wrong, naming the thing.
    pub problem: String,
    /// What was expected in its place.
    pub expected: String,
}

impl Diagnostic {
    /// A mistake in `file`.
    pub fn new(
        file: &Path,
        line: impl Into<Option<usize>>,
        problem: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        Self { file: file.into(), line: line.into(), problem: problem.into(), expected: expected.into() }
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, line, problem, expected } = self;
        write!(f, "{}", file.display())?;
        if let Some(line) = line {
            write!(f, ":{line}")?;
        }
        write!(f, ": {problem}, expected {expected}")
    }
}

/// All mistakes in a file and in those that it names; at least one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostics {
    file: PathBuf,
    mistakes: Vec<Diagnostic>,
}

impl Diagnostics {
    /// The mistakes found on reading `file`, or `value` if there are none.
    ///
    /// # Errors
    /// The mistakes, if there is one.
    pub fn check<T>(file: &Path, mut mistakes: Vec<Diagnostic>, value: Option<T>) -> Result<T, Self> {
        match value {
            Some(value) if mistakes.is_empty() => Ok(value),
            _ => {
                // In the order of the file named first, then of the lines.
                mistakes.sort_by(|a, b| {
                    (a.file != file, &a.file, a.line).cmp(&(b.file != file, &b.file, b.line))
                });
                Err(Self { file: file.into(), mistakes })
            }
        }
    }

    /// One mistake found on reading `file`.
    #[must_use]
    pub fn one(file: &Path, mistake: Diagnostic) -> Self {
        Self { file: file.into(), mistakes: vec![mistake] }
    }

    /// The mistakes, ordered by file and line.
    #[must_use]
    pub fn mistakes(&self) -> &[Diagnostic] {
        &self.mistakes
    }

    /// The mistakes, to be joined with those of another file.
    #[must_use]
    pub fn into_mistakes(self) -> Vec<Diagnostic> {
        self.mistakes
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mistakes = match self.mistakes.len() {
            1 => "a mistake".to_owned(),
            count => format!("{count} mistakes"),
        };
        write!(f, "found {mistakes} on reading {}; correct and try again:", self.file.display())?;
        self.mistakes.iter().try_for_each(|mistake| write!(f, "\n{mistake}"))
    }
}

impl std::error::Error for Diagnostics {}
