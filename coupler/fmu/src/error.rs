//! Why a unit cannot be a participant.

use std::path::PathBuf;

/// Why a unit cannot be a participant. Every message names its file.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The archive cannot be read or unpacked.
    #[error("failed to unpack the FMU {}: {what}", .file.display())]
    Archive {
        /// The unit.
        file: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// The model description is not one of a unit for co-simulation.
    #[error("failed to read modelDescription.xml of the FMU {}: {what}", .file.display())]
    Description {
        /// The unit.
        file: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// Ports and variables do not fit; one line each.
    #[error("the FMU {} does not fit the case in {} place(s):\n  {}", .file.display(), .mismatches.len(), .mismatches.join("\n  "))]
    Wiring {
        /// The unit.
        file: PathBuf,
        /// What does not fit.
        mismatches: Vec<String>,
    },
    /// The shared library cannot be opened, or lacks a function.
    #[error("failed to open the library of the FMU {}: {what}", .file.display())]
    Library {
        /// The unit.
        file: PathBuf,
        /// What the operating system said.
        what: String,
    },
    /// A function answered with an error.
    #[error("{function} of the FMU {} answered {status}{}", .file.display(), said(.words))]
    Call {
        /// The unit.
        file: PathBuf,
        /// The C function.
        function: String,
        /// Its status, in the standard's word.
        status: &'static str,
        /// What the unit told its logger last.
        words: String,
    },
    /// What the unit cannot do, and what to do about it.
    #[error("the FMU {} {what}", .file.display())]
    Incapable {
        /// The unit.
        file: PathBuf,
        /// What it cannot do, and the remedy.
        what: String,
    },
    /// Snapshots could not be written.
    #[error(transparent)]
    Output(#[from] output::Error),
}

fn said(words: &str) -> String {
    if words.is_empty() { String::new() } else { format!(": {words}") }
}
