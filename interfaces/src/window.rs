//! Time windows, as the coupler sets them.

use serde::{Deserialize, Serialize};

/// How many sub-steps a structure takes in a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SubSteps {
    /// So many, whatever stability would allow; the paper's choice is 100.
    Fixed(u32),
    /// As many as the participant's own stability limit asks.
    Stable,
}

impl SubSteps {
    /// The number, where the case gives one.
    pub fn count(self) -> Option<u32> {
        match self {
            Self::Fixed(count) => Some(count),
            Self::Stable => None,
        }
    }
}

/// A span of time to solve. Windows are counted by the coupler, which alone keeps the time; a participant
/// never adds up its own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimeWindow {
    /// Number of the window: 0, 1, 2, …; the number of windows accepted before it.
    pub index: u64,
    /// Which solution of this window it is: 0, 1, 2, …; each starts from the last accepted state.
    pub iteration: u32,
    /// Time at its start (s).
    pub start: f64,
    /// Its size (s); positive.
    pub size: f64,
    /// Sub-steps for a participant that sub-steps.
    pub sub_steps: SubSteps,
}

impl TimeWindow {
    /// Time at its end (s).
    pub fn end(&self) -> f64 {
        self.start + self.size
    }
}
