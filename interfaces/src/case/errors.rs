//! What is wrong with a case: all of it, each with its place, value and remedy.

use std::fmt;
use std::path::PathBuf;
use thiserror::Error;

/// One mistake in a case.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseError {
    /// Path of the key: `structure.material.density`, elements of lists by their index from 0. Empty where no
    /// key is to blame.
    pub key: String,
    /// Line in the file, from 1; none for a key that is not in the file.
    pub line: Option<usize>,
    /// Whether the value came from `--set`.
    pub overridden: bool,
    /// The value as written, where there is one.
    pub value: Option<String>,
    /// What is wrong.
    pub problem: String,
    /// What to do.
    pub remedy: String,
}

impl CaseError {
    /// A mistake at a key; line and value are filled in from the document.
    pub(super) fn new(key: impl Into<String>, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self {
            key: key.into(),
            line: None,
            overridden: false,
            value: None,
            problem: problem.into(),
            remedy: remedy.into(),
        }
    }
}

impl fmt::Display for CaseError {
    /// `line 12: structure.material.density = -5.0: must be positive; give the density in kg/m3`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.line, self.overridden) {
            (_, true) => write!(f, "--set: ")?,
            (Some(line), false) => write!(f, "line {line}: ")?,
            (None, false) => {}
        }
        match (self.key.as_str(), &self.value) {
            ("", _) => {}
            (key, Some(value)) => write!(f, "{key} = {value}: ")?,
            (key, None) => write!(f, "{key}: ")?,
        }
        write!(f, "{}; {}", self.problem, self.remedy)
    }
}

/// All mistakes of a case, in the order of their lines.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{}: {}:\n  {}", file.display(), count(errors.len()), errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n  "))]
pub struct CaseErrors {
    /// The file.
    pub file: PathBuf,
    /// The mistakes; at least one.
    pub errors: Vec<CaseError>,
}

fn count(errors: usize) -> String {
    if errors == 1 { "1 mistake".to_owned() } else { format!("{errors} mistakes") }
}
