//! Coupling schemes, one file each, and a participant without a partner.

pub mod alone;
pub mod serial_explicit;

use crate::condition46::Condition46;
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
    /// Resultant of the load under which the structure was solved, relaxation included; nothing without a partner.
    pub applied: Option<crate::condition46::Resultant>,
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
    /// The two sides do not fit together.
    #[error("fluid and structure do not fit together:\n  {}", .0.join("\n  "))]
    Mismatch(Vec<String>),
}
