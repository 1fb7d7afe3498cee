//! Reads a YAML document into a type and says in which line it fails.

use serde::de::DeserializeOwned;

/// A document is no YAML, or not what was expected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}{problem}", match line { Some(line) => format!("line {line}: "), None => String::new() })]
pub struct YamlError {
    /// The line, from 1; none if the document as a whole is meant.
    pub line: Option<usize>,
    /// What is wrong.
    pub problem: String,
}

/// Reads a document. Aliases may repeat only so much: a small file cannot fill the memory.
pub(super) fn read<T: DeserializeOwned>(text: &str) -> Result<T, YamlError> {
    let text = text.trim_start_matches('\u{feff}');
    let options = serde_saphyr::options! { with_snippet: false };
    serde_saphyr::from_str_with_options(text, options).map_err(|error| {
        let line = error.location().and_then(|location| usize::try_from(location.line()).ok());
        let problem = error.without_snippet().to_string();
        // The line is named once.
        let problem = problem.lines().next().unwrap_or_default();
        let problem = problem.split_once(" at line ").map_or(problem, |(problem, _)| problem);
        YamlError { line: line.filter(|&line| line > 0), problem: problem.to_owned() }
    })
}
