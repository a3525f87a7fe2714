//! Mistakes as they are found.

use super::errors::CaseError;

/// Collects mistakes.
#[derive(Debug, Default)]
pub struct Findings {
    /// Those found so far.
    pub(super) errors: Vec<CaseError>,
}

impl Findings {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.errors.is_empty()
    }

    /// A mistake at a key; its line and value are filled in from the file.
    pub fn add(&mut self, key: impl Into<String>, problem: impl Into<String>, remedy: impl Into<String>) {
        self.errors.push(CaseError::new(key, problem, remedy));
    }
}
