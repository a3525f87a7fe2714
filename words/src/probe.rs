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
    /// Moment of that force about the point (N·m): `mx`, `my`, `mz`; in two dimensions `mz` alone.
    Moment,
    /// Cauchy stress (Pa): `stress_xx`, `stress_yy`, `stress_xy`; in three dimensions `stress_xx`,
    /// `stress_yy`, `stress_zz`, `stress_xy`, `stress_yz`, `stress_xz`.
    Stress,
    /// Green–Lagrange strain (1), along the axes of the reference configuration: `strain_xx` and so on.
    Strain,
    /// Von Mises stress (Pa), that out of the plane included: `von_mises`.
    VonMisesStress,
    /// Water along a line (m), from its point on: `height`, where what is contiguous from there ends, and
    /// `top`, where the last of it ends; drops that fly alone are none, and both are 0 where there is none.
    SurfaceHeight,
    /// What crosses an area: `rate` (m³/s), the mean over the window, and `volume` (m³) since the start; in
    /// two dimensions m² of the plane, for one metre of depth.
    Flux,
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
            Self::Moment if dimension == 2 => &["mz"],
            Self::Moment => &["mx", "my", "mz"],
            Self::Stress if dimension == 2 => &["stress_xx", "stress_yy", "stress_xy"],
            Self::Stress => &["stress_xx", "stress_yy", "stress_zz", "stress_xy", "stress_yz", "stress_xz"],
            Self::Strain if dimension == 2 => &["strain_xx", "strain_yy", "strain_xy"],
            Self::Strain => &["strain_xx", "strain_yy", "strain_zz", "strain_xy", "strain_yz", "strain_xz"],
            Self::VonMisesStress => &["von_mises"],
            Self::SurfaceHeight => &["height", "top"],
            Self::Flux => &["rate", "volume"],
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

    /// Rows and columns of the components of a symmetric tensor, in their order.
    pub fn places(dimension: usize) -> &'static [(usize, usize)] {
        match dimension {
            2 => &[(0, 0), (1, 1), (0, 1)],
            _ => &[(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)],
        }
    }

    /// The SI unit of a component, in two dimensions that of one metre of depth.
    pub fn unit(self, component: &str) -> &'static str {
        match self {
            Self::Displacement
            | Self::Position
            | Self::Extent
            | Self::Centroid
            | Self::Spread
            | Self::SurfaceHeight => "m",
            Self::Velocity => "m/s",
            Self::Pressure | Self::Stress | Self::VonMisesStress => "Pa",
            Self::Force => "N",
            Self::Moment => "N*m",
            Self::Flux if component == "rate" => "m3/s",
            Self::Flux => "m3",
            Self::Strain | Self::HydrostaticError => "1",
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
            Self::Moment => "moment",
            Self::Stress => "stress",
            Self::Strain => "strain",
            Self::VonMisesStress => "von-mises-stress",
            Self::SurfaceHeight => "surface-height",
            Self::Flux => "flux",
            Self::Extent => "extent",
            Self::Centroid => "centroid",
            Self::Spread => "spread",
            Self::HydrostaticError => "hydrostatic-error",
        })
    }
}
