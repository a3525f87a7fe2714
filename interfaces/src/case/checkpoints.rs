//! `[checkpoints]`: when the state of the whole run is written to the disk, to go on from.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// When states of the run are written from which it can go on (`docs/restart.md`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Checkpoints {
    /// Simulated time between two (s); none at such times if left out.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub every: Option<f64>,
    /// Time on the clock between two (s), 0 for none: a run that is shorter writes none by it.
    #[schemars(extend("minimum" = 0))]
    pub wall_interval: f64,
    /// How many are kept, the newest.
    #[schemars(extend("minimum" = 1, "maximum" = 1_000_000))]
    pub keep: u32,
    /// Whether a run that is told to stop (Ctrl-C, SIGTERM) writes one after the window at hand.
    pub at_stop: bool,
}

impl Default for Checkpoints {
    fn default() -> Self {
        Self { every: None, wall_interval: 600.0, keep: 2, at_stop: true }
    }
}
