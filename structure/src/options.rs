//! Choices of the method: `[structure.numerics]`.
//!
//! Comments, types, ranges and defaults are those of the case file, its schema and its documentation.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Largest fraction of the limit of stability that is allowed: the largest frequency rises with deformation
/// within a window, and the iteration finds it from below.
pub const SAFETY: f64 = 0.9;

/// The discrete gradient in the reference configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Gradient {
    /// Quadratic gradient and Hessian with a strain-gradient energy: right in bending from three particles
    /// through the thickness on.
    Quadratic,
    /// First-order-consistent corrected kernel gradient, Eqs. (35), (36) and (42): the paper's, too soft in
    /// bending.
    FirstOrder,
}

impl Gradient {
    /// Smoothing length over spacing where none is given: the paper's 1.2; 1.0 for the quadratic gradient.
    pub fn default_smoothing_ratio(self) -> f64 {
        match self {
            Self::FirstOrder => 1.2,
            Self::Quadratic => 1.0,
        }
    }
}

/// Numerics of the TLSPH structure. It is integrated by the classical Runge–Kutta method of fourth order,
/// Eqs. (43)–(45).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Options {
    /// Gradient operator.
    pub gradient: Gradient,
    /// Smoothing length over particle spacing, h/Δx.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub smoothing_ratio: f64,
    /// Factor ζ of the hourglass penalty of Ganzenmüller 2015; others run 0.01 to 0.1, 0 leaves it out.
    #[schemars(extend("minimum" = 0))]
    pub hourglass: f64,
    /// Mass-proportional damping: the acceleration is lessened by this times the velocity (1/s).
    #[schemars(extend("minimum" = 0))]
    pub damping: f64,
    /// Largest sub-step over the limit of stability of the Runge–Kutta method, at most 0.9; less keeps energy
    /// better, with its fifth power.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = SAFETY))]
    pub step_fraction: f64,
}

impl Options {
    /// What a gradient is run with when nothing else is said.
    pub fn of(gradient: Gradient) -> Self {
        Self {
            gradient,
            smoothing_ratio: gradient.default_smoothing_ratio(),
            hourglass: 0.0,
            damping: 0.0,
            step_fraction: SAFETY,
        }
    }
}

impl Default for Options {
    fn default() -> Self {
        Self::of(Gradient::Quadratic)
    }
}
