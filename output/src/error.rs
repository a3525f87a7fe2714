//! What can go wrong while the files of a run are written or read.

use std::path::{Path, PathBuf};

/// A failed operation on a file of a run; every variant names the file or the array it was about.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file or folder could not be written.
    #[error("failed to write {}: {source}", .path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A file could not be read.
    #[error("failed to read {}: {source}", .path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A file was read, but is not what its name says.
    #[error("failed to understand {}: {reason}", .path.display())]
    Parse {
        /// The file.
        path: PathBuf,
        /// What was found, and what was expected.
        reason: String,
    },
    /// A particle frame whose arrays do not fit its points.
    #[error("failed to lay out the particle frame at time {time} s: {reason}")]
    Frame {
        /// Time of the frame in s.
        time: f64,
        /// Which array, its length, and the length that would fit.
        reason: String,
    },
    /// A table row that does not fit the header.
    #[error("failed to write a row of {}: {found} values for {expected} columns", .path.display())]
    Row {
        /// The table.
        path: PathBuf,
        /// Values given.
        found: usize,
        /// Columns in the header.
        expected: usize,
    },
    /// The folder holds none of the files that a report is made from.
    #[error(
        "failed to find a run in {}: none of summary.json, windows.csv, probes.csv, fluid.pvd and structure.pvd \
         is there; name the folder that the run wrote (its --out)",
        .path.display()
    )]
    NoRun {
        /// The folder.
        path: PathBuf,
    },
}

/// Shorthand of this crate.
pub type Result<T> = std::result::Result<T, Error>;

pub(crate) fn write_error(path: &Path) -> impl FnOnce(std::io::Error) -> Error {
    let path = path.to_owned();
    move |source| Error::Write { path, source }
}

pub(crate) fn read_error(path: &Path) -> impl FnOnce(std::io::Error) -> Error {
    let path = path.to_owned();
    move |source| Error::Read { path, source }
}

pub(crate) fn parse_error(path: &Path, reason: impl Into<String>) -> Error {
    Error::Parse { path: path.to_owned(), reason: reason.into() }
}
