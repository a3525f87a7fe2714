//! What probes record.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;

/// What a probe records.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ProbeQuantity {
    /// Displacement (m): `ux`, `uy`, `uz`.
    Displacement,
    /// Position (m): `x`, `y`, `z`.
    Position,
    /// Velocity (m/s): `vx`, `vy`, `vz`.
    Velocity,
    /// Pressure (Pa): `p`.
    Pressure,
    /// Total force of the fluid (N; in two dimensions N per metre of depth): `fx`, `fy`, `fz`.
    Force,
    /// Outermost fluid (m), half a spacing beyond its particle's centre, particles that fly alone left out:
    /// `left`, `right`, `bottom`, `top`, `back`, `front`; none without fluid.
    Extent,
    /// Centroid (m): `x`, `y`, `z`; none without fluid.
    Centroid,
    /// Standard deviation of position along each axis (m), half the semi-axis of an ellipse: `sx`, `sy`,
    /// `sz`.
    Spread,
    /// Departure of the pressure from ρ g·(r − r₀), r₀ a point of the level surface, over the greatest of it
    /// (1): of all fluid deeper than one spacing, `max`, the largest magnitude, and `rms`.
    HydrostaticError,
}

impl ProbeQuantity {
    /// Names of its components in `dimension` dimensions.
    pub fn components(self, dimension: usize) -> &'static [&'static str] {
        match self {
            Self::Displacement => &["ux", "uy", "uz"][..dimension],
            Self::Position => &["x", "y", "z"][..dimension],
            Self::Velocity => &["vx", "vy", "vz"][..dimension],
            Self::Pressure => &["p"],
            Self::Force => &["fx", "fy", "fz"][..dimension],
            Self::Extent => &["left", "right", "bottom", "top", "back", "front"][..2 * dimension],
            Self::Centroid => &["x", "y", "z"][..dimension],
            Self::Spread => &["sx", "sy", "sz"][..dimension],
            Self::HydrostaticError => &["max", "rms"],
        }
    }

    /// Whether it is of the fluid in a box, and of no point.
    pub fn is_of_a_box(self) -> bool {
        matches!(self, Self::Extent | Self::Centroid | Self::Spread)
    }

    /// Its SI unit, in two dimensions that of one metre of depth.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Displacement | Self::Position | Self::Extent | Self::Centroid | Self::Spread => "m",
            Self::Velocity => "m/s",
            Self::Pressure => "Pa",
            Self::Force => "N",
            Self::HydrostaticError => "1",
        }
    }
}

impl fmt::Display for ProbeQuantity {
    /// As the case file writes it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Displacement => "displacement",
            Self::Position => "position",
            Self::Velocity => "velocity",
            Self::Pressure => "pressure",
            Self::Force => "force",
            Self::Extent => "extent",
            Self::Centroid => "centroid",
            Self::Spread => "spread",
            Self::HydrostaticError => "hydrostatic-error",
        })
    }
}
