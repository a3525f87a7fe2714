//! What a scheme tells of an accepted window, and why it ends.

use crate::condition46::{Condition46, Resultant};
use crate::side::SideError;
use interfaces::TimeWindow;
use thiserror::Error;

/// Whether to go on after a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Onward {
    /// On to the next window.
    Continue,
    /// The run was told to stop: end in order.
    Stop,
}

/// What a scheme tells of an accepted window.
#[derive(Clone, Copy, Debug)]
pub struct Accepted {
    /// The window, its iteration the last one solved.
    pub window: TimeWindow,
    /// Time at its end (s), as the schedule keeps it.
    pub time: f64,
    /// Number of the output due at its end, if one is.
    pub output: Option<u64>,
    /// Condition (46) of the window; nothing without a partner.
    pub condition46: Option<Condition46>,
    /// Resultant of the load under which the structure was solved, relaxation included; nothing without a
    /// partner.
    pub applied: Option<Resultant>,
}

/// Why a scheme ended before its end time.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SchemeError {
    /// A participant failed.
    #[error(transparent)]
    Side(#[from] SideError),
    /// The records could not be written.
    #[error("failed to record window {window}: {what}")]
    Record {
        /// The window.
        window: u64,
        /// What failed.
        what: String,
    },
    /// The iterations of a window did not converge, and the case says to stop then.
    #[error(
        "window {window} from t = {time} s, {size} s long, did not converge in {iterations} iterations: the residual is {relative:.1e} of the \
         values; raise coupling.convergence.max_iterations, loosen coupling.convergence.relative, or choose another coupling.acceleration.method"
    )]
    NotConverged {
        /// The window.
        window: u64,
        /// Its start (s).
        time: f64,
        /// Its size (s).
        size: f64,
        /// Iterations at that size.
        iterations: u32,
        /// The largest residual of a quantity over its values.
        relative: f64,
    },
    /// The two sides do not fit together.
    #[error("fluid and structure do not fit together:\n  {}", .0.join("\n  "))]
    Mismatch(Vec<String>),
    /// Bytes that are no state of this run.
    #[error("failed to go to a saved state: {0}")]
    Saved(#[from] words::bytes::Error),
}
