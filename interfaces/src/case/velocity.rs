//! How a body moves at the start.

use super::geometry::PerAxis;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use words::geometry::Face;

/// Velocity of a body at the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum InitialVelocity {
    /// The same everywhere (m/s).
    Uniform(#[schemars(with = "PerAxis<f64>")] Vec<f64>),
    /// A shape.
    Mode(CantileverVelocity),
}

/// First bending mode of a clamped beam, Eqs. (51)–(52) of the paper: `v(s) = tip_velocity · f(s)/f(L)`, with
/// s the distance from the clamped face, L the body's length across it, kL = 1.875 and
/// `f(s) = (cos kL + cosh kL)(cosh ks − cos ks) + (sin kL − sinh kL)(sinh ks − sin ks)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CantileverVelocity {
    /// Which shape; `cantilever` is the one there is.
    pub mode: VelocityMode,
    /// Face from which s counts.
    pub clamped_face: Face,
    /// Velocity at the opposite face (m/s).
    #[schemars(with = "PerAxis<f64>")]
    pub tip_velocity: Vec<f64>,
}

/// Shape of an initial velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VelocityMode {
    /// First bending mode of a clamped beam.
    Cantilever,
}
