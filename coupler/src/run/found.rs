//! What a checkpoint tells of the run that it is of.

use crate::records::Lengths;
use output::summary::Seam;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Folder of the checkpoints in that of a run.
pub const FOLDER: &str = "checkpoints";

/// What is told of a run that was saved.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Header {
    /// Version of meniscus.
    pub version: String,
    /// Hash of the case, as participants compare it.
    pub case_hash: String,
    /// The case as resolved.
    pub case: String,
    /// Accepted windows.
    pub windows: u64,
    /// Simulated time (s), as far as decimals tell; to the bit it is in the coupler's part.
    pub time: f64,
    /// Time that the run had taken (s).
    pub wall_seconds: f64,
    /// Bytes of the tables then.
    pub tables: Lengths,
    /// Where the run had gone on from a checkpoint.
    pub seams: Vec<Seam>,
}

/// A checkpoint that is whole.
#[derive(Clone, Debug)]
pub struct Found {
    /// Where it is.
    pub path: PathBuf,
    /// What is told of the run.
    pub header: Header,
}

impl Found {
    /// Whether it is of the run in the folder `out`.
    pub fn is_of(&self, out: &Path) -> bool {
        self.run().canonicalize().is_ok_and(|of| out.canonicalize().is_ok_and(|out| out == of))
    }

    /// The folder of its run.
    pub fn run(&self) -> &Path {
        self.path.parent().and_then(Path::parent).unwrap_or(Path::new("."))
    }

    /// Time that the run had taken (s).
    pub(super) fn wall_seconds(&self) -> f64 {
        self.header.wall_seconds
    }
}
