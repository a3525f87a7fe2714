//! What the coupling asks of a fluid.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Velocity of the structure over a window that the fluid meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StructureVelocity {
    /// Its displacement over the window's size. It answers a load of the window always in the load's
    /// direction, however stiff the structure.
    Mean,
    /// That at the window's end.
    End,
}

impl StructureVelocity {
    /// Share of `Δt F/m` by which a force held over a window changes this velocity of a free particle.
    pub fn compliance(self) -> f64 {
        match self {
            Self::Mean => 0.5,
            Self::End => 1.0,
        }
    }
}

/// Form of the load on the structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LoadForm {
    /// Transpose of the divergence through which the structure's velocity enters the pressure equation: equal
    /// and opposite by construction.
    Transpose,
    /// Pressure gradient at the structure's particles, Eq. (48) of the paper, over fluid and structure, with
    /// `p = 0` on dry structure particles.
    PressureGradient,
}
