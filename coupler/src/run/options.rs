//! What the command line sets of a run, and why a run did not complete.

use super::found::Found;
use crate::launch;
use crate::recording;
use crate::scenario::{Scenario, ScenarioError};
use crate::schemes::SchemeError;
use crate::side::SideError;
use interfaces::{ParticipantError, Role};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use thiserror::Error;

/// What the command line sets of a run.
#[derive(Default)]
pub struct Options {
    /// Folder of the outputs.
    pub out: PathBuf,
    /// Whether the participants are called in this process instead of being processes of their own.
    pub in_process: bool,
    /// Whether nothing is drawn on the terminal.
    pub quiet: bool,
    /// Whether a trace is written.
    pub trace: bool,
    /// Domain of shared memory, where it is not the usual one.
    pub domain: Option<String>,
    /// Becomes true when the run is told to stop.
    pub stop: Arc<AtomicBool>,
    /// Becomes true when somebody asks for a checkpoint; nothing where none are written, whatever the case
    /// says.
    pub checkpoints: Option<Arc<AtomicBool>>,
    /// The checkpoint that the run goes on from, its last seam the one there. Of another folder than the
    /// outputs', the run is a branch.
    pub from: Option<Found>,
    /// What shall be otherwise.
    pub scenario: Option<Scenario>,
    /// Where all that crosses to and from the participants is recorded; nothing where it is not. Not of a run
    /// that goes on from a checkpoint: what came before it would be missing.
    pub record: Option<Record>,
}

/// A recording that is asked for: see [`crate::recording`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Record {
    /// The file, which must not be there yet.
    pub path: PathBuf,
    /// Its bytes at most: the recording ends there, and the run goes on.
    pub limit: u64,
}

/// Why a run did not complete.
#[derive(Debug, Error)]
pub enum RunError {
    /// A participant failed, or the two do not fit together.
    #[error(transparent)]
    Scheme(#[from] SchemeError),
    /// A participant did not answer by its deadline.
    #[error("{source}\nwhen the deadline passed:\n{}\n{DEADLINE}", .waits.join("\n"))]
    Deadline {
        /// Who, and for what.
        source: SchemeError,
        /// Who waited for whom then, and what each did last, one line each.
        waits: Vec<String>,
    },
    /// A participant could not be started.
    #[error(transparent)]
    Launch(#[from] launch::LaunchError),
    /// Outputs could not be written.
    #[error(transparent)]
    Output(#[from] output::Error),
    /// A mistake of this program.
    #[error("the coupler panicked: {0}; this is a fault of meniscus, please report it with the case")]
    Panicked(String),
    /// The run failed, and its summary could not be written either.
    #[error("{run}; nor was its summary written: {summary}")]
    NoSummary {
        /// Why the run failed.
        run: Box<RunError>,
        /// Why there is no summary.
        summary: output::Error,
    },
    /// A participant that is not one of our solvers cannot be called in this process.
    #[error(
        "failed to call the {role} in this process: the case has another program for it ({role}.participant); leave out --in-process"
    )]
    NotInProcess {
        /// Which participant.
        role: Role,
    },
    /// A scenario is none of the participants'.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// A checkpoint cannot be used.
    #[error("failed to go on from {}: {what}", .path.display())]
    Checkpoint {
        /// Its file.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// There is none to go on from.
    #[error(
        "failed to find a checkpoint in {} to go on from{}; set checkpoints.every, or --checkpoint-every, and start the run anew",
        .path.display(),
        told(.refused)
    )]
    NoCheckpoint {
        /// The folder of the run.
        path: PathBuf,
        /// Why those that are there are none.
        refused: Vec<RunError>,
    },
    /// The run cannot be recorded as asked for.
    #[error(transparent)]
    Recording(#[from] recording::Error),
    /// The folder of the outputs holds something else.
    #[error("failed to use {} as the folder of the outputs: {what}; choose another with --out", .path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
}

/// What helps where a deadline passed.
const DEADLINE: &str = "where it computes, raise coupling.deadline (s); where it waits or is stopped, its log in the outputs may say for what";

fn told(refused: &[RunError]) -> String {
    refused.iter().map(|error| format!("\n  {error}")).collect()
}

impl From<SideError> for RunError {
    fn from(error: SideError) -> Self {
        Self::Scheme(error.into())
    }
}

impl RunError {
    /// The error, and, where a deadline passed, who waited for whom then.
    pub(super) fn with_waits(self, waits: impl FnOnce() -> Vec<String>) -> Self {
        match self {
            Self::Scheme(source) if Self::is_deadline_of(&source) => {
                Self::Deadline { source, waits: waits() }
            }
            other => other,
        }
    }

    fn is_deadline_of(error: &SchemeError) -> bool {
        matches!(error, SchemeError::Side(side) if matches!(side.source, ParticipantError::TimedOut { .. }))
    }

    /// Whether the run ended because it was told to.
    pub fn is_interruption(&self) -> bool {
        match self {
            Self::Scheme(SchemeError::Side(side)) => {
                matches!(side.source, ParticipantError::Interrupted { .. })
            }
            Self::NoSummary { run, .. } => run.is_interruption(),
            _ => false,
        }
    }
}
